#include "single_precision.hpp"

#include <phynness/phynness_image.h>
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstring>
#include <phynness/embedding/embedding.hpp>
#include <phynness/formats/error.hpp>
#include <random>
#include <type_traits>

namespace phynness::study {
namespace {

using Eigen::Vector3d;

constexpr int n_displacements = 1000, n_loops = 10, n_parts = 80;

// Gauss-Legendre quadrature on [-1, 1] with ten points in each of 80 parts of an edge: exact to 1e-12 for shapes of at
// least 0.03.
constexpr double gauss_point[] = {0.14887433898163121, 0.43339539412924719, 0.67940956829902441, 0.86506336668898451,
                                  0.97390652851717172};
constexpr double gauss_weight[] = {0.29552422471475287, 0.26926671930999636, 0.21908636251598204, 0.14945134915058059,
                                   0.06667134430868814};

Vector3d in_ball(std::mt19937_64& random) {
  const auto uniform = [&] { return 2 * static_cast<double>(random() >> 11) * 0x1p-53 - 1; };
  while (true) {
    const Vector3d x(uniform(), uniform(), uniform());
    if (x.squaredNorm() <= 1) return x;
  }
}

/// A node in an image of doubles or floats.
template <class Real>
class Potential {
 public:
  Potential(const Model& model, const ModelImage& image, std::int32_t node)
      : _words(image.bytes.size() / 8), _R(model.max_displacement_m), _node(node) {
    std::memcpy(_words.data(), image.bytes.data(), image.bytes.size());
    if (open(&_image) != PHN_OK) throw failure("the image is refused", "", "this is a defect; please report it");
  }
  Vector3d force(const Vector3d& x) const {
    const Eigen::Matrix<Real, 3, 1> d = (_R * x).cast<Real>();
    Eigen::Matrix<Real, 3, 1> f;
    if constexpr (in_float)
      phn_imagef_force(_image, _node, d.data(), f.data());
    else
      phn_image_force(_image, _node, d.data(), f.data());
    return f.template cast<double>();
  }
  double energy(const Vector3d& x) const {
    const Eigen::Matrix<Real, 3, 1> d = (_R * x).cast<Real>();
    Real energy = 0;
    if constexpr (in_float)
      phn_imagef_energy(_image, _node, d.data(), &energy);
    else
      phn_image_energy(_image, _node, d.data(), &energy);
    return static_cast<double>(energy);
  }

 private:
  static constexpr bool in_float = std::is_same_v<Real, float>;
  using Image = std::conditional_t<in_float, phn_imagef, phn_image>;
  int open(const phn_image** image) const { return phn_image_open(_words.data(), 8 * _words.size(), image); }
  int open(const phn_imagef** image) const { return phn_imagef_open(_words.data(), 8 * _words.size(), image); }

  std::vector<std::uint64_t> _words;
  const Image* _image = nullptr;
  double _R;
  std::int32_t _node;
};

template <class Real>
double work_of(const Potential<Real>& potential, const std::array<Vector3d, 4>& corners) {
  double work = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3d step = (corners[(i + 1) % corners.size()] - corners[i]) / n_parts;
    for (int part = 0; part < n_parts; ++part)
      for (int p = 0; p < 5; ++p)
        for (const double t : {gauss_point[p], -gauss_point[p]})
          work += gauss_weight[p] / 2 * potential.force(corners[i] + (part + 0.5) * step + t / 2 * step).dot(step);
  }
  return work;
}

}  // namespace

SinglePrecision single_precision(const Model& model, std::uint64_t seed) {
  SinglePrecision found;
  double sum = 0;
  ImageOptions options;
  options.force_only = true;
  const ModelImage doubles = model_image(model, options);
  options.floats = true;
  const ModelImage floats = model_image(model, options);
  for (const auto& node : model.nodes) {
    std::mt19937_64 random(seed);
    const Potential<double> exact(model, doubles, node.node);
    const Potential<float> rounded(model, floats, node.node);
    double largest = 0, mean = 0, worst = 0;
    for (int i = 0; i < n_displacements; ++i) {
      const Vector3d x = in_ball(random), f = exact.force(x);
      const double difference = (rounded.force(x) - f).norm();
      largest = std::max(largest, f.norm());
      mean += difference / n_displacements;
      worst = std::max(worst, difference);
    }
    sum += mean / largest;
    found.force_max = std::max(found.force_max, worst / largest);
    for (int loop = 0; loop < n_loops; ++loop) {
      const std::array<Vector3d, 4> corners{in_ball(random), in_ball(random), in_ball(random), in_ball(random)};
      double stored = 0;
      for (const auto& corner : corners)
        stored = std::max(stored, std::abs(exact.energy(corner)) / model.max_displacement_m);
      found.loop_double = std::max(found.loop_double, std::abs(work_of(exact, corners)) / stored);
      found.loop_float = std::max(found.loop_float, std::abs(work_of(rounded, corners)) / stored);
    }
  }
  found.force_mean = sum / static_cast<double>(model.nodes.size());
  return found;
}

}  // namespace phynness::study
