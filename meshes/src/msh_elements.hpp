// What the .msh readers of all versions share: the node numbering and the sorting of elements.
#pragma once

#include <unordered_map>
#include <vector>

#include "raw_mesh.hpp"
#include "scanner.hpp"

namespace phynness::meshes {

/// Collects nodes and elements by the file's own tags and turns them into 0-based positions.
class MshBuilder {
 public:
  explicit MshBuilder(const Scanner& scanner) : _scanner(scanner) {}

  void add_node(std::int64_t tag, const std::array<double, 3>& x);
  /// @param physical  physical tags of the element's entity (0 = none)
  void add_element(std::int64_t tag, std::int64_t type, const std::vector<std::int64_t>& node_tags,
                   const std::vector<std::int64_t>& physical);
  void name_group(int dimension, std::int64_t tag, std::string name) { _groups.name(dimension, tag, std::move(name)); }
  /// @throws Error if there are neither tetrahedra nor triangles
  RawMesh finish();

 private:
  const Scanner& _scanner;
  RawMesh _raw;
  GroupBuilder _groups;
  std::unordered_map<std::int64_t, std::int32_t> _position;
  std::vector<std::int32_t> _nodes;  // of the element at hand
};

/// The body of each version, from behind the header; text or binary.
RawMesh read_msh_1(Scanner& scanner);
RawMesh read_msh_2(Scanner& scanner, bool binary, bool swap);
RawMesh read_msh_4(Scanner& scanner, bool binary, bool swap);

/// One section's physical names: "dimension tag "name"" lines (versions 2.2 and 4.1).
void read_physical_names(Scanner& scanner, MshBuilder& builder);
/// Moves behind the line $EndNAME of a section that is of no interest.
void skip_section(Scanner& scanner, const std::string& name);
/// Moves behind the word $EndNAME. @throws Error if something else stands there
void expect_end(Scanner& scanner, const std::string& name);

}  // namespace phynness::meshes
