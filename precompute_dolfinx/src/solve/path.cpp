#include "path.hpp"

namespace phynness {
namespace {

constexpr int longest_history = 3;

}  // namespace

void Path::append(PathPoint point) {
  if (point.has_buckled) _points.clear();
  _points.push_back(std::move(point));
  if (_points.size() > longest_history) _points.pop_front();
}

int Path::n_points(double s) const {
  // Extrapolation over more than twice the interval of its points mainly amplifies noise.
  const double step = s - last().s;
  int k = 1;
  while (k < static_cast<int>(_points.size()) &&
         2.001 * (last().s - _points[_points.size() - 1 - static_cast<std::size_t>(k)].s) >= k * step)
    ++k;
  return k;
}

Prediction Path::predict(int k, double s) const {
  const auto first = _points.size() - static_cast<std::size_t>(k);
  const auto point = [&](int i) -> const PathPoint& { return _points[first + static_cast<std::size_t>(i / 2)]; };
  const auto at = [&](int i) { return point(i).s; };

  // Newton's divided differences, computed in place: difference[i] becomes [z_0 ... z_i].
  const int n = 2 * k;
  std::vector<Eigen::VectorXd> difference;
  for (int i = 0; i < n; ++i)
    difference.push_back(Eigen::VectorXd::Map(point(i).state.data(), std::ssize(point(i).state)));
  for (int order = 1; order < n; ++order)
    for (int i = n - 1; i >= order; --i) {
      if (order == 1 && i % 2 == 1)
        difference[i] = point(i).velocity;
      else
        difference[i] = (difference[i] - difference[i - 1]) / (at(i) - at(i - order));
    }
  Prediction out;
  out.state = difference[n - 1];
  out.velocity = Eigen::VectorXd::Zero(out.state.size());
  for (int i = n - 2; i >= 0; --i) {
    out.velocity = out.velocity * (s - at(i)) + out.state;
    out.state = out.state * (s - at(i)) + difference[i];
  }
  for (int i = 0; i < n; ++i) out.growth += 1 / (s - at(i));
  return out;
}

}  // namespace phynness
