// The levels of a model: formats/model.md, LEVEL.
#include "load_parts.hpp"

namespace PHN_RUNTIME {
namespace {

double error(TextReader& in) {
  const double value = linear_entry(in);
  if (!(value >= 0)) in.fail(PHN_ERROR_RANGE);
  return value;
}

LevelErrors errors_line(TextReader& in) {
  in.keyword("level");
  LevelErrors errors = {};
  errors.force = error(in);
  errors.displacement = error(in);
  in.end_line();
  return errors;
}

}  // namespace

void load_levels(TextReader& in, Arena& arena, std::int32_t n_displacements, phn_model& model, Levels& levels) {
  TextReader attempt = in;
  attempt.keyword("levels");
  if (model.family == Family::linear || !in.good() || !attempt.good()) return;
  in.keyword("levels");
  const std::int32_t n = in.integer(2, largest_level_count);
  in.end_line();
  for (std::int32_t l = 0; l + 1 < n && in.good(); ++l) {
    phn_model& level = levels.level[l];
    level = model;
    level.errors = errors_line(in);
    if (model.family != Family::modal) continue;
    level.shared.n_centers = count_line(in, "amplitude_centers", 0);
    // Scratch is laid out for the full level.
    if (level.shared.n_centers > model.shared.n_centers) in.fail(PHN_ERROR_RANGE);
    if (in.good()) load_amplitude_centers(in, arena, n_displacements, model, level.shared);
  }
  model.errors = errors_line(in);
  model.n_levels = n;
  levels.n_smaller = in.good() ? n - 1 : 0;
}

void place_levels(const phn_model& model, const Levels& levels, phn_model* memory) {
  for (std::int32_t l = 0; memory != nullptr && l < levels.n_smaller; ++l) {
    const SharedModes shared = levels.level[l].shared;
    memory[l] = model;
    memory[l].shared = shared;
    memory[l].errors = levels.level[l].errors;
    memory[l].active = levels.active[l];
  }
}

}  // namespace PHN_RUNTIME
