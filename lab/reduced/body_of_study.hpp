// What the studies of reduced bodies share: a body in memory, its surface, and quantiles.
#pragma once

#include <fmt/core.h>
#include <phynness/phynness_body.h>

#include <CLI/CLI.hpp>
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace phynness {

using Eigen::Vector3d;

inline void require(int status, const char* what) {
  if (status < 0) throw std::runtime_error(fmt::format("{}: {}", what, phn_status_message(status)));
}

class Body {
 public:
  explicit Body(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    std::size_t bytes = 0;
    require(phn_body_size(text.data(), text.size(), &bytes, nullptr), file.c_str());
    _memory.resize(bytes);
    require(phn_body_init(_memory.data(), bytes, text.data(), text.size(), &_body, nullptr), file.c_str());
    require(phn_body_describe(_body, &info), "phn_body_describe");
  }
  const phn_body* get() const { return _body; }
  Vector3d point(int node) const { return Eigen::Map<const Vector3d>(info.points + 3 * node); }
  /// The nearest place of the surface; x and the normal become those of it.
  phn_tool nearest(Vector3d& x, Vector3d& normal) const;

  phn_body_info info{};

 private:
  std::vector<char> _memory;
  const phn_body* _body = nullptr;
};

inline phn_tool Body::nearest(Vector3d& x, Vector3d& normal) const {
  phn_tool best{{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}};
  double least = std::numeric_limits<double>::infinity();
  const Vector3d from = x;
  for (int t = 0; t < info.n_triangles; ++t) {
    const int* corner = info.triangles + 3 * t;
    Eigen::Matrix3d at;
    for (int k = 0; k < 3; ++k) at.col(k) = point(corner[k]);
    const Vector3d upward = (at.col(1) - at.col(0)).cross(at.col(2) - at.col(0)).normalized();
    // Weights of the foot, cut to the triangle: near enough to the nearest point of a smooth surface.
    Vector3d weights = at.colPivHouseholderQr().solve(from - upward.dot(from - at.col(0)) * upward).cwiseMax(0);
    weights /= weights.sum();
    const double distance = (at * weights - from).norm();
    if (!(distance < least)) continue;
    least = distance;
    x = at * weights;
    normal = upward;
    for (int k = 0; k < 3; ++k) {
      best.nodes[k] = info.nodes[corner[k]];
      best.weights[k] = weights[k];
    }
  }
  return best;
}

inline double at(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Parses the command line and calls run(). @return the exit status
template <class Run>
int run_study(CLI::App& app, int argc, char** argv, const Run& run) {
  CLI11_PARSE(app, argc, argv);
  try {
    run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace phynness
