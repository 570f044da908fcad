// Checks of messages. They require what a message must name (file, line, key, option, value), not its wording.
#pragma once

#include <gtest/gtest.h>

#include <phynness/formats/error.hpp>
#include <string>
#include <vector>

namespace phynness::test {

/// Expects that a message contains every part, such as "body.toml:3:", a key or a value.
inline void expect_names(const std::string& message, const std::vector<std::string>& parts) {
  for (const auto& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << "the message does not name '" << part << "':\n" << message;
}

/// Expects an error message that contains every part and a remedy.
inline void expect_error(const std::string& message, const std::vector<std::string>& parts) {
  expect_names(message, parts);
  expect_names(message, {"\n  remedy: "});
}

/// The message of the Error that `action` throws; empty if it throws none.
template <class Action>
std::string error_of(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// The same, of this kind; fails the test if none is thrown.
template <class Action>
std::string message_of(Action&& action, Error::Kind kind = Error::Kind::input) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

}  // namespace phynness::test
