#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mirrored_rays.hpp>
#include <tuple>

#include "ray_columns.hpp"

namespace phynness {
namespace {

using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Directions with a smaller difference are equal; different directions of a set differ by some tenths.
constexpr double same_direction = 1e-9;

/// Index of a direction; -1 if it is not in the list.
std::int32_t find(const std::vector<Vec3>& directions, const Eigen::Vector3d& e) {
  for (std::size_t d = 0; d < directions.size(); ++d)
    if ((Eigen::Vector3d::Map(directions[d].data()) - e).norm() < same_direction) return static_cast<std::int32_t>(d);
  return -1;
}

/// For each node of an ascending set, the index of its mirror image in the set.
std::vector<std::int32_t> images_within(const std::vector<std::int32_t>& nodes, const std::vector<std::int32_t>& image,
                                        const char* what) {
  std::vector<std::int32_t> within;
  for (const auto node : nodes) {
    const auto at = std::lower_bound(nodes.begin(), nodes.end(), image[node]);
    if (at == nodes.end() || *at != image[node])
      throw input_error(
          std::string("the ") + what + " nodes of a database are not symmetric, but it has a mirror plane",
          "node " + std::to_string(node), "the file is damaged, or was written by a defective program");
    within.push_back(static_cast<std::int32_t>(at - nodes.begin()));
  }
  return within;
}

}  // namespace

MirroredRays::MirroredRays(const DatabaseHeader& header) : _n_directions(header.directions.size()) {
  const auto n_active = static_cast<std::int32_t>(header.sets.active.size());
  const auto n_directions = static_cast<std::int32_t>(_n_directions);
  _sources.reserve(static_cast<std::size_t>(n_active) * _n_directions);
  for (std::int32_t a = 0; a < n_active; ++a)
    for (std::int32_t d = 0; d < n_directions; ++d) _sources.push_back({a, d});
  _n_solved = static_cast<std::int64_t>(_sources.size());
  if (!header.sets.mirror) return;

  const MirrorSymmetry& mirror = *header.sets.mirror;
  const Eigen::Vector3d n = Eigen::Vector3d::Map(mirror.normal.data());
  const Matrix H = Matrix::Identity() - 2 * n * n.transpose();
  Eigen::Map<Matrix>(_reflection.data()) = H;
  const auto image_of_active = images_within(header.sets.active, mirror.image, "active");
  _image_of_output = images_within(header.sets.output, mirror.image, "output");

  struct Partner {
    std::int32_t mirrored, opposite, both;
  };
  std::vector<Partner> partners;
  for (const auto& direction : header.directions) {
    const Eigen::Vector3d e = Eigen::Vector3d::Map(direction.data());
    partners.push_back({find(header.directions, H * e), mirror.odd ? find(header.directions, -e) : -1,
                        mirror.odd ? find(header.directions, -(H * e)) : -1});
  }
  const auto is_behind = [&](std::int32_t active) {
    const auto node = header.sets.active[static_cast<std::size_t>(active)];
    const Eigen::Vector3d across = header.mesh.nodes.row(node) - header.mesh.nodes.row(mirror.image[node]);
    return across.dot(n) < 0;
  };
  const auto order = [&](const Source& s) { return std::tuple(is_behind(s.active), s.direction, s.active); };
  for (auto& source : _sources) {
    const std::int32_t other = image_of_active[static_cast<std::size_t>(source.active)];
    const Partner& partner = partners[static_cast<std::size_t>(source.direction)];
    Source best = source;
    // All rays of an orbit have the same candidates and therefore the same first one. A ray that is its own image is
    // its own source.
    for (const Source& candidate :
         {Source{other, partner.mirrored, true, false}, Source{source.active, partner.opposite, false, true},
          Source{other, partner.both, true, true}})
      if (candidate.direction >= 0 && order(candidate) < order(best)) best = candidate;
    source = best;
  }
  _n_solved = std::count_if(_sources.begin(), _sources.end(), [](const Source& s) { return s.is_itself(); });
}

bool MirroredRays::solves_any(std::int32_t active) const {
  for (std::int32_t d = 0; d < static_cast<std::int32_t>(_n_directions); ++d)
    if (is_solved(active, d)) return true;
  return false;
}

std::vector<char> MirroredRays::solved() const {
  std::vector<char> flags;
  for (const auto& source : _sources) flags.push_back(source.is_itself());
  return flags;
}

Ray MirroredRays::image(const Ray& solved, std::int32_t active, std::int32_t direction) const {
  const Source& from = source(active, direction);
  Ray ray = solved;
  ray.active = active;
  ray.direction = direction;

  const Matrix H = from.mirrored ? Matrix(Eigen::Map<const Matrix>(_reflection.data())) : Matrix::Identity();
  const Matrix turn = from.opposite ? Matrix(-H) : H;
  const auto n_output = _image_of_output.size();
  /// Index of the value that becomes the value `i`: at output nodes, that of the mirrored node.
  const auto source_of = [&](const RayColumn& column, std::size_t i) {
    if (column.of != ColumnOf::output_node || !from.mirrored) return i;
    return i - i % n_output + static_cast<std::size_t>(_image_of_output[i % n_output]);
  };
  const auto mirror = [&](const RayColumn& column, auto member) {
    const auto values = values_of(solved, member);
    const auto images = values_of(ray, member);
    const auto components = static_cast<std::size_t>(column.tensor);
    if (column.kind == ColumnKind::cost) return std::fill(images.begin(), images.end(), ValueOf<decltype(member)>{});
    for (std::size_t i = 0; i < values.size() / components; ++i) {
      const auto* value = &values[components * source_of(column, i)];
      auto* image = &images[components * i];
      if constexpr (std::is_same_v<ValueOf<decltype(member)>, double>) {
        if (column.tensor == Tensor::vector) Eigen::Vector3d::Map(image) = turn * Eigen::Vector3d::Map(value);
        if (column.tensor == Tensor::matrix) Matrix::Map(image) = H * Matrix::Map(value) * H;
      }
      if (column.tensor == Tensor::scalar) *image = *value;
    }
  };
  for (const auto& column : ray_columns) std::visit([&](auto member) { mirror(column, member); }, column.member);
  for (std::size_t f = 0; f < solved.fields.size(); ++f)
    mirror(field_column(every_field.front(), f), RayColumn::FieldIndex{f});  // all fields are mirrored alike
  return ray;
}

}  // namespace phynness
