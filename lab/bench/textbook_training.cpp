#include "textbook_training.hpp"

#include <cmath>

namespace phynness::bench {

double textbook_training(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& targets, int neurons, double spread) {
  const auto n = static_cast<std::size_t>(inputs.rows());
  const auto m = static_cast<std::size_t>(inputs.cols());
  std::vector<std::vector<double>> q;
  std::vector<std::vector<double>> points(n, std::vector<double>(m)), residual(n, std::vector<double>(3));
  for (std::size_t p = 0; p < n; ++p) {
    for (std::size_t k = 0; k < m; ++k)
      points[p][k] = inputs(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(k));
    for (int k = 0; k < 3; ++k) residual[p][k] = targets(static_cast<Eigen::Index>(p), k);
  }
  std::vector<char> chosen(n, 0);
  double mse = 0;
  for (int neuron = 0; neuron <= neurons; ++neuron) {
    std::vector<double> h(n, 1.0);
    if (neuron > 0) {
      std::size_t worst = 0;
      double largest = -1;
      for (std::size_t p = 0; p < n; ++p) {
        double error = 0;
        for (int k = 0; k < 3; ++k) error += residual[p][k] * residual[p][k];
        if (!chosen[p] && error > largest) {
          largest = error;
          worst = p;
        }
      }
      chosen[worst] = 1;
      for (std::size_t p = 0; p < n; ++p) {
        double square = 0;
        for (std::size_t k = 0; k < m; ++k) square += std::pow(points[p][k] - points[worst][k], 2);
        h[p] = std::exp(-square / (spread * spread));
      }
    }
    for (const std::vector<double>& column : q) {
      double projection = 0;
      for (std::size_t p = 0; p < n; ++p) projection += column[p] * h[p];
      for (std::size_t p = 0; p < n; ++p) h[p] -= projection * column[p];
    }
    double norm = 0;
    for (std::size_t p = 0; p < n; ++p) norm += h[p] * h[p];
    norm = std::sqrt(norm);
    for (std::size_t p = 0; p < n; ++p) h[p] /= norm;
    for (int k = 0; k < 3; ++k) {
      double projection = 0;
      for (std::size_t p = 0; p < n; ++p) projection += h[p] * residual[p][k];
      for (std::size_t p = 0; p < n; ++p) residual[p][k] -= projection * h[p];
    }
    q.push_back(std::move(h));
    mse = 0;
    for (std::size_t p = 0; p < n; ++p)
      for (int k = 0; k < 3; ++k) mse += residual[p][k] * residual[p][k];
    mse /= 3.0 * static_cast<double>(n);
  }
  return mse;
}

}  // namespace phynness::bench
