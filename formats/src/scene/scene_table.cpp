#include "scene_table.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <locale>
#include <phynness/formats/error.hpp>
#include <phynness/formats/printable.hpp>
#include <sstream>

#include "scene_keys.hpp"

namespace phynness::scene_detail {
namespace {

// A scene needs no dotted keys, and at most one dot in a file name or a sentence of each title.
constexpr int most_dots = 128;

[[noreturn]] void refuse_depth(const SourceLocation& where, const std::string& value, const char* remedy) {
  refuse(where, "keys, tables or arrays are nested too deeply", value, remedy);
}

/// Limits the parts of dotted keys, each of which is a table: 20,000 tables within each other overflow the stack when
/// they are destroyed. toml++ limits brackets only. Dots in strings and comments count; the point of a number does not,
/// which is the first dot of a word and behind digits only. A key therefore has at most 2 most_dots + 2 parts.
void require_few_dots(std::string_view text, const std::string& source_name) {
  int line = 1, dots = 0;
  bool in_word = false, digits_only = false;
  for (const char c : text) {
    const bool digit = c >= '0' && c <= '9';
    if (c == '\n') ++line, dots = 0;
    if (c == '.' && !(in_word && digits_only) && ++dots > most_dots)
      refuse_depth({source_name, line}, "more than " + std::to_string(most_dots) + " dots in a line",
                   "shorten the dotted key, or break the line");
    const bool sign = c == '-' || c == '+';
    const bool word = digit || c == '.' || c == '_' || (sign && in_word) || std::isalpha(static_cast<unsigned char>(c));
    digits_only = digit && (digits_only || !in_word);
    in_word = word;
  }
}

const char* type_name(const toml::node& node) {
  // In the order of toml::node_type.
  constexpr const char* names[] = {
      "nothing", "a table", "an array", "text", "an integer", "a number with a decimal point", "true or false"};
  const auto type = static_cast<std::size_t>(node.type());
  return type < std::size(names) ? names[type] : "a date or time";
}

}  // namespace

bool Range::contains(double value) const {
  return (low_open ? value > low : value >= low) && (high_open ? value < high : value <= high);
}

std::string Range::text() const {
  std::string words;
  if (std::isfinite(low)) words = (low_open ? "greater than " : "at least ") + shortest(low);
  if (std::isfinite(low) && std::isfinite(high)) words += " and ";
  if (std::isfinite(high)) words += (high_open ? "less than " : "at most ") + shortest(high);
  return words;
}

std::string exact_text(const Vec3& v) {
  return std::string("[") + shortest(v[0]) + ", " + shortest(v[1]) + ", " + shortest(v[2]) + "]";
}

std::string shortest(double value) { return number_text(value); }

std::string shown(const toml::node& node, int levels) {
  if (levels == 0) return "...";
  if (const auto* number = node.as_floating_point()) return shortest(number->get());
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  if (const auto* table = node.as_table()) {
    stream << "{ ";
    bool first = true;
    for (const auto& [key, value] : *table) {
      stream << (first ? "" : ", ") << key.str() << " = " << shown(value, levels - 1);
      first = false;
    }
    stream << (first ? "}" : " }");
  } else if (const auto* array = node.as_array()) {
    stream << "[";
    for (std::size_t i = 0; i < array->size(); ++i) stream << (i ? ", " : "") << shown((*array)[i], levels - 1);
    stream << "]";
  } else {
    stream << toml::default_formatter{node};
  }
  std::string text = stream.str();
  constexpr std::size_t longest = 120;
  if (text.size() > longest) text = text.substr(0, longest) + " ...";
  return text;
}

void refuse(const SourceLocation& where, const std::string& what, const std::string& value, const std::string& remedy) {
  throw input_error(where.str() + ": " + what, value, remedy);
}

toml::table parse_toml(std::string_view text, const std::string& source_name) {
  require_few_dots(text, source_name);
  try {
    return toml::parse(text, source_name);
  } catch (const toml::parse_error& error) {
    const auto at = error.source().begin;
    const std::string reason(error.description());
    if (reason.find("maximum nested") != std::string::npos)
      refuse_depth({source_name, static_cast<int>(at.line)}, reason, "close the brackets");
    throw input_error(
        source_name + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": the file is not valid TOML",
        reason, "correct the syntax at this line and column (https://toml.io)");
  }
}

SceneTable::SceneTable(const toml::table& table, std::string name, const std::string& file)
    : _table(&table), _name(std::move(name)), _file(file), _where{file, static_cast<int>(table.source().begin.line)} {
  if (_where.line < 1) _where.line = 1;
  const auto& known = keys_of(_name);
  for (const auto& [key, value] : table) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    SourceLocation at{file, static_cast<int>(key.source().begin.line)};
    if (at.line < 1) at = where(value);
    refuse(at, std::string("unknown key") + (_name.empty() ? "" : " in [" + _name + "]"),
           std::string(key.str()) + " = " + shown(value), remedy_for_unknown_key(_name, key.str()));
  }
}

