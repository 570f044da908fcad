// Measurements and predictions of `phynness plan`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/planning/model_size.hpp>
#include <phynness/planning/packing_trial.hpp>
#include <phynness/planning/schedule.hpp>
#include <string>

#include "commands.hpp"

namespace phynness::cli {

struct PlanOptions {
  std::filesystem::path source;
  std::optional<std::filesystem::path> json_file;
  std::optional<int> ranks;  ///< default: the number of processor cores of this machine
  int rays = 96;
  bool table = false;
  std::int64_t seed = 1;
  // Properties of the target machine, which a sample on this machine does not measure.
  double launch_s = 1, bandwidth_MB_per_s = 500, open_ms = 1, fetch_us = 5;
  std::optional<double> start_s, setup_ms;  ///< for plans from a database, which does not contain them
};

/// Measurements of one scene.
struct PlanBasis {
  RayWork work;                     ///< all rays except mirror images
  int increments = 1;               ///< of a ray
  std::int64_t rays_requested = 0;  ///< rays of `work` without those outside of the hemisphere
  std::int64_t rays_mirrored = 0;
  std::int64_t rays_measured = 0, nodes_measured = 0;
  std::optional<double> relative_error;   ///< RaySample::relative_error() of a sample that is large enough
  std::map<Status, std::int64_t> states;  ///< measured increments by outcome
  double start_s = 0, node_setup_s = 0;
  std::optional<double> memory_bytes;  ///< of one rank
  DatabaseHeader header;
  EndSummary ends;  ///< of the measured rays
  PackingTrial packing;
  ModelSize model;
};

/// Solves a sample of rays.
/// @throws Error (input) if the scene is invalid, or in a build without the solver
PlanBasis basis_of_scene(const PlanOptions& options);
/// Takes the measured costs of all rays from a finished database.
/// @throws Error (input) if the database is invalid or unfinished
PlanBasis basis_of_database(const PlanOptions& options);

/// Prints the plan. @return the plan as JSON
/// @throws Error (failure) after a signal
json report_plan(const PlanOptions& options, const PlanBasis& basis);

}  // namespace phynness::cli
