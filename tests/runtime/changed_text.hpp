// Texts of models with a change and the checksum that belongs to it.
#pragma once

#include <gtest/gtest.h>

#include <phynness/formats/hash.hpp>
#include <string>

namespace phynness::test {

inline std::string with_checksum(const std::string& body) { return body + "checksum " + hash_of(body) + "\n"; }

inline std::string body_of(const std::string& text) { return text.substr(0, text.rfind("checksum ")); }

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return with_checksum(body_of(text.replace(at, from.size(), to)));
}

}  // namespace phynness::test