SceneTable::SceneTable(std::string name, const std::string& file)
    : _name(std::move(name)), _file(file), _where{file, 1} {}

const toml::node* SceneTable::find(std::string_view key) const { return _table ? _table->get(key) : nullptr; }
void SceneTable::read_into(Scene& scene) const {
  for (const auto& key : key_rows())
    if (key.section == _name && has(key.name)) key.read(*this, scene);
}
bool SceneTable::has(std::string_view key) const { return find(key) != nullptr; }

SourceLocation SceneTable::where(const toml::node& node) const {
  const auto line = static_cast<int>(node.source().begin.line);
  return {_file, line > 0 ? line : _where.line};
}
SourceLocation SceneTable::where(std::string_view key) const {
  const auto* node = find(key);
  return node ? where(*node) : _where;
}
std::string SceneTable::label(std::string_view key) const {
  return (_name.empty() ? "" : "[" + _name + "] ") + std::string(key);
}

void SceneTable::missing(std::string_view key, const std::string& why, const std::string& remedy) const {
  refuse(_where, label(key) + " is missing" + why, "", remedy);
}
void SceneTable::reject(std::string_view key, const std::string& what, const std::string& remedy) const {
  const auto* node = find(key);
  refuse(where(key), label(key) + " " + what, node ? shown(*node) : "", remedy);
}
void SceneTable::wrong_type(std::string_view key, const toml::node& node, const char* wanted,
                            const std::string& remedy) const {
  refuse(where(node), label(key) + " must be " + wanted + ", not " + type_name(node), shown(node), remedy);
}
void SceneTable::refuse_choice(std::string_view key, const std::string& given,
                               const std::vector<std::string_view>& names) const {
  const auto near = nearest(given, names);
  refuse(where(key), label(key) + " has an unknown value", "\"" + given + "\"",
         "write one of " + listed(names) + (near.empty() ? "" : "; did you mean \"" + std::string(near) + "\"?"));
}

double SceneTable::checked_number(std::string_view key, const toml::node& node, Range range) const {
  double value = 0;
  if (const auto* real = node.as_floating_point())
    value = real->get();
  else if (const auto* whole = node.as_integer())
    value = static_cast<double>(whole->get());
  else
    wrong_type(key, node, "a number", "write a plain SI number without quotes, such as 0.028 or 2e4");
  if (!std::isfinite(value))
    refuse(where(node), label(key) + " must be a finite number", shown(node), "write a number " + range.text());
  const bool is_length = key.ends_with("_m") && key != "j_m";  // J_m of Gent's law has no unit
  if (!range.contains(value))
    refuse(where(node), label(key) + " must be " + range.text(), shown(node),
           is_length              ? "correct the value; it is in metres, not in mm"
           : key.ends_with("_Pa") ? "correct the value; it is in Pa, not in kPa"
                                  : "correct the value");
  return value;
}

std::optional<double> SceneTable::number(std::string_view key, Range range) const {
  const auto* node = find(key);
  return node ? std::optional(checked_number(key, *node, range)) : std::nullopt;
}
double SceneTable::number_or(std::string_view key, double otherwise, Range range) const {
  return number(key, range).value_or(otherwise);
}

std::optional<std::int64_t> SceneTable::integer(std::string_view key, std::int64_t low, std::int64_t high) const {
  const auto* node = find(key);
  if (!node) return std::nullopt;
  const auto* whole = node->as_integer();
  if (!whole) {
    const auto* real = node->as_floating_point();
    wrong_type(key, *node, "an integer",
               real && std::isfinite(real->get()) && std::abs(real->get()) < 1e15
                   ? "write it without a decimal point, as " + shortest(std::round(real->get()))
                   : "write an integer without quotes");
  }
  const auto value = whole->get();
  if (value < low || value > high)
    refuse(where(*node), label(key) + " must be between " + std::to_string(low) + " and " + std::to_string(high),
           shown(*node), "correct the value");
  return value;
}
std::optional<std::string> SceneTable::text(std::string_view key) const {
  const auto* node = find(key);
  if (!node) return std::nullopt;
  const auto* string = node->as_string();
  if (!string) wrong_type(key, *node, "text", "put the value between double quotes");
  return string->get();
}

bool SceneTable::flag(std::string_view key) const {
  const auto* node = find(key);
  if (!node) return false;
  const auto* flag = node->as_boolean();
  if (!flag) wrong_type(key, *node, "true or false", "write true or false, lower case and without quotes");
  return flag->get();
}

std::optional<Vec3> SceneTable::vector(std::string_view key, Range range) const {
  const auto* node = find(key);
  if (!node) return std::nullopt;
  const auto* array = node->as_array();
  if (!array || array->size() != 3)
    wrong_type(key, *node, "three numbers", "write an array of exactly three numbers, such as [0.0, 0.0, 0.1]");
  Vec3 value{};
  for (std::size_t i = 0; i < 3; ++i) value[i] = checked_number(key, (*array)[i], range);
  return value;
}

}  // namespace phynness::scene_detail
