#include "plain_loops.hpp"

namespace phynness::bench {

template <>
const PlainLoops<double>& fast_math_loops() {
  return loops<double>;
}
template <>
const PlainLoops<float>& fast_math_loops() {
  return loops<float>;
}

}  // namespace phynness::bench
