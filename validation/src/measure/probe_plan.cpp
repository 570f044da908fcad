#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <phynness/formats/body.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/schema/body_grammar.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/validation.hpp>
#include <random>
#include <set>

namespace phynness {

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

Vec3 random_direction(std::mt19937_64& random) {
  const double z = 2 * uniform(random) - 1, angle = 2 * std::numbers::pi * uniform(random);
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  return {r * std::cos(angle), r * std::sin(angle), z};
}

Vec3 random_direction(std::mt19937_64& random, Directions directions, const Eigen::Vector3d& normal) {
  const Vec3 e = random_direction(random);
  const bool is_outward = directions == Directions::hemisphere && normal.dot(to_eigen(e)) > 0;
  return is_outward ? Vec3{-e[0], -e[1], -e[2]} : e;
}

std::array<double, 3> random_barycentric(std::mt19937_64& random) {
  const double s = std::sqrt(uniform(random)), q = uniform(random);
  return {1 - s, s * (1 - q), s * q};
}

std::array<std::vector<Eigen::Index>, 4> triangles_by_corners(const NamedOrgan& model) {
  const auto& surface = model.model().surface;
  const auto probed = probed_nodes(model.model());
  const auto known = [&](std::int32_t node) { return std::ranges::binary_search(probed, node); };
  std::array<std::vector<Eigen::Index>, 4> triangles;
  for (Eigen::Index t = 0; t < surface.rows(); ++t)
    triangles[static_cast<std::size_t>(known(surface(t, 0)) + known(surface(t, 1)) + known(surface(t, 2)))].push_back(
        t);
  return triangles;
}

RandomPlaces::RandomPlaces(const NamedOrgan& model, Triangles triangles, const NamedOrgan* body)
    : _model(model), _body(body), _triangles(std::move(triangles)), _normals(node_normals(model.mesh())) {}

RandomPlaces RandomPlaces::answered(const NamedOrgan& model, const NamedOrgan* body) {
  if (!body) return {model, model.model().surface(triangles_by_corners(model)[3], Eigen::all)};
  const auto read = read_body_text(body->text(), body->name());
  std::vector<Eigen::Index> answered;
  for (Eigen::Index t = 0; t < read.surface.rows(); ++t) {
    std::array<int, schema::n_body_node_kinds> corners{};
    for (const auto corner : read.surface.row(t))
      ++corners[static_cast<std::size_t>(read.kinds[static_cast<std::size_t>(corner)])];
    if (corners[schema::body_node_moves] == 0 && corners[schema::body_node_touchable] > 0) answered.push_back(t);
  }
  return {model, read.surface(answered, Eigen::all).unaryExpr([&](std::int32_t corner) {
            return read.nodes[static_cast<std::size_t>(corner)];
          }),
          body};
}

/// Whether the body warns of a tool there, because it is too near to fixed nodes.
bool RandomPlaces::is_beside_fixed(const SurfacePoint& place) const {
  const auto& fixed = _model.model().fixed;
  if (!_body || std::ranges::none_of(place.nodes, [&](auto n) { return std::ranges::binary_search(fixed, n); }))
    return false;
  Vec3 force;
  _body->organ().reset().ignore();
  const int status = _body->organ().hold(tool_at(place, {}), force);
  return status < 0 || (status & PHN_WARNING_OUTSIDE) != 0;
}

SurfacePoint RandomPlaces::draw(std::mt19937_64& random) const {
  SurfacePoint place;
  if (at_nodes()) {
    place = at_node(random_element(_model.model().nodes, random).node);
  } else {
    // If all places are beside fixed nodes, the last one is returned; callers look at its warning.
    for (int attempt = 0; attempt < 1000; ++attempt) {
      const auto t = static_cast<Eigen::Index>(uniform(random) * static_cast<double>(_triangles.rows()));
      std::ranges::copy(_triangles.row(t), place.nodes.begin());
      place.weights = random_barycentric(random);
      if (!is_beside_fixed(place)) break;
    }
  }
  Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    if (place.weights[k] > 0) x += place.weights[k] * _model.mesh().nodes.row(place.nodes[k]);
  place.point = {x[0], x[1], x[2]};
  return place;
}

Vec3 RandomPlaces::draw_direction(std::mt19937_64& random, Directions directions, const SurfacePoint& place) const {
  const auto nearest = std::ranges::max_element(place.weights) - place.weights.begin();
  return random_direction(random, directions, _normals.row(place.nodes[static_cast<std::size_t>(nearest)]).transpose());
}

namespace {

template <typename T>
void shuffle(std::vector<T>& items, std::mt19937_64& random) {
  for (std::size_t i = items.size(); i > 1; --i)
    std::swap(items[i - 1], items[static_cast<std::size_t>(uniform(random) * static_cast<double>(i))]);
}

double distance_to_fixed(const NamedOrgan& model, std::int32_t node) {
  const Points& nodes = model.mesh().nodes;
  const Points fixed = nodes(model.model().fixed, Eigen::all);
  if (fixed.rows() == 0) return std::numeric_limits<double>::infinity();
  return (fixed.rowwise() - nodes.row(node)).rowwise().norm().minCoeff();
}

std::vector<NodePlan> choose_nodes(const NamedOrgan& model, std::int64_t wanted, std::mt19937_64& random) {
  std::vector<std::int32_t> active;
  for (const auto& entry : model.model().nodes) active.push_back(entry.node);
  wanted = std::min<std::int64_t>(wanted, static_cast<std::int64_t>(active.size()));
  std::vector<std::pair<double, std::int32_t>> by_distance;
  for (const auto node : active) by_distance.emplace_back(distance_to_fixed(model, node), node);
  std::sort(by_distance.begin(), by_distance.end());

  const auto n_nearest = static_cast<std::size_t>((wanted + 4) / 5);
  std::vector<std::int32_t> nearest_to_fixed;
  for (std::size_t i = 0; i < std::max(n_nearest, active.size() / 20) && i < by_distance.size(); ++i)
    nearest_to_fixed.push_back(by_distance[i].second);
  const std::set<std::int32_t> nearest_set(nearest_to_fixed.begin(), nearest_to_fixed.end());
  shuffle(nearest_to_fixed, random);
  nearest_to_fixed.resize(std::min(nearest_to_fixed.size(), n_nearest));
  // The probabilities that a node is chosen. A node near fixed nodes has two chances.
  const auto probability = [](auto part, auto all) {
    return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 1;
  };
  const double first = probability(nearest_to_fixed.size(), nearest_set.size()),
               second = probability(static_cast<std::size_t>(wanted) - nearest_to_fixed.size(),
                                    active.size() - nearest_to_fixed.size());
  const auto weight = [&](std::int32_t node) {
    return 1 / (nearest_set.contains(node) ? first + (1 - first) * second : second);
  };

  std::vector<NodePlan> plan;
  for (const auto node : nearest_to_fixed)
    plan.push_back({node, true, distance_to_fixed(model, node), weight(node), {}});
  shuffle(active, random);
  for (const auto node : active) {
    if (static_cast<std::int64_t>(plan.size()) >= wanted) break;
    if (std::find(nearest_to_fixed.begin(), nearest_to_fixed.end(), node) == nearest_to_fixed.end())
      plan.push_back({node, false, distance_to_fixed(model, node), weight(node), {}});
  }
  return plan;
}

struct DrawnDepths {
  double inside_fraction = 0, outside_fraction = 0;  ///< in (0, 1]; outside 0 if there is no such probe
  double inside(double depth) const { return depth * inside_fraction; }
  double outside(double depth) const {
    return outside_fraction > 0 ? depth * (1 + (outside_factor - 1) * outside_fraction) : 0;
  }
};

/// @param depth  trained depth of the direction
void set_range_probes(ProbePair& pair, const DrawnDepths& drawn, double depth, double range_m) {
  // The depths of a model are rounded by its text format; equal depths must give the same state.
  const bool trained_to_range = std::abs(depth - range_m) <= 1e-9 * range_m;
  pair.to_range_m = trained_to_range ? pair.inside_m : drawn.inside(range_m);
  pair.beyond_range_m = trained_to_range ? pair.outside_m : drawn.outside(range_m);
}

}  // namespace

std::vector<NodePlan> plan_probes(const NamedOrgan& model, Directions directions, std::int64_t probes,
                                  std::uint64_t seed, std::int64_t nodes, double range_m) {
  if (probes < 1)
    throw input_error("the number of probes must be at least 1", std::to_string(probes),
                      "use for example --probes 200");
  std::mt19937_64 random(seed);
  const std::int64_t n_inside = (probes + 1) / 2, n_outside = probes / 2;
  auto plan =
      choose_nodes(model, std::min(n_inside, nodes > 0 ? nodes : std::max<std::int64_t>(10, probes / 20)), random);
  const Points normals = node_normals(model.mesh());
  for (std::int64_t i = 0; i < n_inside; ++i) {
    auto& entry = plan[static_cast<std::size_t>(i) % plan.size()];
    ProbePair pair;
    std::optional<Vec3> first;  // first direction, with or without a trained depth
    double depth = 0;
    for (int attempt = 0; attempt < 1000 && depth <= 0; ++attempt) {
      pair.direction = random_direction(random);
      const auto n = normals.row(entry.node);
      const double inward = -(n[0] * pair.direction[0] + n[1] * pair.direction[1] + n[2] * pair.direction[2]);
      if (directions == Directions::hemisphere && inward <= 0) continue;
      if (!first) first = pair.direction;
      depth = model.trained_depth(entry.node, pair.direction);
    }
    if (depth <= 0 && range_m <= 0)
      throw input_error("a node of the model has no trained direction", "node " + std::to_string(entry.node),
                        "all of its probes failed; precompute it again");
    DrawnDepths drawn;
    drawn.inside_fraction = 1 - uniform(random);
    const double beyond = 1 - uniform(random);
    drawn.outside_fraction = i < n_outside ? beyond : 0;
    if (depth > 0) {
      pair.inside_m = drawn.inside(depth);
      pair.outside_m = drawn.outside(depth);
    }
    const bool same_ray = depth > 0 && first == pair.direction;
    if (range_m > 0 && same_ray) set_range_probes(pair, drawn, depth, range_m);
    if (depth > 0) entry.pairs.push_back(pair);
    if (range_m <= 0 || same_ray || !first) continue;
    ProbePair untrained{*first};
    set_range_probes(untrained, drawn, 0, range_m);
    entry.pairs.push_back(untrained);
  }
  return plan;
}

}  // namespace phynness
