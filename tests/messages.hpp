// Checks of messages. They require what a message must name (file, line, key, option, value), not its wording.
#pragma once

#include <gtest/gtest.h>

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

}  // namespace phynness::test
