// Queries with responses, with which a device compares its own.
#include <algorithm>
#include <array>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/formats/image.hpp>
#include <random>

#include "image_functions.hpp"
#include "image_surface.hpp"

namespace phynness {
namespace {

struct Loaded {
  const Model& model;
  Organ& organ;

  std::size_t n_active() const { return static_cast<std::size_t>(organ.info().n_active); }
  std::int32_t active(std::size_t i) const { return organ.info().active_nodes[i % n_active()]; }
};

/// Reproducible numbers in [-1, 1), the same on every machine, which those of std::uniform_real_distribution are not.
class Numbers {
 public:
  double next() { return static_cast<double>(_engine() >> 11) * 0x1p-52 - 1; }

 private:
  std::mt19937_64 _engine{1};
};

Vec3 direction(Numbers& numbers) {
  for (;;) {
    const Vec3 d{numbers.next(), numbers.next(), numbers.next()};
    const double size = std::hypot(d[0], d[1], d[2]);
    if (size > 0.1 && size <= 1) return {d[0] / size, d[1] / size, d[2] / size};
  }
}

Vec3 displacement(const Loaded& model, std::int32_t node, std::size_t i, Numbers& numbers) {
  if (i == 0) return {0, 0, 0};
  Vec3 e = direction(numbers);
  double share = 0.5 + 0.5 * numbers.next();
  if (i <= 6) {
    e = {0, 0, 0};
    e[(i - 1) / 2] = i % 2 == 1 ? 1 : -1;
    share = 0.7;
  } else if (i % 16 == 15) {
    share = 3;
  } else if (i % 4 == 3) {
    share = 1 + 0.43 * share;
  }
  double depth = 0;
  model.organ.depth(phn_tool_at(node, e.data()), depth).ignore();
  const double deep = depth > 0 ? depth : model.organ.info().max_displacement_m;
  return {share * deep * e[0], share * deep * e[1], share * deep * e[2]};
}

/// An image with the functions for its type of numbers.
template <class Real>
class Device {
  using Functions = Image<Real>;

 public:
  explicit Device(const ModelImage& image) : _scratch(image.n_scratch), _field(3 * image.n_output) {
    const int status = Functions::open(image.bytes.data(), image.bytes.size(), &_image);
    if (status != PHN_OK)
      throw failure("the loader refuses the exported image", std::to_string(status),
                    "this is a defect; please report it");
  }

  /// d with the precision of the image.
  Vec3 held(const Vec3& d) const {
    const auto at = rounded(d);
    return {at[0], at[1], at[2]};
  }
  /// Sets what the image says of a query.
  void answer(GoldenQuery& query) {
    const auto d = rounded(query.displacement_m);
    auto tool = Functions::tool_at(query.node, d.data());
    if (query.node < 0) {
      Functions::nearest(_image, -1, rounded(query.point_m).data(), &tool, nullptr, nullptr);
      std::ranges::copy(d, tool.displacement);
      query.triangle = tool.triangle;
      std::copy_n(tool.weights, 3, query.weights.begin());
    }
    Real force[3], bound = PHN_IMAGE_NO_BOUND;
    query.status = Functions::force(_image, &tool, force);
    std::copy_n(force, 3, query.image_force_N.begin());
    if (Functions::bound(_image, &tool, &bound) >= 0) query.image_bound_N = bound;
    if (!_field.empty() && Functions::deform(_image, _scratch.data(), &tool, _field.data()) >= 0)
      std::copy_n(&_field[3 * static_cast<std::size_t>(query.output)], 3, query.image_deformation_m.begin());
  }

 private:
  static std::array<Real, 3> rounded(const Vec3& d) {
    return {static_cast<Real>(d[0]), static_cast<Real>(d[1]), static_cast<Real>(d[2])};
  }

