// The kinds of values of a scene's keys. Each reads a value, gives its text, and says in words what it allows.
#pragma once

#include <algorithm>

#include "database/ray_columns.hpp"
#include "scene_keys.hpp"
#include "scene_sections.hpp"
#include "selectors.hpp"

namespace phynness::scene_detail {

/// A kind whose type says what is allowed.
struct AnyValue {
  std::string allowed() const { return ""; }
  /// Whether a member with this value is a default; otherwise it says that the key is absent.
  bool is_default(const auto&) const { return true; }
};

struct Number {
  Range range;
  static constexpr const char* type = "number";
  std::string allowed() const { return range.text(); }
  bool is_default(double value) const { return range.contains(value); }
  double read(const SceneTable& table, std::string_view key) const { return *table.number(key, range); }
  std::string text(double value) const { return shortest(value); }
};

struct NumberOrSearch : Number {
  static constexpr const char* type = "number or `\"search\"`";
  bool is_default(double) const { return true; }
  double read(const SceneTable& table, std::string_view key) const {
    const auto* word = table.find(key)->as_string();
    if (!word) return Number::read(table, key);
    if (word->get() != "search")
      table.reject(key, "is neither a number nor \"search\"", "write \"search\" or a number greater than 0");
    return 0;
  }
  std::string text(double value) const { return value > 0 ? shortest(value) : "search"; }
};

struct ThreeNumbers {
  Range range;
  static constexpr const char* type = "3 numbers";
  std::string allowed() const { return range.text(); }
  bool is_default(const Vec3& value) const { return range.contains(value[0]); }
  Vec3 read(const SceneTable& table, std::string_view key) const { return *table.vector(key, range); }
  std::string text(const Vec3& value) const { return exact_text(value); }
};

struct Integer : AnyValue {
  std::int64_t low, high;
  static constexpr const char* type = "integer";
  constexpr Integer(std::int64_t least, std::int64_t most) : low(least), high(most) {}
  std::string allowed() const { return "between " + std::to_string(low) + " and " + std::to_string(high); }
  std::int64_t read(const SceneTable& table, std::string_view key) const { return *table.integer(key, low, high); }
  std::string text(auto value) const { return std::to_string(value); }
};

struct Flag : AnyValue {
  static constexpr const char* type = "boolean";
  bool read(const SceneTable& table, std::string_view key) const { return table.flag(key); }
  std::string text(bool value) const { return value ? "true" : "false"; }
};

struct Text : AnyValue {
  static constexpr const char* type = "text";
  std::string read(const SceneTable& table, std::string_view key) const { return *table.text(key); }
  std::string text(const std::string& value) const { return value; }
  /// The folder of a file is omitted, because the mesh hash identifies the content.
  std::string text(const std::filesystem::path& file) const { return file.filename().string(); }
};

/// One of a list of values, each of which has a name.
template <class T>
struct OneOf {
  std::vector<T> values;
  const char* (*name)(T);
  static constexpr const char* type = "text";
  std::string allowed() const {
    std::vector<std::string> names;
    for (const T value : values) names.push_back(std::string("`\"").append(name(value)).append("\"`"));
    return listed({names.begin(), names.end()});
  }
  bool is_default(T value) const { return std::find(values.begin(), values.end(), value) != values.end(); }
  T read(const SceneTable& table, std::string_view key) const {
    std::vector<std::pair<std::string_view, T>> words;
    for (const T value : values) words.emplace_back(name(value), value);
    return *table.choice(key, words);
  }
  std::string text(T value) const { return name(value); }
};

struct DirectionSet : AnyValue {
  static constexpr const char* type = "integer or text";
  Directions read(const SceneTable& table, std::string_view) const { return parse_directions(table); }
  std::string text(Directions directions) const { return phynness::name(directions); }
};

/// [material] law, with the numbers of the law.
struct LawAndNumbers : AnyValue {
  static constexpr const char* type = "text";
  Material read(const SceneTable& table, std::string_view) const { return parse_material(table); }
  std::string text(const Material& material) const {
    std::string lines = phynness::name(material.law);
    for (std::size_t i = 0; i < material.parameters.size(); ++i)
      lines += "\nmaterial." + std::string(material.law->parameters[i].key) + " = " + shortest(material.parameters[i]);
    return lines;
  }
};

struct PronySeries : AnyValue {
  static constexpr const char* type = "table";
  Relaxation read(const SceneTable& table, std::string_view) const { return parse_relaxation(table); }
  std::string text(const Relaxation& relaxation) const { return relaxation.sentence(); }
};

template <Selection (*parse)(const SceneTable&, std::string_view)>
struct Selected : AnyValue {
  static constexpr const char* type = "selection";
  Selection read(const SceneTable& table, std::string_view key) const { return parse(table, key); }
  std::string text(const Selection& selection) const { return selection_text(selection); }
};
using Nodes = Selected<parse_selection>;
using CellsOfRegion = Selected<parse_cells>;

struct FieldNames : AnyValue {
  static constexpr const char* type = "array of text";
  std::vector<Field> read(const SceneTable& table, std::string_view) const { return parse_fields(table); }
  std::string text(const std::vector<Field>& fields) const { return names(fields, ", "); }
};

// A member may be optional, or of a narrower type than the value that is read: the kind has checked the range.
template <class T>
const T* if_given(const T& member) {
  return &member;
}
template <class T>
const T* if_given(const std::optional<T>& member) {
  return member ? &*member : nullptr;
}
template <class T, class Value>
void set(T& member, Value value) {
  member = static_cast<T>(std::move(value));
}
template <class T, class Value>
void set(std::optional<T>& member, Value value) {
  member = static_cast<T>(std::move(value));
}

/// A section of a scene, which makes the rows of its keys. `of` returns the object with the members.
template <class Of>
struct Section {
  std::string_view name;
  Of of;

  template <class Spec, class T, class Kind>
  SceneKey operator()(std::string_view key, T Spec::*member, const Kind& kind, bool is_hashed,
                      std::string_view meaning) const {
    const Spec standard;
    const auto* value = if_given(standard.*member);
    return {name,
            key,
            Kind::type,
            kind.allowed(),
            value && kind.is_default(*value) ? kind.text(*value) : "",
            meaning,
            is_hashed,
            [=, of = of](const SceneTable& table, Scene& scene) { set(of(scene).*member, kind.read(table, key)); },
            [=, of = of](const Scene& scene) {
              const auto* given = if_given(of(scene).*member);
              return given ? kind.text(*given) : "";
            }};
  }
};

template <class Of>
Section(std::string_view, Of) -> Section<Of>;  // clang 14 does not deduce it

template <class Spec>
auto section(std::string_view name, Spec Scene::*spec) {
  return Section{name, [spec](auto& scene) -> decltype(auto) { return (scene.*spec); }};
}

}  // namespace phynness::scene_detail
