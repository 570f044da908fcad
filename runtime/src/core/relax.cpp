// Relaxing forces (phn_relax). No header of the C++ library: devices compile this file with their images.
#include <phynness/phynness.h>

#include <phynness/schema/bounds.hpp>

#include "core/rbfn/exponential.hpp"

namespace {

namespace schema = phynness::schema;
static_assert(schema::largest_relaxation_count == PHN_MOST_RELAXING);

constexpr double largest_force = 1e300;  ///< a force is below twice this and finite
constexpr double largest_moved = 0.05;   ///< share of the history from other places from which on there is a warning

bool is_finite(const double* v) { return (v[0] - v[0]) + (v[1] - v[1]) + (v[2] - v[2]) == 0; }
bool in(const schema::Bound& bound, double value) { return value >= bound.low && value <= bound.high; }
double absolute(double value) { return value < 0 ? -value : value; }

/// Factors of a step of x = dt / tau.
struct Decay {
  double remaining;  ///< a = exp(-x), of the history
  double relaxed;    ///< 1 - (1 - a) / x, of a linear change within the step
};
Decay decay(double x) {
  constexpr double small = 0.01;  // The series has 13 digits below this, and the difference would have fewer.
  if (x < small) {
    const double relaxed = x * (1.0 / 2 - x * (1.0 / 6 - x * (1.0 / 24 - x * (1.0 / 120 - x / 720))));
    return {1 - x * (1 - relaxed), relaxed};
  }
  const double a = PHN_RUNTIME::exp_of_negative(-x);
  return {a, 1 - (1 - a) / x};
}

int check(const phn_relaxation& terms) {
  if (terms.n_terms < 0 || terms.n_terms > PHN_MOST_RELAXING) return PHN_ERROR_RANGE;
  double sum = 0;
  for (int32_t i = 0; i < terms.n_terms; ++i) {
    if (!in(schema::relaxing_share, terms.g[i]) || !in(schema::relaxation_time, terms.tau_s[i])) return PHN_ERROR_RANGE;
    sum += terms.g[i];
  }
  return sum < 1 && terms.length_m >= 0 ? PHN_OK : PHN_ERROR_RANGE;
}

/// Moves the history with the tool to its place. It decays on the way, because the tissue there is not relaxed.
void move_history(const phn_relaxation& terms, phn_relaxing& history, const double* place) {
  double square = 0;
  for (int k = 0; k < 3; ++k) square += (place[k] - history.place[k]) * (place[k] - history.place[k]);
  for (int k = 0; k < 3; ++k) history.place[k] = place[k];
  if (history.n_steps == 0 || square == 0) return;
  const double moved = PHN_RUNTIME::square_root(square) / terms.length_m;  // infinite for length 0
  const double factor = PHN_RUNTIME::exp_of_negative(-moved);
  for (int32_t i = 0; i < terms.n_terms; ++i)
    for (double& r : history.relaxed[i]) r *= factor;
  history.moved = history.moved + moved < 1 ? history.moved + moved : 1;
}

}  // namespace

extern "C" int phn_relax(const phn_relaxation* terms, phn_relaxing* history, const double* elastic, const double* place,
                         double dt_s, double* force) {
  if (force == nullptr) return PHN_ERROR_ARGUMENT;
  double target[3] = {}, at[3] = {};
  for (int k = 0; k < 3; ++k) {
    if (elastic != nullptr) target[k] = elastic[k];
    if (place != nullptr) at[k] = place[k];
  }
  for (int k = 0; k < 3; ++k) force[k] = 0;
  if (terms == nullptr || history == nullptr || elastic == nullptr) return PHN_ERROR_ARGUMENT;
  for (int k = 0; k < 3; ++k)
    if (!(absolute(target[k]) <= largest_force) || !(absolute(at[k]) <= schema::largest_coordinate))
      return PHN_ERROR_NOT_FINITE;
  if (!is_finite(history->outward)) return PHN_ERROR_NOT_FINITE;
  if (!(dt_s > 0 && dt_s <= largest_force)) return PHN_ERROR_CLOCK;
  const int status = check(*terms);
  if (status != PHN_OK) return status;
  if (terms->reserved != 0 || history->reserved != 0) return PHN_ERROR_VERSION;

  if (place != nullptr) move_history(*terms, *history, at);
  // r_i = rest_i + part_i F_e with the elastic force F_e at the end of the step.
  double rest[PHN_MOST_RELAXING][3], part[PHN_MOST_RELAXING], history_sum[3] = {}, part_sum = 0, slowest = 0;
  for (int32_t i = 0; i < terms->n_terms; ++i) {
    const auto [remaining, relaxed] = decay(dt_s / terms->tau_s[i]);
    part[i] = terms->g[i] * relaxed;
    part_sum += part[i];
    slowest = remaining > slowest ? remaining : slowest;
    for (int k = 0; k < 3; ++k) {
      const double old = terms->g[i] * (1 - remaining) * history->elastic[k] - part[i] * history->elastic[k];
      rest[i][k] = remaining * history->relaxed[i][k] + old;
      history_sum[k] += rest[i][k];
    }
  }
  history->moved *= slowest;
  double pull = 0;
  for (int k = 0; k < 3; ++k) pull += (target[k] - history_sum[k] - part_sum * target[k]) * history->outward[k];
  const bool is_separated = terms->n_terms > 0 && pull > 0;
  if (is_separated)  // The target is the elastic force of a body that recovers without a force.
    for (int k = 0; k < 3; ++k) target[k] = history_sum[k] / (1 - part_sum);
  for (int k = 0; k < 3; ++k) {
    force[k] = target[k];
    for (int32_t i = 0; i < terms->n_terms; ++i) {
      history->relaxed[i][k] = rest[i][k] + part[i] * target[k];
      force[k] -= history->relaxed[i][k];
    }
    if (is_separated) force[k] = 0;
    history->elastic[k] = target[k];
  }
  history->n_steps = 1;
  return is_separated || history->moved > largest_moved ? PHN_WARNING_RELAXATION : PHN_OK;
}
