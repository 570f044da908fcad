// Claim: no sequence of arrays makes the counted bytes of an arena wrap around, also where size_t has 32 bits: it
// overflows and stays so, or its size is at most PTRDIFF_MAX.
#include <gtest/gtest.h>

#include "core/arena.hpp"

namespace {

using namespace PHN_RUNTIME;

TEST(Arena, CountsUpToTheLargestSizeAndNoFurther) {
  constexpr auto most = static_cast<std::size_t>(PTRDIFF_MAX);
  for (std::size_t first = most - 4 * alignment; first <= most; ++first) {
    Arena arena;
    arena.take<char>(first);
    // An empty array is aligned as well, which may go beyond the largest size.
    for (const std::size_t n : {std::size_t{0}, most - 4 * alignment, std::size_t{8}}) {
      arena.take<double>(n / sizeof(double));
      EXPECT_TRUE(arena.overflow() || arena.needed() <= most) << first << ' ' << n;
    }
    arena.take<char>(most / 2, 4);
    EXPECT_TRUE(arena.overflow());
  }
}

}  // namespace
