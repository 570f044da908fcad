// Measures one case of the paper: networks of many sizes at some nodes are compared with new finite element solves.
#pragma once

#include <functional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/studies/measurements.hpp>
#include <phynness/validation/named_organ.hpp>

namespace phynness {

class SolverSession;

/// Called with a description of the present work, the finished and the total number.
using StudyProgress = std::function<void(const std::string&, std::int64_t, std::int64_t)>;

/// Collective: each rank measures its share of the nodes and pairs. The result has the share of this rank, in the order
/// that merged() expects.
/// @param networks  the paper's networks of the whole scene, for two tools; null if there are none
/// @param ours      a model of the family that is compared with the networks
/// @throws Error if the database belongs to another scene
CaseMeasurements measure_case(const SolverSession& session, const Scene& scene, const Database& database,
                              const NamedOrgan* networks, const NamedOrgan& ours, const StudySizes& sizes,
                              bool two_tools, const StudyProgress& progress);
/// Combines the parts of all ranks. @pre parts is not empty and in the order of the ranks
CaseMeasurements merged(const std::vector<CaseMeasurements>& parts);

/// Times of both models on this machine. Surfaces: levels 0 ... n_levels - 1 of Loop's subdivision.
RuntimeTimes measure_runtime(const NamedOrgan& networks, const NamedOrgan& ours, int n_levels);

struct SurfaceShape {
  Points points;
  Triangles triangles;
};
/// The subdivided surface at rest. @throws Error (input) if the model has none
SurfaceShape surface_at(const NamedOrgan& model, int level);

}  // namespace phynness
