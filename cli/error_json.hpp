// Errors relative to finite elements as JSON, with the same keys from validate and tune.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <phynness/validation/surface_points.hpp>
#include <phynness/validation/tool_pairs.hpp>

namespace phynness::cli {

inline nlohmann::ordered_json or_null(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

/// Without samples the values are null, because an error of 0 would be wrong.
inline nlohmann::ordered_json to_json(const ErrorStatistics& s) {
  if (s.n == 0) return {{"mean", nullptr}, {"median", nullptr}, {"p95", nullptr}, {"max", nullptr}, {"n", 0}};
  return {{"mean", s.mean}, {"median", s.median}, {"p95", s.p95}, {"max", s.max}, {"n", s.n}};
}

/// @param fields  of the model, as many as in `e`
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

inline nlohmann::ordered_json to_json(const PredictionErrors& e) {
  return {{"force", to_json(e.force)},
          {"displacement", to_json(e.displacement)},
          {"wrong", e.force.n > 0 ? nlohmann::ordered_json(e.wrong) : nlohmann::ordered_json(nullptr)}};
}

inline nlohmann::ordered_json to_json(const JudgedErrors& e) {
  nlohmann::ordered_json out{{"probes", e.probes}, {"solved", e.solved}, {"share", e.share}};
  out.update(to_json(e.model));
  out["linear"] = to_json(e.linear);
  return out;
}

/// @param worst  key of the worst tenth
inline nlohmann::ordered_json to_json(const JudgedGroup& group, const char* worst) {
  auto out = to_json(group.overall);
  out["by_depth"] = nlohmann::ordered_json::array();
  for (const auto& third : group.by_depth) out["by_depth"].push_back(to_json(third));
  out[worst] = to_json(group.worst_nodes);
  return out;
}

inline nlohmann::ordered_json to_json(const std::vector<JudgedProbe>& unreached) {
  auto out = nlohmann::ordered_json::array();
  for (const auto& p : unreached)
    out.push_back({{"node", p.node},
                   {"displacement", p.displacement_m},
                   {"depth_m", p.depth_m()},
                   {"reached_m", p.reached_m >= 0 ? nlohmann::ordered_json(p.reached_m) : nullptr},
                   {"reason", reason(p)},
                   {"flagged", p.flagged}});
  return out;
}

inline nlohmann::ordered_json by_node(const std::vector<ErrorsOfNode>& nodes) {
  nlohmann::ordered_json out;
  for (const char* key : {"nodes", "force_error", "displacement_error", "force_error_max", "unflagged", "solved"})
    out[key] = nlohmann::ordered_json::array();
  const auto number = [](double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
  };
  for (const auto& node : nodes) {
    const auto share = [&](std::int64_t n) { return static_cast<double>(n) / static_cast<double>(node.probes); };
    out["nodes"].push_back(node.node);
    out["force_error"].push_back(number(node.force));
    out["displacement_error"].push_back(number(node.displacement));
    out["force_error_max"].push_back(number(node.force_max));
    out["unflagged"].push_back(1 - share(node.flagged));
    out["solved"].push_back(share(node.solved));
  }
  return out;
}

/// How the bounds of a model hold.
inline nlohmann::ordered_json to_json(const ErrorsAndBounds& e) {
  const auto number = [](double value) { return std::isfinite(value) ? nlohmann::ordered_json(value) : nullptr; };
  const auto numbers = [&](const auto& values) {
    auto out = nlohmann::ordered_json::array();
    for (const double value : values) out.push_back(number(value));
    return out;
  };
  const auto& c = e.coverage;
  nlohmann::ordered_json out{{"states", c.states},
                             {"coverage", c.all},
                             {"thirds_of_depth", numbers(c.thirds)},
                             {"quarters_of_nodes", numbers(c.quarters)},
                             {"width_over_constant", number(c.width)}};
  out["at_most"] = nlohmann::ordered_json::array();
  for (const auto& bound : e.at_most) {
    auto group = to_json(bound.errors);
    group["fraction"] = bound.fraction;
    out["at_most"].push_back(std::move(group));
  }
  out["right"] = to_json(e.right);
  return out;
}

/// Adds the groups of probes up to R.
/// @param nodes  "nodes" or "points"
inline void add_to_range(nlohmann::ordered_json& out, const ErrorsToRange& e, const std::string& nodes) {
  const std::string worst = "worst_" + nodes;
  out["all"] = to_json(e.all, worst.c_str());
  out["unflagged"] = to_json(e.unflagged, worst.c_str());
  out["flagged"] = to_json(e.flagged, worst.c_str());
  out[worst] = e.worst_nodes;
  out["least_unflagged"] = e.least_unflagged;
  out["unreached"] = to_json(e.unreached);
  if (e.bounds) out["bounds"] = to_json(*e.bounds);
}

inline nlohmann::ordered_json to_json(const PointErrors& e) {
  return {{"force", to_json(e.force)}, {"displacement", to_json(e.displacement)}, {"field_l2", to_json(e.field_l2)}};
}

inline nlohmann::ordered_json to_json(const PointReport& r) {
  const auto first = r.refused > 0 ? nlohmann::ordered_json(r.first_refusal) : nlohmann::ordered_json(nullptr);
  nlohmann::ordered_json out{{"points", r.points},
                             {"finished", r.finished},
                             {"displacements", r.displacements},
                             {"failed", r.failed},
                             {"refused", r.refused},
                             {"first_refusal", first},
                             {"unsettled", r.unsettled},
                             {"largest_residual_m", r.largest_residual_m},
                             {"coupled", to_json(r.coupled)},
                             {"linear", to_json(r.linear)},
                             {"at_nodes", to_json(r.at_nodes)}};
  add_to_range(out, r.to_range, "points");
  return out;
}

inline nlohmann::ordered_json to_json(const PairGroup& group) {
  nlohmann::ordered_json out{{"pairs", group.pairs}};
  for (const auto p : pair_predictors)
    out[name(p)] = {{"force", to_json(group.of(p).force)},
                    {"force_own", to_json(group.of(p).force_own)},
                    {"displacement", to_json(group.of(p).displacement)},
                    {"displacement_all", to_json(group.of(p).displacement_all)},
                    {"field_l2", to_json(group.of(p).field_l2)}};
  return out;
}

inline nlohmann::ordered_json to_json(const PairRecord& r) {
  nlohmann::ordered_json out{
      {"nodes", r.nodes}, {"displacement", r.displacement_m}, {"distance", r.distance_m}, {"solved", r.solved}};
  out["flagged"] = is_flagged(r.status);
  if (!r.solved) out["reason"] = name(r.ended);
  if (!r.solved) return out;
  out["unsettled"] = (r.status & PHN_WARNING_UNSETTLED) != 0;
  out["outside"] = (r.status & PHN_WARNING_OUTSIDE) != 0;
  const auto number = [](double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
  };
  out["single_force"] = number(r.single_force);
  for (const auto p : pair_predictors)
    out[name(p)] = {{"force", number(r.of(p).force)},
                    {"force_own", number(r.of(p).force_own)},
                    {"displacement", number(r.of(p).displacement)},
                    {"displacement_all", number(r.of(p).displacement_all)},
                    {"field_l2", number(r.of(p).field_l2)}};
  return out;
}

inline nlohmann::ordered_json to_json(const PairReport& r) {
  nlohmann::ordered_json out{{"pairs", r.pairs},
                             {"finished", r.finished},
                             {"failed", r.failed},
                             {"unsettled", r.unsettled},
                             {"outside", r.outside},
                             {"depth_m", r.depth_m},
                             {"far_m", r.far_m},
                             {"largest_residual_m", r.largest_residual_m},
                             {"all", to_json(r.all)},
                             {"near", to_json(r.near)},
                             {"far", to_json(r.far)},
                             {"right_alone", to_json(r.right)},
                             {"single_force", to_json(r.single_force)},
                             {"records", nlohmann::ordered_json::array()}};
  out["by_warning"] = {{"all", to_json(r.by_warning.all)},
                       {"unflagged", to_json(r.by_warning.unflagged)},
                       {"flagged", to_json(r.by_warning.flagged)}};
  for (const auto& record : r.records) out["records"].push_back(to_json(record));
  return out;
}

}  // namespace phynness::cli
