// The same two tetrahedra in every format that is read, with a physical group where the format has one.
#pragma once

#include <bit>
#include <cstdint>
#include <string>

namespace phynness::test {

inline const std::string small_msh_1 =
    "$NOD\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$ENDNOD\n"
    "$ELM\n3\n1 2 7 1 3 1 2 3\n2 4 0 1 4 1 2 3 4\n3 4 0 1 4 2 5 3 4\n$ENDELM\n";

inline const std::string small_msh_2 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \"hilum\"\n$EndPhysicalNames\n"
    "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n"
    "$Elements\n3\n1 2 2 7 1 1 2 3\n2 4 2 0 1 1 2 3 4\n3 4 2 0 1 2 5 3 4\n$EndElements\n";

inline const std::string small_msh_4 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \"hilum\"\n$EndPhysicalNames\n"
    "$Entities\n0 0 1 1\n3 0 0 0 1 1 0 1 7 0\n1 0 0 0 1 1 1 0 0\n$EndEntities\n"
    "$Nodes\n2 5 1 5\n2 3 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n3 1 0 2\n4\n5\n0 0 1\n1 1 1\n$EndNodes\n"
    "$Elements\n2 3 1 3\n2 3 2 1\n1 1 2 3\n3 1 4 2\n2 1 2 3 4\n3 2 5 3 4\n$EndElements\n";

inline const std::string small_vtk_4 =
    "# vtk DataFile Version 3.0\ntwo cells\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"
    "0 0 0 1 0 0 0 1 0\n0 0 1 1 1 1\nCELLS 3 14\n3 0 1 2\n4 0 1 2 3\n4 1 4 2 3\nCELL_TYPES 3\n5\n10\n10\n";

inline const std::string small_vtk_5 =
    "# vtk DataFile Version 5.1\ntwo cells\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 float\n"
    "0 0 0 1 0 0 0 1 0\n0 0 1 1 1 1\nCELLS 3 8\nOFFSETS vtktypeint64\n0 4 8\nCONNECTIVITY vtktypeint64\n"
    "0 1 2 3 1 4 2 3\nCELL_TYPES 2\n10\n10\n";

/// Bytes of a value in the machine's order, or turned round.
template <class Value>
std::string bytes_of(Value value, bool turned = false) {
  std::string text(reinterpret_cast<const char*>(&value), sizeof value);
  return turned ? std::string(text.rbegin(), text.rend()) : text;
}

inline const double small_nodes[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
inline const std::int32_t small_cells[2][4] = {{1, 2, 3, 4}, {2, 5, 3, 4}};  // from 1

inline std::string small_msh_2_binary(bool turned) {
  const auto integer = [turned](std::int32_t i) { return bytes_of(i, turned); };
  std::string text = "$MeshFormat\n2.2 1 8\n" + integer(1) + "\n$EndMeshFormat\n$Nodes\n5\n";
  for (int i = 0; i < 5; ++i) {
    text += integer(i + 1);
    for (const double x : small_nodes[i]) text += bytes_of(x, turned);
  }
  text += "\n$EndNodes\n$Elements\n2\n" + integer(4) + integer(2) + integer(2);
  for (int c = 0; c < 2; ++c) {
    text += integer(c + 1) + integer(0) + integer(1);
    for (const std::int32_t node : small_cells[c]) text += integer(node);
  }
  return text + "\n$EndElements\n";
}

inline std::string small_msh_4_binary(bool turned) {
  const auto integer = [turned](std::int32_t i) { return bytes_of(i, turned); };
  const auto size = [turned](std::uint64_t i) { return bytes_of(i, turned); };
  std::string text = "$MeshFormat\n4.1 1 8\n" + integer(1) + "\n$EndMeshFormat\n$Nodes\n";
  text += size(1) + size(5) + size(1) + size(5) + integer(3) + integer(1) + integer(0) + size(5);
  for (std::uint64_t i = 1; i <= 5; ++i) text += size(i);
  for (const auto& node : small_nodes)
    for (const double x : node) text += bytes_of(x, turned);
  text += "\n$EndNodes\n$Elements\n" + size(1) + size(2) + size(1) + size(2) + integer(3) + integer(1) + integer(4) +
          size(2);
  for (std::uint64_t c = 0; c < 2; ++c) {
    text += size(c + 1);
    for (const std::int32_t node : small_cells[c]) text += size(static_cast<std::uint64_t>(node));
  }
  return text + "\n$EndElements\n";
}

/// Legacy VTK is big-endian whatever the machine.
inline std::string small_vtk_binary() {
  const bool turned = std::endian::native == std::endian::little;
  std::string text = "# vtk DataFile Version 3.0\ntwo cells\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n";
  for (const auto& node : small_nodes)
    for (const double x : node) text += bytes_of(x, turned);
  text += "\nCELLS 2 10\n";
  for (const auto& cell : small_cells) {
    text += bytes_of<std::int32_t>(4, turned);
    for (const std::int32_t node : cell) text += bytes_of(node - 1, turned);
  }
  text += "\nCELL_TYPES 2\n";
  for (int c = 0; c < 2; ++c) text += bytes_of<std::int32_t>(10, turned);
  return text + "\n";
}

// A unit cube; its file of faces with four corners is split into triangles.
inline const std::string cube_obj =
    "# a cube\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvn 0 0 1\n"
    "f 1 4 3 2\nf 5//1 6//1 7//1 8//1\nf 1/1 2/2 6/3 5/4\nf 2 3 7 6\nf 3 4 8 7\nf -8 -4 -1 -5\n";

}  // namespace phynness::test
