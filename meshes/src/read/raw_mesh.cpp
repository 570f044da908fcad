#include "raw_mesh.hpp"

#include <bit>
#include <set>
#include <string_view>
#include <unordered_map>

#include "surface/topology.hpp"

namespace phynness::meshes {
namespace {

constexpr std::int32_t none = -1;
using Face = std::array<std::int32_t, 4>;  // corners of a cell, seen from outside against the clock

const std::vector<Face>& faces_of(std::size_t corners) {
  static const std::vector<Face> pyramid = {
      {0, 3, 2, 1}, {0, 1, 4, none}, {1, 2, 4, none}, {2, 3, 4, none}, {3, 0, 4, none}};
  static const std::vector<Face> wedge = {{0, 2, 1, none}, {3, 4, 5, none}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
  static const std::vector<Face> hexahedron = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                               {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  return corners == 5 ? pyramid : corners == 6 ? wedge : hexahedron;
}

/// Tetrahedra from the corner of the smallest number to the faces without it, each of which is divided at its own
/// corner of the smallest number. Neighbours so divide their common face alike (Dompierre et al. 1999).
void split(const std::vector<std::int32_t>& cell, std::vector<Tetrahedron>& tetrahedra) {
  const std::int32_t apex = *std::min_element(cell.begin(), cell.end());
  for (const Face& corners : faces_of(cell.size())) {
    std::vector<std::int32_t> face;
    for (const std::int32_t k : corners)
      if (k != none && std::find(face.begin(), face.end(), cell[k]) == face.end()) face.push_back(cell[k]);
    if (std::find(face.begin(), face.end(), apex) != face.end()) continue;
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    for (std::size_t k = 2; k < face.size(); ++k) tetrahedra.push_back({apex, face[0], face[k - 1], face[k]});
  }
}

/// Nodes of equal coordinates become the first of them.
void weld(RawMesh& raw, bool silently) {
  using Key = std::array<std::uint64_t, 3>;
  const auto hash = [](const Key& key) {
    return std::hash<std::string_view>{}({reinterpret_cast<const char*>(key.data()), sizeof key});
  };
  std::unordered_map<Key, std::int32_t, decltype(hash)> places(raw.nodes.size(), hash);
  std::vector<std::int32_t> place;
  std::size_t n = 0;
  for (std::size_t i = 0; i < raw.nodes.size(); ++i) {
    Key key;
    for (int k = 0; k < 3; ++k) key[k] = std::bit_cast<std::uint64_t>(raw.nodes[i][k] + 0.0);  // -0 is 0
    const auto [found, is_new] = places.emplace(key, static_cast<std::int32_t>(n));
    place.push_back(found->second);
    if (!is_new) continue;
    raw.nodes[n++] = raw.nodes[i];
    if (!silently) raw.file_number.push_back(static_cast<std::int32_t>(i));
  }
  if (n == raw.nodes.size()) return raw.file_number.clear();
  if (!silently)
    raw.notes.push_back("merged " + counted(raw.nodes.size() - n, "node", "nodes") +
                        " at exactly the place of another one; a slit needs sides that are apart");
  raw.nodes.resize(n);
  raw.for_each_corner([&](std::int32_t& node) { node = place[node]; });
  raw.renumber_groups([&](std::int32_t& node) { node = place[node]; });
}

/// Programs write a cell once for each group that holds it.
template <class Element>
void drop_repeated(std::vector<Element>& elements, const char* one, const char* many, std::vector<std::string>& notes) {
  std::vector<Element> sorted = elements;
  for (Element& key : sorted) std::sort(key.begin(), key.end());
  auto keys = sorted;
  std::sort(keys.begin(), keys.end());
  if (std::adjacent_find(keys.begin(), keys.end()) == keys.end()) return;
  std::set<Element> seen;
  std::size_t at = 0;
  const auto n = std::erase_if(elements, [&](const Element&) { return !seen.insert(sorted[at++]).second; });
  notes.push_back("dropped " + counted(n, one, many) + ", which the file holds more than once");
}

}  // namespace

bool RawMesh::add_cell(const std::vector<std::int32_t>& corners) {
  if (corners.size() == 4)
    tetrahedra.push_back({corners[0], corners[1], corners[2], corners[3]});
  else if (corners.size() == 5 || corners.size() == 6 || corners.size() == 8)
    polyhedra.push_back(corners);
  else
    return false;
  return true;
}

void RawMesh::finish(bool welds) {
  weld(*this, welds);
  const std::size_t before = tetrahedra.size();
  for (const auto& cell : polyhedra) split(cell, tetrahedra);
  if (!polyhedra.empty())
    notes.push_back("split " + counted(polyhedra.size(), "cell", "cells") + " of 5, 6 or 8 corners into " +
                    std::to_string(tetrahedra.size() - before) + " tetrahedra");
  polyhedra.clear();
  for (auto& [name, cells] : cell_groups) {
    std::vector<Tetrahedron> parts;
    for (const auto& cell : cells)
      if (cell.size() > 4) split(cell, parts);
    std::erase_if(cells, [](const auto& cell) { return cell.size() != 4; });
    for (const auto& part : parts) cells.emplace_back(part.begin(), part.end());
  }
  drop_repeated(tetrahedra, "repeated cell", "repeated cells", notes);
  drop_repeated(triangles, "repeated triangle", "repeated triangles", notes);
}

}  // namespace phynness::meshes
