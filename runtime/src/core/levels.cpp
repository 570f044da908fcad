// The C interface of phynness_levels.h.
#include <phynness/phynness_levels.h>

#include "core/evaluate.hpp"

using namespace PHN_RUNTIME;

namespace {

const phn_model& level_of(const phn_model& model, std::int32_t level) {
  return level + 1 < model.n_levels ? model.smaller[level] : model;
}

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

}  // extern "C"
