#include "plain_loops.hpp"

namespace phynness::bench {

template <>
const PlainLoops<double>& textbook_loops() {
  return loops<double>;
}
template <>
const PlainLoops<float>& textbook_loops() {
  return loops<float>;
}

}  // namespace phynness::bench
