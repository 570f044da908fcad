// A valid scene, in which tests change single lines.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/formats/scene.hpp>
#include <string>

#include "../messages.hpp"
#include "good_scene.hpp"

namespace phynness::test {

inline int line_of(const std::string& text, const std::string& part) {
  const auto at = text.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

inline std::string with(std::string text, const std::string& old_part, const std::string& new_part) {
  const auto at = text.find(old_part);
  EXPECT_NE(at, std::string::npos) << old_part;
  return text.replace(at, old_part.size(), new_part);
}

inline Scene parsed(const std::string& text) { return parse_scene(text, "body.toml", "."); }

/// The message of the refusal; fails the test if there is none.
inline std::string refusal(const std::string& text) {
  SCOPED_TRACE(text);
  return message_of([&] { parsed(text); });
}

}  // namespace phynness::test
