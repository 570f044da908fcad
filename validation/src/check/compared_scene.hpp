// What comparisons of elements and meshes have in common.
#pragma once

#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <phynness/validation/discretization.hpp>

namespace phynness {

/// Without measurements the CPU time of a solve is assumed to grow with this power of the unknowns; measured powers are
/// between 1.6 (p1-p1, 736 to 4,298 nodes) and 2.1 (p1-p1 and Taylor-Hood).
constexpr double cost_exponent = 2;

/// The scene as its forces are compared: with few increments, a round tool in place of a node, and nothing stored.
Scene compared_scene(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

double unknowns_of(Element element, double nodes, double edges);

/// Memory of the factors of a solid. The power is that of three dimensions (George 1973, doi 10.1137/0710032); measured
/// were 55, 150 and 400 MB for Taylor-Hood on livers of 320, 736 and 1,477 nodes, and 265 to 293 bytes at 47,000 and
/// 112,000 unknowns.
double factor_bytes(double unknowns);
/// "9.10 GB of memory are needed, 2.00 GB are available" for the factors of a solid; empty: they are available.
std::string why_no_memory(double unknowns, const DiscretizationOptions& options);

/// Compares stiffnesses of round tools at rest, by one factorization for each body. A body that does not fit into
/// memory or time ends the steps, and `why_not` says so.
/// @param own     the scene with round tools, as check solves it
/// @param places  nodes of its mesh, which the result completes
/// @param left_s  the time that is left
ComparisonAtRest compare_at_rest(const VariantBody& own, Variant reference, std::vector<PlaceAtRest> places,
                                 const DiscretizationOptions& options, const std::function<double()>& left_s,
                                 const ShouldStop& stop);

}  // namespace phynness
