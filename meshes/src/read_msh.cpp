#include "element_types.hpp"
#include "msh_elements.hpp"

namespace phynness::meshes {

void MshBuilder::add_node(std::int64_t tag, const std::array<double, 3>& x) {
  const auto position = static_cast<std::int32_t>(_raw.nodes.size());
  if (!_position.emplace(tag, position).second)
    _scanner.fail("two nodes have the same number", std::to_string(tag), "export the file again");
  _raw.nodes.push_back(x);
}

void MshBuilder::add_element(std::int64_t tag, std::int64_t type, const std::vector<std::int64_t>& node_tags,
                             const std::vector<std::int64_t>& physical) {
  const int dimension = gmsh_element_type(type).dimension;
  if (dimension == 3 && type != gmsh_tetrahedron)
    _scanner.fail("element " + std::to_string(tag) + " is not a 4-node tetrahedron",
                  "gmsh element type " + std::to_string(type) + " with " + std::to_string(node_tags.size()) + " nodes",
                  "mesh the body with first-order tetrahedra (gmsh -3 -order 1) and export it again");
  _nodes.clear();
  for (const std::int64_t node : node_tags) {
    const auto found = _position.find(node);
    if (found == _position.end())
      _scanner.fail("element " + std::to_string(tag) + " uses a node that is not in the file's node list",
                    "node " + std::to_string(node), "export the file again");
    _nodes.push_back(found->second);
  }
  for (const std::int64_t group : physical) _groups.add(dimension, group, _nodes);
  if (type == gmsh_tetrahedron) _raw.tetrahedra.push_back({_nodes[0], _nodes[1], _nodes[2], _nodes[3]});
  if (type == gmsh_triangle) _raw.triangles.push_back({_nodes[0], _nodes[1], _nodes[2]});
}

RawMesh MshBuilder::finish() {
  if (_raw.tetrahedra.empty() && _raw.triangles.empty())
    throw input_error(_scanner.source() + ": the file holds neither tetrahedra nor triangles",
                      std::to_string(_raw.nodes.size()) + " nodes",
                      "mesh the body with first-order tetrahedra and save all elements (gmsh: Mesh.SaveAll)");
  _groups.finish(_raw);
  return std::move(_raw);
}

void read_physical_names(Scanner& scanner, MshBuilder& builder) {
  const auto n =
      scanner.checked_count(scanner.number<std::int64_t>("the number of physical names"), 3, "physical names");
  for (std::size_t i = 0; i < n; ++i) {
    const int dimension = scanner.number<int>("a physical group's dimension");
    const auto tag = scanner.number<std::int64_t>("a physical group's tag");
    const std::string_view rest = scanner.line();
    const std::size_t open = rest.find('"'), close = rest.rfind('"');
    if (dimension < 0 || dimension > 3 || open == rest.npos || close == open)
      scanner.fail("malformed physical name", std::string(rest), "write: dimension tag \"name\"");
    if (close > open + 1) builder.name_group(dimension, tag, std::string(rest.substr(open + 1, close - open - 1)));
  }
}

void skip_section(Scanner& scanner, const std::string& name) {
  const std::string end = "$End" + name.substr(1);
  while (!scanner.at_end())
    if (scanner.line().starts_with(end)) return;
  scanner.truncated(end);
}

void expect_end(Scanner& scanner, const std::string& name) {
  if (const std::string_view found = scanner.word(name.c_str()); found != name) {
    if (name.starts_with(found) && scanner.at_end()) scanner.truncated(name);
    scanner.fail("expected " + name, std::string(found.substr(0, 40)),
                 "export the file again; the section has more or fewer entries than it declares");
  }
}

RawMesh read_msh_1(Scanner& scanner) {
  MshBuilder builder(scanner);
  bool nodes_seen = false, elements_seen = false;
  while (true) {
    const std::string section(scanner.word_or_end());
    if (section.empty()) break;
    if (section == "$NOD") {
      const auto n = scanner.checked_count(scanner.number<std::int64_t>("the number of nodes"), 8, "nodes");
      for (std::size_t i = 0; i < n; ++i) {
        const auto tag = scanner.number<std::int64_t>("a node's number");
        std::array<double, 3> x;
        for (double& value : x) value = scanner.number<double>("a node's coordinate");
        builder.add_node(tag, x);
      }
      expect_end(scanner, "$ENDNOD");
      nodes_seen = true;
    } else if (section == "$ELM") {
      if (!nodes_seen) scanner.fail("$ELM is before $NOD", "", "export the file again");
      const auto n = scanner.checked_count(scanner.number<std::int64_t>("the number of elements"), 12, "elements");
      std::vector<std::int64_t> nodes;
      for (std::size_t i = 0; i < n; ++i) {
        const auto tag = scanner.number<std::int64_t>("an element's number");
        const auto type = scanner.number<std::int64_t>("an element's type");
        const auto physical = scanner.number<std::int64_t>("an element's physical tag");
        scanner.number<std::int64_t>("an element's entity");
        const auto count = scanner.number<std::int64_t>("an element's number of nodes");
        if (gmsh_element_type(type).nodes == 0 || gmsh_element_type(type).nodes != count)
          scanner.fail("element " + std::to_string(tag) + " has an unknown type or a wrong number of nodes",
                       "type " + std::to_string(type) + ", " + std::to_string(count) + " nodes",
                       "export the file again");
        nodes.resize(static_cast<std::size_t>(count));
        for (auto& node : nodes) node = scanner.number<std::int64_t>("an element's node");
        builder.add_element(tag, type, nodes, {physical});
      }
      expect_end(scanner, "$ENDELM");
      elements_seen = true;
    } else {
      scanner.fail("unknown section of a .msh 1 file", section.substr(0, 40),
                   "export the file again as .msh 4.1 or 2.2");
    }
  }
  if (!nodes_seen) scanner.truncated("$NOD");
  if (!elements_seen) scanner.truncated("$ELM");
  return builder.finish();
}

RawMesh read_msh(const std::string& bytes, const std::string& source) {
  Scanner scanner(bytes, source);
  Scanner probe = scanner;
  constexpr std::size_t longest_name = 40;  // limits the message for a damaged file of one word
  const std::string first(probe.word_or_end().substr(0, longest_name));
  if (first == "$NOD") return read_msh_1(scanner);
  // Comments are allowed before the header.
  std::string section = first;
  while (section == "$Comments" || section == "$Comment") {
    skip_section(probe, section);
    section = std::string(probe.word_or_end().substr(0, longest_name));
  }
  if (section != "$MeshFormat")
    scanner.fail("not a gmsh mesh: it does not start with $MeshFormat or $NOD", section,
                 "export the mesh as .msh 4.1 or 2.2");
  scanner = probe;
  const std::string version(scanner.word("the format version"));
  const int binary = scanner.number<int>("the file type (0 text, 1 binary)");
  const int size = scanner.number<int>("the data size");
  if ((binary != 0 && binary != 1) || size != 8)
    scanner.fail("unsupported .msh file type or data size", std::to_string(binary) + " " + std::to_string(size),
                 "export the mesh as .msh 4.1 or 2.2 with 8-byte numbers");
  bool swap = false;
  if (binary == 1) {
    scanner.line();
    const auto one = scanner.raw<std::int32_t>("the byte order mark", false);
    if (one != 1 && one != 0x01000000)
      scanner.fail("the byte order mark of the binary file is damaged", std::to_string(one), "export the file again");
    swap = one != 1;
  }
  expect_end(scanner, "$EndMeshFormat");
  if (version == "2" || version.starts_with("2.")) return read_msh_2(scanner, binary == 1, swap);
  if (version == "4.1") return read_msh_4(scanner, binary == 1, swap);
  scanner.fail("unsupported .msh version", version, "export the mesh as version 4.1 or 2.2 (gmsh -format msh41)");
}

}  // namespace phynness::meshes
