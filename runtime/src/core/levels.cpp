// The C interface of phynness_levels.h: selection of a level, and measurement of their times.
#include <phynness/phynness_levels.h>

#include <cmath>

#include "core/evaluate.hpp"

using namespace PHN_RUNTIME;

namespace {

/// Shortest duration of a batch of calls [us]. The result is the median of several batches, which interruptions by
/// other processes do not change.
constexpr double shortest_batch = 20;
constexpr int n_batches = 7;
/// Calls of a batch. A clock that has not advanced after most_calls stands still. Forces are measured first because
/// their calls are short.
constexpr std::int32_t fewest_calls = 4, most_calls = 1 << 18;
/// Number of nodes whose forces are measured, spread over all active nodes.
constexpr std::int32_t n_nodes = 16;

const phn_model& level_of(const phn_model& model, std::int32_t level) {
  return level + 1 < model.n_levels ? model.smaller[level] : model;
}

double median(double* times) {
  for (int i = 1; i < n_batches; ++i) {
    for (int j = i; j > 0 && times[j] < times[j - 1]; --j) {
      const double t = times[j];
      times[j] = times[j - 1];
      times[j - 1] = t;
    }
  }
  return times[n_batches / 2];
}

class Stopwatch {
 public:
  Stopwatch(double (*clock_us)(void*), void* user) : _clock(clock_us), _user(user) {}

  /// Measures the time of one call [us]. @return whether the clock is valid
  template <class Call>
  bool measure(Call call, double* time) {
    double times[n_batches];
    std::int32_t n = fewest_calls;
    for (int batch = 0; batch < n_batches;) {
      const double begin = _clock(_user);
      for (std::int32_t i = 0; i < n; ++i) call(i);
      const double took = _clock(_user) - begin;
      if (!std::isfinite(begin) || !std::isfinite(took) || took < 0) return false;
      if (took < shortest_batch) {
        if (n >= most_calls) return false;
        n *= 2;
        batch = 0;
        continue;
      }
      times[batch++] = took / n;
    }
    *time = median(times);
    return true;
  }

 private:
  double (*_clock)(void*);
  void* _user;
};

/// The largest value of f over the active nodes.
template <class Count>
std::int32_t most(const phn_model& model, Count f) {
  std::int32_t largest = 0;
  for (std::int32_t i = 0; i < model.n_active; ++i) {
    const std::int32_t n = f(model.active[i]);
    largest = n > largest ? n : largest;
  }
  return largest;
}

std::int32_t force_centers(const ActiveNode& node) {
  return node.networks ? node.networks->force.n_neurons : node.modal ? node.modal->force.n_centers : 0;
}
std::int32_t neurons(const ActiveNode& node) { return node.networks ? node.networks->deformation.n_neurons : 0; }
std::int32_t modes(const ActiveNode& node) { return node.modal ? node.modal->n_modes : 0; }

/// A different displacement for each call, as of a moving hand, inside the trained range of most nodes.
void displacement(const phn_model& model, std::int32_t call, double* d) {
  for (int k = 0; k < 3; ++k) d[k] = model.max_displacement_m * 0.01 * static_cast<double>(call % 64 * (k + 3) % 50);
}

/// Measures the times of all levels. @return a status of phynness.h
int measure_levels(const phn_model* model, phn_data* data, double (*clock_us)(void*), void* user,
                   phn_level_time* times) {
  if (data == nullptr || data->model != model || clock_us == nullptr) return PHN_ERROR_ARGUMENT;
  if (model->n_active == 0) return PHN_ERROR_UNDEFINED;
  const int32_t before = phn_level_of(data);
  const int32_t n = model->n_active < n_nodes ? model->n_active : n_nodes;
  const auto node = [&](int32_t i) {
    return static_cast<int32_t>((2 * (i % n) + 1) * static_cast<int64_t>(model->n_active) / (2 * n));
  };
  // Deformations are measured at a node that has one, if any.
  int32_t touched = node(n / 2);
  for (int32_t i = 0; i < model->n_active && !has_deformation(*model, model->active[touched]); ++i) touched = i;
  const bool deforms = has_deformation(*model, model->active[touched]);
  Stopwatch watch(clock_us, user);
  bool good = true;
  for (int32_t l = 0; l < model->n_levels && good; ++l) {
    phn_set_level(model, data, l);
    phn_prepare(model, data, model->active_nodes[touched]);
    double d[3], force[3];
    good = watch.measure(
        [&](int32_t i) {
          displacement(*model, i, d);
          phn_force(model, data, model->active_nodes[node(i)], d, force, nullptr, nullptr);
        },
        &times[l].force_us);
    good = good && (!deforms || watch.measure(
                                    [&](int32_t i) {
                                      displacement(*model, i, d);
                                      phn_deform(model, data, model->active_nodes[touched], d, data->field);
                                    },
                                    &times[l].deformation_us));
  }
  phn_set_level(model, data, before);
  return good ? PHN_OK : PHN_ERROR_CLOCK;
}

/// @return a level, or a status of phynness.h
int32_t best_level(const phn_model* model, const phn_level_time* times, double n_forces, double n_deformations,
                   double budget_us) {
  if (model == nullptr || times == nullptr || !(n_forces >= 0) || !(n_deformations >= 0) || !std::isfinite(n_forces) ||
      !std::isfinite(n_deformations) || !(budget_us >= 0))
    return PHN_ERROR_ARGUMENT;
  int32_t best = -1;
  double least = 0;
  for (int32_t l = 0; l < model->n_levels; ++l) {
    const double time = n_forces * times[l].force_us + n_deformations * times[l].deformation_us;
    // The negation also excludes NaN.
    if (!(time <= budget_us)) continue;
    const auto& errors = level_of(*model, l).errors;
    const double error = (n_forces > 0 ? errors.force : 0) + (n_deformations > 0 ? errors.displacement : 0);
    if (best < 0 || error <= least) {
      best = l;
      least = error;
    }
  }
  return best < 0 ? PHN_ERROR_BUDGET : best;
}

}  // namespace

