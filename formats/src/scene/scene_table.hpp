// Typed access to a TOML table of a scene. Every error names file, line, value and remedy.
#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <optional>
#include <phynness/formats/scene.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace phynness::scene_detail {

/// Allowed numbers from low to high, where the end is excluded if `open`.
struct Range {
  double low, high;
  bool low_open = false, high_open = false;
  bool contains(double value) const;
  std::string text() const;  ///< "greater than 0 and at most 10"
};

inline constexpr std::int64_t most_increments = 1000;  // of a scene

/// The shortest decimal text that is read back as the same number.
std::string shortest(double value);
/// "[x, y, z]", each as shortest().
std::string exact_text(const Vec3& v);

/// Allowed coordinates of a scene in metres and in fractions of the bounding box.
inline constexpr Range metres{-1e3, 1e3}, fractions{-10, 10};

/// The TOML text of a node, shortened if it is long. @param levels  of tables and arrays that are shown
std::string shown(const toml::node& node, int levels = 16);

/// Throws the error "file:line: what: value" with its remedy. All errors of scenes are thrown here.
[[noreturn]] void refuse(const SourceLocation& where, const std::string& what, const std::string& value,
                         const std::string& remedy);

/// A list of words, each of which means a value.
template <class T>
using Words = std::vector<std::pair<std::string_view, T>>;

/// The names of a table's rows, each with its row.
template <class Row>
Words<const Row*> choices(std::span<const Row> rows) {
  Words<const Row*> words;
  for (const auto& row : rows) words.emplace_back(row.name, &row);
  return words;
}

/// @throws Error (input) with file and line if the text is not valid TOML or is nested too deeply
toml::table parse_toml(std::string_view text, const std::string& source_name);

class SceneTable {
 public:
  /// Refuses unknown keys. @param name  as in scene_keys.hpp
  SceneTable(const toml::table& table, std::string name, const std::string& file);
  /// An absent section, in which every key is missing; errors refer to line 1 of the file.
  SceneTable(std::string name, const std::string& file);

  /// Reads the keys that the table has.
  void read_into(Scene& scene) const;
  bool has(std::string_view key) const;
  const toml::node* find(std::string_view key) const;
  SourceLocation where() const { return _where; }
  /// The position of a key's value, or of the table if it does not have the key.
  SourceLocation where(std::string_view key) const;
  SourceLocation where(const toml::node& node) const;
  /// "[material] law", for messages.
  std::string label(std::string_view key) const;
  const std::string& file() const { return _file; }

  std::optional<double> number(std::string_view key, Range range) const;
  double number_or(std::string_view key, double otherwise, Range range) const;
  std::optional<std::int64_t> integer(std::string_view key, std::int64_t low, std::int64_t high) const;
  std::optional<std::string> text(std::string_view key) const;
  bool flag(std::string_view key) const;  ///< false without the key
  std::optional<Vec3> vector(std::string_view key, Range range) const;

  /// The value that belongs to the word of a key.
  template <class T>
  std::optional<T> choice(std::string_view key, const Words<T>& words) const {
    const auto given = text(key);
    if (!given) return std::nullopt;
    for (const auto& [word, value] : words)
      if (*given == word) return value;
    std::vector<std::string_view> names;
    for (const auto& [word, value] : words) names.push_back(word);
    refuse_choice(key, *given, names);
  }

  /// Throws an error about a missing key; `why` is appended to "... is missing".
  [[noreturn]] void missing(std::string_view key, const std::string& why, const std::string& remedy) const;
  /// Throws an error about the value of a key.
  [[noreturn]] void reject(std::string_view key, const std::string& what, const std::string& remedy) const;

 private:
  [[noreturn]] void refuse_choice(std::string_view key, const std::string& given,
                                  const std::vector<std::string_view>& names) const;
  [[noreturn]] void wrong_type(std::string_view key, const toml::node& node, const char* wanted,
                               const std::string& remedy) const;
  double checked_number(std::string_view key, const toml::node& node, Range range) const;

  const toml::table* _table = nullptr;
  std::string _name, _file;
  SourceLocation _where;
};

}  // namespace phynness::scene_detail
