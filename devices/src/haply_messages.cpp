#include "haply_messages.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace phynness::devices::haply {

namespace {

using nlohmann::json;

const char* const check_version =
    "check that the port is that of the simulation channel (10001) and that the service has version 3.1 or later";

[[noreturn]] void refuse(const std::string& what, const std::string& value, const std::string& remedy) {
  throw std::runtime_error(
      printable("Haply Inverse service: " + what + (value.empty() ? "" : ": " + value) + "; " + remedy));
}

json parsed(const std::string& message) {
  constexpr int deepest = 32;  // far deeper than any documented message
  const auto check_depth = [&](int depth, json::parse_event_t, const json&) {
    if (depth >= deepest) refuse("a message is nested too deeply", beginning_of(message), check_version);
    return true;
  };
  json result = json::parse(message, check_depth, false);
  if (!result.is_object()) refuse("a message is not a JSON object", beginning_of(message), check_version);
  return result;
}

/// The entry of an object; null if there is none.
const json& entry(const json& object, const char* name) {
  static const json none;
  if (!object.is_object()) return none;
  const auto found = object.find(name);
  return found == object.end() ? none : *found;
}

/// Text that is not UTF-8 is allowed.
std::string dumped(const json& value) { return value.dump(-1, ' ', true, json::error_handler_t::replace); }

std::string id_of(const json& device) {
  const json& id = entry(device, "device_id");
  return id.is_string() ? id.get<std::string>() : "";
}

bool read_vector(const json& vector, std::array<double, 3>& numbers) {
  const char* const names[] = {"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    const json& number = entry(vector, names[i]);
    if (!number.is_number()) return false;
    numbers[i] = number.get<double>();
    if (!std::isfinite(numbers[i])) return false;
  }
  return true;
}

/// With a scale, positions and forces are not those of the cursor, and their product is not work. Entries that are the
/// identity may be left out.
void refuse_scale(const json& transform, const char* what) {
  const json& scale = entry(transform, "scale");
  std::array<double, 3> s{};
  if (scale.is_null()) return;
  if (!read_vector(scale, s))
    refuse(std::string("the scale of ") + what + " is not a vector", beginning_of(dumped(scale)), check_version);
  for (const double number : s)
    if (std::fabs(number - 1) > 1e-6)
      refuse(std::string("the scale of ") + what + " is not 1", beginning_of(dumped(scale)),
             "remove it in Haply Hub, and set motion_scale of the loop instead");
}

std::string why_not_ready(const json& status) {
  const json& calibrated = entry(status, "calibrated");
  const json& power = entry(status, "power_supply");
  if (calibrated.is_boolean() && !calibrated.get<bool>())
    return "it is not calibrated; calibrate it as Haply Hub shows";
  if (power.is_boolean() && !power.get<bool>()) return "it has no power; connect its power supply";
  return "";
}

}  // namespace

std::string printable(const std::string& text) {
  std::string result = text;
  for (char& c : result)
    if (c < ' ' || c > '~') c = '?';
  return result;
}

std::string beginning_of(const std::string& message) {
  constexpr std::size_t longest = 80;
  return "\"" + printable(message.substr(0, longest)) + (message.size() > longest ? "...\"" : "\"");
}

std::string select_device(const std::string& message, const std::string& wanted_id) {
  const json all = parsed(message);
  const json& devices = entry(all, "inverse3");
  if (!devices.is_null() && !devices.is_array())
    refuse("\"inverse3\" is not a list of devices", beginning_of(message), check_version);
  std::string ids;
  const json* selected = nullptr;
  for (const json& device : devices) {
    const std::string id = id_of(device);
    if (id.empty()) refuse("a device has no \"device_id\"", beginning_of(dumped(device)), check_version);
    ids += (ids.empty() ? "" : ", ") + id;
    if (wanted_id.empty() || id == wanted_id) selected = &device;
  }
  if (ids.empty()) refuse("no Inverse3 is connected", "", "connect it and check that Haply Hub shows it");
  if (selected == nullptr)
    refuse("no Inverse3 has the id " + wanted_id, "there are " + ids, "set device_id to one of these");
  if (wanted_id.empty() && devices.size() > 1)
    refuse("several Inverse3 are connected", ids, "set device_id to one of these");
  const json& config = entry(*selected, "config");
  const json& mount = entry(config, "mount");
  refuse_scale(mount, "the mount");
  refuse_scale(entry(mount, "transform"), "the mount");
  refuse_scale(entry(entry(*selected, "state"), "transform"), "the workspace");
  return id_of(*selected);
}

State read_state(const std::string& message, const std::string& device_id) {
  const json all = parsed(message);
  const json& devices = entry(all, "inverse3");
  if (devices.is_array())
    for (const json& device : devices) {
      if (id_of(device) != device_id) continue;
      State state;
      const json& values = entry(device, "state");
      if (!read_vector(entry(values, "cursor_position"), state.position_m))
        refuse("\"cursor_position\" is not three finite numbers",
               beginning_of(dumped(entry(values, "cursor_position"))), check_version);
      state.has_force = read_vector(entry(values, "current_cursor_force"), state.force_N);
      state.not_ready = why_not_ready(entry(device, "status"));
      refuse_scale(entry(values, "transform"), "the workspace");
      return state;
    }
  refuse("a state update has no device " + device_id, beginning_of(message), "check its cable and Haply Hub");
}

std::string force_command(const std::string& device_id, const std::string& force_name, const Force& force,
                          const std::string& profile) {
  json command;
  if (!profile.empty()) command["session"]["configure"]["profile"]["name"] = profile;
  json device = {{"device_id", device_id}};
  device["commands"]["set_cursor_force"][force_name] = {{"x", force[0]}, {"y", force[1]}, {"z", force[2]}};
  command["inverse3"] = json::array({device});
  return dumped(command);
}

}  // namespace phynness::devices::haply
