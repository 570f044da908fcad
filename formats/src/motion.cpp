#include <phynness/formats/motion.hpp>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <phynness/formats/error.hpp>

namespace phynness {
namespace {

using nlohmann::json;

/// No model answers more, and differences of such numbers are finite.
constexpr double largest_number = 1e300;

const char* const how = "record the motion again, or see formats/motion.md";

/// A value of the file with its place, for messages.
class Entry {
 public:
  Entry(const json& value, const std::string& file, std::string place)
      : _value(value), _file(file), _place(std::move(place)) {}

  [[noreturn]] void refuse(const std::string& what, const std::string& remedy = how) const {
    const bool is_long = _value.is_structured() && _value.size() > 10;
    throw input_error(_file + ": " + (_place.empty() ? "the file" : _place) + " " + what,
                      is_long ? std::string() : _value.dump(-1, ' ', false, json::error_handler_t::replace), remedy);
  }
  const json& value() const { return _value; }
  std::size_t size() const { return _value.size(); }
  bool has(const char* key) const { return _value.contains(key); }

  /// @throws Error (input) unless this is an object with this key
  Entry operator[](const char* key) const {
    if (!_value.is_object()) refuse("must be a JSON object");
    const auto found = _value.find(key);
    if (found == _value.end())
      throw input_error(_file + ": a key is missing", (_place.empty() ? "" : _place + ".") + key, how);
    return {*found, _file, (_place.empty() ? "" : _place + ".") + key};
  }
  Entry at(std::size_t i) const { return {_value[i], _file, _place + "[" + std::to_string(i) + "]"}; }

  const Entry& list_of(std::size_t least, std::size_t most) const {
    if (!_value.is_array()) refuse("must be a list");
    if (size() < least || size() > most)
      refuse("must have " +
             (least == most ? std::to_string(least) : std::to_string(least) + " to " + std::to_string(most)) +
             " entries, not " + std::to_string(size()));
    return *this;
  }
  double number() const {
    if (!_value.is_number()) refuse("must be a number");
    const double x = _value.get<double>();  // a number in JSON is finite
    if (std::abs(x) > largest_number) refuse("must not be larger than 1e300");
    return x;
  }
  std::int32_t node() const {
    if (!_value.is_number_integer()) refuse("must be the number of a node, an integer");
    const bool fits = _value.is_number_unsigned() && _value.get<std::uint64_t>() <= 0x7fffffffU;
    if (!fits) refuse("must be the number of a node, from 0 to 2147483647");
    return _value.get<std::int32_t>();
  }
  std::string text() const {
    if (!_value.is_string()) refuse("must be a text");
    return _value.get<std::string>();
  }
  /// Empty: null.
  std::optional<Motion::Vector> vector() const {
    if (_value.is_null()) return {};
    list_of(3, 3);
    return Motion::Vector{at(0).number(), at(1).number(), at(2).number()};
  }

 private:
  const json& _value;
  const std::string& _file;
  std::string _place;
};

/// Lists within lists of vectors are the deepest that a motion has: deeper ones would only take memory.
json parsed(std::string_view text, const std::string& name) {
  constexpr int deepest = 8;
  const auto shallow = [&](int depth, json::parse_event_t, json&) {
    if (depth > deepest)
      throw input_error(name + ": the file is not a motion", "more than " + std::to_string(deepest) + " nested lists",
                        how);
    return true;
  };
  try {
    return json::parse(text, shallow);
  } catch (const json::parse_error& error) {
    const auto at = std::min(error.byte, text.size());
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    throw input_error(name + ":" + std::to_string(line) + ": the file is not valid JSON",
                      "byte " + std::to_string(error.byte), how);
  } catch (const json::exception&) {
    throw input_error(name + ": a number is too large for double precision", "", how);
  }
}

Motion::Tool tool_of(const Entry& entry) {
  Motion::Tool tool;
  if (!entry.has("nodes")) {
    tool.nodes[0] = entry["node"].node();
    tool.weights[0] = 1;
    return tool;
  }
  if (entry.has("node"))
    entry["node"].refuse("must not be given together with nodes", "give either node, or nodes and weights");
  const auto nodes = entry["nodes"].list_of(1, 3), weights = entry["weights"];
  weights.list_of(nodes.size(), nodes.size());
  double sum = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    tool.nodes[k] = nodes.at(k).node();
    tool.weights[k] = weights.at(k).number();
    if (tool.weights[k] < 0) weights.at(k).refuse("must not be negative");
    if (std::find(tool.nodes.begin(), tool.nodes.begin() + static_cast<std::ptrdiff_t>(k), tool.nodes[k]) !=
        tool.nodes.begin() + static_cast<std::ptrdiff_t>(k))
      nodes.refuse("must be different nodes");
    sum += tool.weights[k];
  }
  if (!(std::abs(sum - 1) <= 1e-6)) weights.refuse("must have the sum 1");
  return tool;
}

std::vector<double> times_of(const Entry& entry) {
  entry.list_of(1, Motion::most_steps);
  std::vector<double> times;
  for (std::size_t i = 0; i < entry.size(); ++i) {
    times.push_back(entry.at(i).number());
    if (i > 0 && times[i] < times[i - 1]) entry.at(i).refuse("must not be earlier than the time before it");
  }
  return times;
}

std::vector<std::vector<std::optional<Motion::Vector>>> vectors_of(const Entry& entry, std::size_t n_steps,
                                                                   std::size_t n_tools) {
  entry.list_of(n_steps, n_steps);
  std::vector<std::vector<std::optional<Motion::Vector>>> steps(n_steps);
  for (std::size_t i = 0; i < n_steps; ++i) {
    const auto step = entry.at(i);
    step.list_of(n_tools, n_tools);
    for (std::size_t t = 0; t < n_tools; ++t) steps[i].push_back(step.at(t).vector());
  }
  return steps;
}

}  // namespace

Motion read_motion_text(std::string_view text, const std::string& name) {
  const json value = parsed(text, name);
  const Entry file(value, name, "");
  const auto format = file["format"];
  if (format.text() != motion_format)
    format.refuse("is not \"" + std::string(motion_format) + "\"", "give a motion that this version can read");
  Motion motion;
  if (file.has("mesh_hash")) motion.mesh_hash = file["mesh_hash"].text();
  const auto tools = file["tools"];
  tools.list_of(1, Motion::most_tools);
  for (std::size_t t = 0; t < tools.size(); ++t) motion.tools.push_back(tool_of(tools.at(t)));
  motion.time_s = times_of(file["time_s"]);
  const auto n = motion.time_s.size();
  const auto displacements = file["displacement_m"];
  motion.displacement_m = vectors_of(displacements, n, tools.size());
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t t = 0; t < tools.size(); ++t)
      if (const auto& d = motion.displacement_m[i][t];
          d && std::hypot((*d)[0], (*d)[1], (*d)[2]) > Motion::largest_displacement_m)
        displacements.at(i).at(t).refuse("is longer than 1e6 m", "give displacements in metres");
  if (file.has("force_N") && !file["force_N"].value().is_null())
    motion.force_N = vectors_of(file["force_N"], n, tools.size());
  return motion;
}

}  // namespace phynness
