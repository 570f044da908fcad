// Common parts of the .msh readers of all versions: the numbering of nodes and the classification of elements.
#pragma once

#include <unordered_map>
#include <vector>

#include "raw_mesh.hpp"
#include "scanner.hpp"

namespace phynness::meshes {

/// Collects nodes and elements by the tags of the file and converts tags to 0-based positions.
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
  std::vector<std::int32_t> _nodes;  // of the present element
};

/// The body of a file of each version, after the header; text or binary.
RawMesh read_msh_1(Scanner& scanner);
RawMesh read_msh_2(Scanner& scanner, bool binary, bool swap);
RawMesh read_msh_4(Scanner& scanner, bool binary, bool swap);

/// Reads a section of physical names: lines of dimension, tag and "name" (versions 2.2 and 4.1).
void read_physical_names(Scanner& scanner, MshBuilder& builder);
/// Moves past the line $EndNAME of a section that is not used.
void skip_section(Scanner& scanner, const std::string& name);
/// Moves past the word $EndNAME. @throws Error if another word is found
void expect_end(Scanner& scanner, const std::string& name);

}  // namespace phynness::meshes
