// Permissions do not bind root, whom many a build machine runs tests as.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

namespace phynness::test {

/// Root becomes the user nobody until the end of the scope, so that permissions bind; another user stays who it is.
class AsNobody {
 public:
  AsNobody() : _root(::getuid() == 0) {
    if (_root) {
      EXPECT_EQ(::setresuid(nobody, nobody, 0), 0);
    }
    EXPECT_NE(::geteuid(), 0u) << "permissions still do not bind";
  }
  ~AsNobody() {
    if (_root) {
      EXPECT_EQ(::setresuid(0, 0, 0), 0);
    }
  }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  static constexpr uid_t nobody = 65534;
  bool _root;
};

}  // namespace phynness::test
