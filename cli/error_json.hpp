// Errors against finite elements, for machines: the same words from validate and tune.
#pragma once

#include <nlohmann/json.hpp>
#include <phynness/validation/surface_points.hpp>

namespace phynness::cli {

/// Without samples there is no error, not an error of zero.
inline nlohmann::ordered_json to_json(const ErrorStatistics& s) {
  if (s.n == 0) return {{"mean", nullptr}, {"median", nullptr}, {"p95", nullptr}, {"max", nullptr}, {"n", 0}};
  return {{"mean", s.mean}, {"median", s.median}, {"p95", s.p95}, {"max", s.max}, {"n", s.n}};
}

/// @param fields  those of the model, as many as `e` has
inline nlohmann::ordered_json to_json(const GroupErrors& e, const std::vector<FieldModes>& fields = {}) {
  nlohmann::ordered_json out{{"force", to_json(e.force)},
                             {"displacement", to_json(e.displacement)},
                             {"displacement_moving", to_json(e.displacement_moving)},
                             {"field_l2", to_json(e.field_l2)},
                             {"force_relative", to_json(e.force_relative)}};
  for (std::size_t f = 0; f < fields.size(); ++f)
    out["fields"][fields[f].name] = {{"nodal", to_json(e.fields[f].nodal)}, {"l2", to_json(e.fields[f].l2)}};
  return out;
}

inline nlohmann::ordered_json to_json(const PredictorErrors& e) {
  return {{"inside", to_json(e.inside)}, {"outside", to_json(e.outside)}};
}

inline nlohmann::ordered_json to_json(const PointErrors& e) {
  return {{"force", to_json(e.force)},
          {"displacement", to_json(e.displacement)},
          {"field_l2", to_json(e.field_l2)}};
}

inline nlohmann::ordered_json to_json(const PointReport& r) {
  return {{"points", r.points},
          {"displacements", r.displacements},
          {"failed", r.failed},
          {"unsettled", r.unsettled},
          {"largest_residual_m", r.largest_residual_m},
          {"coupled", to_json(r.coupled)},
          {"linear", to_json(r.linear)},
          {"at_nodes", to_json(r.at_nodes)}};
}

}  // namespace phynness::cli