extern "C" {

int phn_level_info(const phn_model* model, int32_t level, phn_level* info) {
  if (info == nullptr) return PHN_ERROR_ARGUMENT;
  *info = {};
  if (model == nullptr || level < 0 || level >= model->n_levels) return PHN_ERROR_ARGUMENT;
  const phn_model& of_level = level_of(*model, level);
  info->force_centers = most(of_level, force_centers);
  info->deformation_centers =
      phynness::schema::traits(model->kind).has_modes ? of_level.shared.n_centers : most(of_level, neurons);
  info->modes = most(of_level, modes);
  info->error_force = of_level.errors.force;
  info->error_displacement = of_level.errors.displacement;
  return PHN_OK;
}

int phn_set_level(const phn_model* model, phn_data* data, int32_t level) {
  if (model == nullptr || data == nullptr || data->model != model || level < 0 || level >= model->n_levels)
    return PHN_ERROR_ARGUMENT;
  data->level = &level_of(*model, level);
  return PHN_OK;
}

int32_t phn_level_of(const phn_data* data) {
  if (data == nullptr) return 0;
  const phn_model& model = *data->model;
  return data->level == &model ? model.n_levels - 1 : static_cast<int32_t>(data->level - model.smaller);
}

int phn_calibrate(const phn_model* model, phn_data* data, double (*clock_us)(void* user), void* user,
                  phn_level_time* times) {
  if (model == nullptr || times == nullptr) return PHN_ERROR_ARGUMENT;
  phn_level_time measured[largest_level_count] = {};
  const int status = measure_levels(model, data, clock_us, user, measured);
  for (int32_t l = 0; l < model->n_levels; ++l) times[l] = status == PHN_OK ? measured[l] : phn_level_time{0, 0};
  return status;
}

int phn_budget(const phn_model* model, const phn_level_time* times, double n_forces, double n_deformations,
               double budget_us, int32_t* level) {
  if (level == nullptr) return PHN_ERROR_ARGUMENT;
  const int32_t best = best_level(model, times, n_forces, n_deformations, budget_us);
  *level = best < 0 ? 0 : best;
  return best < 0 ? best : PHN_OK;
}

}  // extern "C"
