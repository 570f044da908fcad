// What the command prints: results on stdout, messages on stderr. Work never ends because neither can be
// written.
#pragma once

#include <fmt/core.h>

#include <phynness/formats/printable.hpp>
#include <string>
#include <string_view>
#include <type_traits>

namespace phynness::cli {

/// Texts without control characters, whatever file they are from; numbers as they are.
template <class T>
auto shown(const T& value) {
  if constexpr (std::is_convertible_v<const T&, std::string_view>)
    return printable(std::string_view(value));
  else
    return value;
}

/// Call it first. Opens standard descriptors that are closed: the next file that the program opens would get
/// such a number, and text for a person would be written into it. Writing to them still fails. Ignores the
/// signals of a closed pipe and of a file that has reached its limit, which are then failed writes.
void prepare_streams();

void print_result_text(fmt::string_view format, fmt::format_args values);
void message_text(fmt::string_view format, fmt::format_args values) noexcept;

/// To stdout. finish_streams() reports what cannot be written.
template <class... T>
void print_result(fmt::format_string<T...> format, const T&... values) {
  const auto print = [&](const auto&... safe) { print_result_text(format, fmt::make_format_args(safe...)); };
  print(shown(values)...);
}
/// To stderr. What cannot be written is lost: there is no other place to say so.
template <class... T>
void message(fmt::format_string<T...> format, const T&... values) noexcept try {
  const auto print = [&](const auto&... safe) { message_text(format, fmt::make_format_args(safe...)); };
  print(shown(values)...);
} catch (...) {  // no memory for a copy
}

/// For child processes: this process reports at its end that stdout cannot be written, so that a child which
/// finds this out goes on and ends as its work does.
void report_stdout_for_children();

/// Call it last: says on stderr that results could not be written to stdout.
/// @return `exit_status`, but 1 instead of 0 where results are lost
int finish_streams(int exit_status);

}  // namespace phynness::cli
