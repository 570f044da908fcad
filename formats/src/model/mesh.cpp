#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/mesh.hpp>
#include <tuple>

namespace phynness {
namespace {

// Faces of a positively oriented tetrahedron, seen counterclockwise from outside.
constexpr int outward_faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

template <class Unsigned>
void add_little_endian(Fnv1a64& hash, Unsigned value) {
  unsigned char bytes[sizeof value];
  for (std::size_t i = 0; i < sizeof value; ++i) bytes[i] = static_cast<unsigned char>(value >> (8 * i));
  hash.add(bytes, sizeof value);
}

}  // namespace

Triangles boundary_triangles(const Cells& cells) {
  struct Face {
    std::array<std::int32_t, 3> key;
    Eigen::Index cell;
    int local;
  };
  std::vector<Face> faces;
  faces.reserve(static_cast<std::size_t>(cells.rows()) * 4);
  for (Eigen::Index c = 0; c < cells.rows(); ++c)
    for (int f = 0; f < 4; ++f) {
      std::array<std::int32_t, 3> key{cells(c, outward_faces[f][0]), cells(c, outward_faces[f][1]),
                                      cells(c, outward_faces[f][2])};
      std::sort(key.begin(), key.end());
      faces.push_back({key, c, f});
    }
  std::sort(faces.begin(), faces.end(), [](const Face& p, const Face& q) {
    return std::tie(p.key, p.cell, p.local) < std::tie(q.key, q.cell, q.local);
  });
  std::vector<std::pair<Eigen::Index, int>> boundary;
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t j = i + 1;
    while (j < faces.size() && faces[j].key == faces[i].key) ++j;
    if (j == i + 1) boundary.emplace_back(faces[i].cell, faces[i].local);
    i = j;
  }
  std::sort(boundary.begin(), boundary.end());
  Triangles triangles(static_cast<Eigen::Index>(boundary.size()), 3);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) triangles(t, k) = cells(boundary[t].first, outward_faces[boundary[t].second][k]);
  return triangles;
}

void sort_unique(std::vector<std::int32_t>& nodes) {
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

std::vector<TouchedNodes> single_nodes(const std::vector<std::int32_t>& nodes) {
  std::vector<TouchedNodes> tools;
  for (const auto node : nodes) tools.push_back({{node}, {1.0}});
  return tools;
}

std::vector<std::int32_t> surface_nodes(const Triangles& surface) {
  std::vector<std::int32_t> nodes(surface.data(), surface.data() + surface.size());
  sort_unique(nodes);
  return nodes;
}

Points node_normals(const Points& nodes, const Triangles& surface) {
  Points normals = Points::Zero(nodes.rows(), 3);
  for (Eigen::Index t = 0; t < surface.rows(); ++t) {
    const Eigen::RowVector3d first = nodes.row(surface(t, 0));
    const Eigen::RowVector3d twice_area = (nodes.row(surface(t, 1)) - first).cross(nodes.row(surface(t, 2)) - first);
    for (int k = 0; k < 3; ++k) normals.row(surface(t, k)) += twice_area;
  }
  for (Eigen::Index i = 0; i < normals.rows(); ++i)
    if (const double length = normals.row(i).norm(); length > 0) normals.row(i) /= length;
  return normals;
}

std::string mesh_hash(const Mesh& mesh) {
  Fnv1a64 hash;
  for (Eigen::Index i = 0; i < mesh.nodes.size(); ++i)
    add_little_endian(hash, std::bit_cast<std::uint64_t>(mesh.nodes.data()[i]));
  for (Eigen::Index i = 0; i < mesh.cells.size(); ++i)
    add_little_endian(hash, std::bit_cast<std::uint32_t>(mesh.cells.data()[i]));
  return hash.hex();
}

}  // namespace phynness
