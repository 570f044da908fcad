// JSON of results that describe themselves (described.hpp). Numbers that are not finite become null when it is written.
#pragma once

#include <concepts>
#include <nlohmann/json.hpp>
#include <phynness/formats/described.hpp>
#include <ranges>

namespace phynness {

using Json = nlohmann::ordered_json;

/// An object of what describes itself and of what has names, a list of other lists; strings and numbers as they are.
template <class T>
Json figures(const T& result) {
  if constexpr (Described<T>) {
    Json out = Json::object();
    T::describe(result, [&](const std::string& key, const auto& of, const char* = "") { out[key] = figures(of); });
    return out;
  } else if constexpr (requires { result.begin()->first; }) {
    Json out = Json::object();
    for (const auto& [name, of] : result) out[name] = figures(of);
    return out;
  } else if constexpr (std::ranges::range<T> && !std::convertible_to<T, std::string>) {
    Json out = Json::array();
    for (const auto& one : result) out.push_back(figures(one));
    return out;
  } else if constexpr (requires { result.has_value(); }) {
    return result ? figures(*result) : Json();
  } else {
    return result;
  }
}

/// @return an object of lists, one for each figure
template <class T>
Json columns_of_figures(const std::vector<T>& rows) {
  Json out = Json::object();
  T::describe(T{}, [&](const std::string& key, const auto&) { out[key] = Json::array(); });
  for (const auto& row : rows)
    T::describe(row, [&](const std::string& key, const auto& of) { out[key].push_back(figures(of)); });
  return out;
}

}  // namespace phynness
