// Measures one case of the paper: networks of many sizes at some nodes against fresh finite element solves.
#pragma once

#include <functional>
#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/database.hpp>
#include <phynness/studies/report.hpp>

namespace phynness {

class SolverSession;

/// What is under way, how far, of how many.
using StudyProgress = std::function<void(const std::string&, std::int64_t, std::int64_t)>;

/// Collective: each rank measures its share of the nodes and pairs; the result holds this rank's alone, in
/// the order in which merged() puts the parts together.
/// @param networks  the paper's networks of the whole scene, for two tools; may be null where there are none
/// @param ours      the family that stands beside them
/// @throws Error if the database is not the scene's, or `stop` says so
CaseMeasurements measure_case(const SolverSession& session, const Scene& scene, const Database& database,
                              const LoadedModel* networks, const LoadedModel& ours, const StudySizes& sizes,
                              bool two_tools, const StudyProgress& progress = {},
                              const std::function<bool()>& stop = {});
/// The parts of all ranks as one. @pre parts not empty, in the order of the ranks
CaseMeasurements merged(const std::vector<CaseMeasurements>& parts);

/// Times of both models on this machine. Surfaces: levels 0 ... n_levels - 1 of Loop's subdivision.
RuntimeTimes measure_runtime(const LoadedModel& networks, const LoadedModel& ours, int n_levels);

/// The subdivided surface at rest. @throws Error (input) if the model has none
SurfaceShape surface_at(const LoadedModel& model, int level);

}  // namespace phynness
