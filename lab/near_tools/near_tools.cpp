// Two tools of a body that approach each other, one step of Newton's method in each millisecond, and leave again: the
// largest force, its largest change from one millisecond to the next, and what differs on the way back.
// Usage: near_tools BODY.txt [DEPTH_m [PLACES]]      (default: half of the trained depth, 3 places)
#include <phynness/phynness.h>
#include <phynness/phynness_body.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

namespace {

using Vector = Eigen::Vector3d;

struct Body {
  explicit Body(const char* file) {
    std::ifstream in(file);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    std::size_t bytes = 0;
    if (phn_body_size(text.data(), text.size(), &bytes, nullptr) != PHN_OK) {
      std::fprintf(stderr, "%s is not a body.txt\n", file);
      std::exit(2);
    }
    memory.resize(bytes);
    phn_body_init(memory.data(), bytes, text.data(), text.size(), &body, nullptr);
    phn_body_state_size(body, 2, &bytes);
    working.resize(bytes);
    phn_body_state_init(working.data(), bytes, body, 2, &state);
    phn_body_info(body, &info);
  }
  Vector point(std::int32_t i) const { return Eigen::Map<const Vector>(info.points + 3 * i); }
  Vector normal(std::int32_t t) const {
    const std::int32_t* c = info.triangles + 3 * t;
    return (point(c[1]) - point(c[0])).cross(point(c[2]) - point(c[0]));
  }
  /// The tool at the point of the surface nearest to x, by projection along one edge of a triangle after the other.
  phn_tool nearest(const Vector& x, const Vector& displacement, double& distance) const {
    phn_tool tool{};
    distance = 1e300;
    for (std::int32_t t = 0; t < info.n_triangles; ++t) {
      const std::int32_t* c = info.triangles + 3 * t;
      Vector weight = Vector::Constant(1.0 / 3);
      for (int turn = 0; turn < 60; ++turn)
        for (int k = 0; k < 3; ++k) {  // along one edge at a time
          const int a = k, b = (k + 1) % 3;
          const Vector edge = point(c[b]) - point(c[a]);
          const Vector at = weight[0] * point(c[0]) + weight[1] * point(c[1]) + weight[2] * point(c[2]);
          const double move = std::clamp((x - at).dot(edge) / edge.squaredNorm(), -weight[b], weight[a]);
          weight[a] -= move;
          weight[b] += move;
        }
      const Vector at = weight[0] * point(c[0]) + weight[1] * point(c[1]) + weight[2] * point(c[2]);
      if ((x - at).norm() >= distance) continue;
      distance = (x - at).norm();
      for (int k = 0; k < 3; ++k) {
        tool.nodes[k] = info.nodes[c[k]];
        tool.weights[k] = weight[k];
        tool.displacement[k] = displacement[k];
      }
    }
    return tool;
  }
  /// @param forces  6
  int press(std::int32_t n, const phn_tool* tools, int steps, double* forces) {
    return phn_body_force(body, state, n, tools, steps, forces, nullptr);
  }

