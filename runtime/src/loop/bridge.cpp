// The force of a host that loses an answer.
#include <phynness/phynness.h>
#include <phynness/phynness_loop.h>

#include "core/lookup.hpp"

namespace {

constexpr double held_s = 0.01, lowered_s = 0.1;

double within_0_and_1(double x) { return x < 0 ? 0 : x < 1 ? x : 1; }

}  // namespace

extern "C" int phn_bridge_force(phn_bridge* bridge, const double answer[3], double now_s, double force[3]) {
  if (bridge == nullptr || force == nullptr) return PHN_ERROR_ARGUMENT;
  phn_bridge& b = *bridge;
  const bool is_answered = answer != nullptr && phynness::runtime::finite(answer);
  int status = answer != nullptr && !is_answered ? PHN_ERROR_NOT_FINITE : PHN_OK;
  if (b.reserved != 0) {
    for (int k = 0; k < 3; ++k) force[k] = 0;
    return PHN_ERROR_VERSION;
  }
  if (!(now_s - now_s == 0) || (b.is_running && !(now_s > b.now_s))) {
    status = PHN_ERROR_CLOCK;
  } else {
    const double passed = b.is_running ? now_s - b.now_s : 0, overdue = now_s - b.answered_s - held_s;
    if (is_answered) {
      b.part = b.is_running ? within_0_and_1(b.part + passed / lowered_s) : 1;
      for (int k = 0; k < 3; ++k) b.answer[k] = answer[k];
      b.answered_s = now_s;
      b.is_running = 1;
    } else if (overdue > 0) {
      b.part = within_0_and_1(b.part - (overdue < passed ? overdue : passed) / lowered_s);
    }
    b.now_s = now_s;
  }
  for (int k = 0; k < 3; ++k) force[k] = b.is_running ? b.part * b.answer[k] : 0;
  return status;
}
