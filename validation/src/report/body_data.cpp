#include "blocks.hpp"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <map>
#include <phynness/validation/report.hpp>

namespace phynness::report {
namespace {

/// Rounded to a millionth of the body's size, which is a thousandth of what a picture can show.
Json rounded(const Points& points, double size_m) {
  const double unit = std::pow(10, std::floor(std::log10(size_m)) - 6);
  Json all = Json::array();
  for (Eigen::Index i = 0; i < points.size(); ++i)
    all.push_back(std::stod(fmt::format("{:.9g}", std::round(points.data()[i] / unit) * unit)));
  return all;
}

/// Rows of the points: output nodes, then fixed nodes.
std::map<std::int32_t, std::int32_t> rows_of(const Model& model) {
  std::map<std::int32_t, std::int32_t> rows;
  for (const auto* nodes : {&model.output, &model.fixed})
    for (const auto node : *nodes) rows.emplace(node, static_cast<std::int32_t>(rows.size()));
  return rows;
}

Json node_errors(const ErrorsToRange& errors, const std::map<std::int32_t, std::int32_t>& rows) {
  Json all = Json::array();
  for (const auto& e : errors.nodes)
    if (const auto row = rows.find(e.node); row != rows.end() && !std::isnan(e.force))
      all.push_back({{"node", e.node}, {"row", row->second}, {"force_error", e.force}});
  return all;
}

/// Places between nodes and their mean errors of the force, of each predictor; null without places.
Json between_nodes(const Validated& in, const std::map<std::int32_t, std::int32_t>& rows) {
  constexpr std::array names{"Linear predictor", "Model", "Reduced body"};
  const std::size_t n = in.points.body ? 3 : 2;
  Json corners = Json::array(), weights = Json::array(), predictors = Json::array();
  for (std::size_t p = 0; p < n; ++p)
    predictors.push_back({{"name", names[p]}, {"force_error", Json::array()}, {"flagged", Json::array()}});
  for (const auto& place : in.points.records) {
    if (std::isnan(place.error[0])) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      corners.push_back(rows.at(place.nodes[k]));
      weights.push_back(std::round(1e4 * place.weights[k]) / 1e4);
    }
    for (std::size_t p = 0; p < n; ++p) {
      predictors[p]["force_error"].push_back(place.error[p]);
      predictors[p]["flagged"].push_back(place.flagged[p]);
    }
  }
  if (corners.empty()) return {};
  return {{"rows", corners}, {"weights", weights}, {"predictors", predictors}};
}

/// Share of the probe volume of each active node that the model has not trained.
Json not_trained(const Model& model, const std::map<std::int32_t, std::int32_t>& rows) {
  const auto share = trained_share(model);
  Json all = Json::array();
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    if (const auto row = rows.find(model.nodes[i].node); row != rows.end())
      all.push_back({row->second, std::round(1e4 * (1 - share.of_node[i])) / 1e4});
  return all;
}

}  // namespace

Json body_data(const Validated& in) {
  const Model& model = in.model.model();
  if (model.surface.rows() == 0 || in.report.shown.empty()) return {};
  const auto rows = rows_of(model);
  Points points(model.output_points.rows() + model.fixed_points.rows(), 3);
  points << model.output_points, model.fixed_points;
  const double size_m = (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
  Json triangles = Json::array();
  for (Eigen::Index t = 0; t < model.surface.rows(); ++t)
    for (Eigen::Index k = 0; k < 3; ++k) triangles.push_back(rows.at(model.surface(t, k)));
  Json cases = Json::array();
  for (const auto& state : in.report.shown)
    cases.push_back({{"node", state.node},
                     {"row", rows.at(state.node)},
                     {"displacement_m", state.displacement_m},
                     {"force_error", state.force_error},
                     {"finite_elements_m", rounded(state.finite_elements_m, size_m)},
                     {"model_m", rounded(state.model_m, size_m)}});
  Json errors = Json::array();
  for (const double e : in.report.output_error) errors.push_back(std::round(1e6 * e) / 1e6);
  return Json{{"points_m", rounded(points, size_m)},
              {"n_output", model.output.size()},
              {"triangles", triangles},
              {"displacement_error", errors},
              {"nodes", node_errors(in.report.to_range, rows)},
              {"between_nodes", between_nodes(in, rows)},
              {"not_trained", not_trained(model, rows)},
              {"cases", cases}};
}

}  // namespace phynness::report