  std::vector<char> memory, working;
  const phn_body* body = nullptr;
  phn_body_state* state = nullptr;
  phn_body_contents info{};
};

struct Place {
  Vector middle, normal, along;
};

/// Nodes around which the surface is flat enough for tools up to `reach` apart, and touchable.
std::vector<Place> find_places(Body& body, std::size_t n, double reach, double depth) {
  std::mt19937 random(7);
  std::normal_distribution<double> gauss;
  std::vector<Place> places;
  for (int attempt = 0; attempt < 3000 && places.size() < n; ++attempt) {
    const auto i = static_cast<std::int32_t>(random() % static_cast<unsigned>(body.info.n_nodes));
    Place place{body.point(i), Vector::Zero(), {gauss(random), gauss(random), gauss(random)}};
    for (std::int32_t t = 0; t < body.info.n_triangles; ++t)
      if (std::count(body.info.triangles + 3 * t, body.info.triangles + 3 * t + 3, i)) place.normal += body.normal(t);
    place.normal.normalize();
    place.along = (place.along - place.along.dot(place.normal) * place.normal).normalized();
    bool is_good = true;
    for (int k = -2; k <= 2 && is_good; ++k) {
      double distance, forces[3];
      const phn_tool tool = body.nearest(place.middle + k * reach / 4 * place.along, -depth * place.normal, distance);
      body.press(0, nullptr, 1, nullptr);
      is_good = distance < 0.2 * reach && body.press(1, &tool, 30, forces) == PHN_OK;
    }
    if (is_good) places.push_back(place);
  }
  return places;
}

void approach(Body& body, const char* name, const std::vector<Place>& places, double reach, double speed,
              Vector (*displacements)(const Place&, double, int), double depth) {
  double largest = 0, change = 0, settled_change = 0, apart = 0, parted = 0;
  long unsettled = 0, calls = 0;
  const auto n = static_cast<int>(reach / (speed * 1e-3));
  for (const Place& place : places) {
    Eigen::Matrix<double, 6, 1> before, now;
    std::vector<Eigen::Matrix<double, 6, 1>> coming;
    int last = 0;
    body.press(0, nullptr, 1, nullptr);
    for (int moment = 0; moment <= 2 * n; ++moment, ++calls) {
      const double separation = reach * std::abs(1 - static_cast<double>(moment) / n);
      phn_tool tools[2];
      double distance;
      for (int t = 0; t < 2; ++t)
        tools[t] =
            body.nearest(place.middle + (t - 0.5) * separation * place.along, displacements(place, depth, t), distance);
      const int status = body.press(2, tools, moment == 0 ? 100 : 1, now.data());
      unsettled += (status & PHN_WARNING_UNSETTLED) != 0;
      largest = std::max({largest, now.head<3>().norm(), now.tail<3>().norm()});
      if (moment > 0) {
        const double jump = std::max((now - before).head<3>().norm(), (now - before).tail<3>().norm());
        change = std::max(change, jump);
        if (((status | last) & PHN_WARNING_UNSETTLED) == 0) settled_change = std::max(settled_change, jump);
      }
      if (moment <= n) coming.push_back(now);
      if (moment > n) {
        const double differs = (now - coming[static_cast<std::size_t>(2 * n - moment)]).cwiseAbs().maxCoeff();
        apart = std::max(apart, differs);
        if (differs > 0.02 * largest) parted = std::max(parted, separation);
      }
      before = now;
      last = status;
    }
  }
  std::printf(
      "%-14s %4.0f mm/s  %8.3g N  change %5.1f %%, settled %5.1f %%  unsettled %ld of %ld  back differs %5.1f %%, to "
      "%.3g mm\n",
      name, 1e3 * speed, largest, 100 * change / largest, 100 * settled_change / largest, unsettled, calls,
      100 * apart / largest, 1e3 * parted);
}

}  // namespace

int main(int n_arguments, char** arguments) {
  if (n_arguments < 2) return 2;
  Body body(arguments[1]);
  const double radius = body.info.tool_radius_m, reach = 1.5 * radius,
               depth = n_arguments > 2 ? std::atof(arguments[2]) : body.info.max_displacement_m / 2;
  const auto places =
      find_places(body, n_arguments > 3 ? static_cast<std::size_t>(std::atoi(arguments[3])) : 3, reach, depth);
  double alone = 0;
  for (const Place& place : places) {
    double distance;
    Vector force;
    const phn_tool tool = body.nearest(place.middle, -depth * place.normal, distance);
    body.press(0, nullptr, 1, nullptr);
    body.press(1, &tool, 100, force.data());
    alone = std::max(alone, force.norm());
  }
  std::printf("R = %g mm, %zu places, %g mm deep, alone at most %.3g N\n", 1e3 * radius, places.size(), 1e3 * depth,
              alone);
  for (const double speed : {0.01, 0.1}) {
    approach(
        body, "same push", places, reach, speed, [](const Place& p, double d, int) -> Vector { return -d * p.normal; },
        depth);
    approach(
        body, "push and pull", places, reach, speed,
        [](const Place& p, double d, int t) -> Vector { return (t == 0 ? -d : d) * p.normal; }, depth);
    approach(
        body, "pinch", places, reach, speed,
        [](const Place& p, double d, int t) -> Vector {
          return d * ((t == 0 ? 0.7 : -0.7) * p.along - 0.3 * p.normal);
        },
        depth);
  }
}
