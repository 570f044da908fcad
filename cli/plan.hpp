// What `phynness plan` knows of a scene, and what it makes of that.
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
  std::optional<int> ranks;  ///< none: the processor cores of this machine
  int rays = 96;
  bool table = false;
  std::int64_t seed = 1;
  // What a sample on this machine cannot know of another one.
  double launch_s = 1, bandwidth_MB_per_s = 500, open_ms = 1, fetch_us = 5;
  std::optional<double> start_s, setup_ms;  ///< of a database, which does not hold them
};

/// Measured, of one scene.
struct PlanBasis {
  RayWork work;                     ///< all rays but mirror images of others
  int increments = 1;               ///< of a ray
  std::int64_t rays_requested = 0;  ///< of them, without those outside the hemisphere
  std::int64_t rays_mirrored = 0;
  std::int64_t rays_measured = 0, nodes_measured = 0;
  std::optional<double> relative_error;   ///< of a sample, if it is large enough: RaySample::relative_error()
  std::map<Status, std::int64_t> states;  ///< increments measured, per outcome
  double start_s = 0, node_setup_s = 0;
  std::optional<double> memory_bytes;  ///< of one rank
  PackingTrial packing;
  ModelSize model;
};

/// Solves the sample. In a build without the solver: says so.
/// @throws Error
PlanBasis basis_of_scene(const PlanOptions& options);
/// Takes all that a finished database has measured.
/// @throws Error
PlanBasis basis_of_database(const PlanOptions& options);

/// Prints the plan; returns it for machines.
/// @throws Error if a signal asks for an end
json report_plan(const PlanOptions& options, const PlanBasis& basis);

}  // namespace phynness::cli
