// Functions that the comparisons of elements and of meshes share.
#pragma once

#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <phynness/validation/discretization.hpp>

namespace phynness {

/// Without measurements the CPU time of a solve is assumed to grow with this power of the unknowns; measured powers are
/// between 1.6 (p1-p1, 736 to 4,298 nodes) and 2.1 (p1-p1 and Taylor-Hood).
constexpr double cost_exponent = 2;

/// The scene with few increments, with a round tool instead of a node, and without stored tangents and fields.
Scene compared_scene(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

double unknowns_of(Element element, double nodes, double edges);

/// Memory of the factors of a solid. The exponent holds in three dimensions (George 1973, doi 10.1137/0710032).
/// Measured values are 55, 150 and 400 MB for Taylor-Hood on livers of 320, 736 and 1,477 nodes.
double factor_bytes(double unknowns);
/// "9.10 GB of memory are needed, 2.00 GB are available" for the factors of a solid; empty if there is enough memory.
std::string memory_shortage(double unknowns, const DiscretizationOptions& options);

/// Of the time of a check, what the comparison at rest may take.
inline constexpr double part_of_time_at_rest = 0.7;

/// Compares stiffnesses of round tools at rest with one factorization for each body. The comparison ends with
/// `skipped_reason` at a body that exceeds the memory or the time.
/// @param own     the scene with round tools
/// @param places  nodes of its mesh; the result contains them with their distances
/// @param elapsed_s  returns the time since the start of the check
ComparisonAtRest compare_at_rest(const VariantBody& own, Variant reference, std::vector<PlaceAtRest> places,
                                 const DiscretizationOptions& options, const std::function<double()>& elapsed_s,
                                 const ShouldStop& stop);

}  // namespace phynness
