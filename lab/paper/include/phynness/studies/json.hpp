// Conversion of measurements to and from JSON, through which the parts of the study exchange them.
#pragma once

#include <nlohmann/json.hpp>
#include <phynness/studies/measurements.hpp>

namespace phynness {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(StudySizes, nodes, probes_per_node, neurons, histogram_neurons, spreads,
                                                samples, force_neurons, curve_neurons, study_neurons, training_pairs,
                                                test_pairs, force_training_pairs, force_test_pairs, curve_points,
                                                tool_pairs, seed)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(NetworkErrors, x, neurons, held_mean, held_max, fresh_mean, fresh_max, beyond_mean,
                                   beyond_max)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ErrorHistogram, neurons, held, fresh)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PredictorAtNode, force, force_max, displacement, force_beyond, force_beyond_max,
                                   displacement_beyond)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ForceCurves, depth_m, finite_elements, linear, ours, networks)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(NodeMeasurements, node, beside_fixed, failed, by_neurons, by_spread, by_samples,
                                   force_as_paper, force_all, histograms, curves, ours, linear, zero, stiffness_N_per_m,
                                   training_cpu_s)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TwoToolErrors, depth_m, paper_mean, coupled_mean, linear_mean, paper_max,
                                   coupled_max, linear_max, coupled_force, linear_force, alone_force, paper, coupled,
                                   linear)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ToolPair, a, b, distance_m, first, second, depths)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CaseMeasurements, law, element, bulk_to_shear, range_m, outside_factor, force_spread,
                                   deformation_spread, ours, data_points, seconds, sizes, nodes, pairs)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SurfaceLevel, vertices, triangles, network_us, every_vertex_us, ours_us)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RuntimeTimes, force_us, deformation_us, deformation_plain_us, ours_force_us,
                                   ours_deformation_us, neurons, force_neurons, levels)

}  // namespace phynness