  const typename Functions::Type* _image = nullptr;
  std::vector<Real> _scratch, _field;
};

/// Largest difference over the largest value.
class Deviation {
 public:
  void add(const Vec3& expected, const Vec3& got) {
    for (std::size_t k = 0; k < 3; ++k) {
      _largest = std::max(_largest, std::fabs(expected[k]));
      _difference = std::max(_difference, std::fabs(expected[k] - got[k]));
    }
  }
  double relative() const { return _largest > 0 ? _difference / _largest : _difference; }

 private:
  double _largest = 0, _difference = 0;
};

/// A random point of the surface, away from the edges, where the runtime may take a triangle that cannot be touched.
Vec3 point_on(const ImageSurface& surface, Numbers& numbers) {
  const double n = 0.5 * static_cast<double>(surface.triangle.size()) / 6;
  const auto triangle = static_cast<std::size_t>(n + n * numbers.next());
  Eigen::Vector3d weight;
  for (double& w : weight) w = 1.1 + numbers.next();
  Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    x += weight[static_cast<Eigen::Index>(k)] / weight.sum() * surface.point.row(surface.triangle[6 * triangle + k]);
  return {x[0], x[1], x[2]};
}

/// Least number of queries by which the deviation of an image from the model is measured.
constexpr std::size_t least_queries = 256;

template <class Real>
GoldenQueries queries(const Loaded& model, const ModelImage& image, std::size_t n_kept) {
  if (model.n_active() == 0) throw input_error("the model has no active nodes", "", "train it with active nodes");
  Device<Real> device(image);
  Numbers numbers;
  GoldenQueries all;
  Deviation force, deformation;
  std::vector<double> field(model.organ.n_deform());
  const std::size_t n = std::max(n_kept, least_queries);
  const auto ask = [&](GoldenQuery query, phn_tool tool, std::int32_t node, std::size_t i, bool kept) {
    query.displacement_m = device.held(displacement(model, node, i, numbers));
    std::ranges::copy(query.displacement_m, tool.displacement);
    if (!model.organ.hold(tool, query.force_N).ok())
      throw failure("a place of the image's surface has no force", "", "this is a defect; please report it");
    if (!model.organ.bound(tool, query.bound_N).ok()) query.bound_N = PHN_NO_BOUND;
    device.answer(query);
    force.add(query.force_N, query.image_force_N);
    if (image.n_output > 0 && query.node >= 0) {
      model.organ.deform(field).ignore();
      std::copy_n(&field[3 * static_cast<std::size_t>(query.output)], 3, query.deformation_m.begin());
      deformation.add(query.deformation_m, query.image_deformation_m);
    }
    if (kept) all.query.push_back(query);
  };
  const Vec3 rest{0, 0, 0};
  for (std::size_t i = 0; i < n; ++i) {
    GoldenQuery query;
    // The stride visits all nodes and seldom neighbouring nodes in succession.
    query.node = model.active(i * 7919);
    if (image.n_output > 0) query.output = static_cast<std::int32_t>((i * 104729) % image.n_output);
    ask(query, phn_tool_at(query.node, rest.data()), query.node, i, i < n_kept);
  }
  const ImageSurface surface = image.n_triangles > 0 ? image_surface(model.model) : ImageSurface{};
  const std::size_t n_places = image.n_triangles > 0 ? n / 4 : 0;
  for (std::size_t i = 0; i < n_places; ++i) {
    GoldenQuery query;
    query.point_m = device.held(point_on(surface, numbers));
    phn_tool tool;
    model.organ.nearest(query.point_m, tool).ignore();
    ask(query, tool, model.active(i), i, i < n_kept / 4);
  }
  all.n_measured = n + n_places;
  all.force_deviation = force.relative();
  all.deformation_deviation = deformation.relative();
  return all;
}

}  // namespace

GoldenQueries golden_queries(const Model& model, Organ& organ, const ModelImage& image, std::size_t n) {
  const Loaded loaded{model, organ};
  return image.options.floats ? queries<float>(loaded, image, n) : queries<double>(loaded, image, n);
}

}  // namespace phynness
