#include "element_types.hpp"
#include "msh_elements.hpp"

namespace phynness::meshes {
namespace {

void read_nodes(Scanner& scanner, MshBuilder& builder, bool binary, bool swap) {
  const auto declared = scanner.number<std::int64_t>("the number of nodes");
  const auto n = scanner.checked_count(declared, binary ? 28 : 8, "nodes");
  if (binary) scanner.line();
  for (std::size_t i = 0; i < n; ++i) {
    const std::int64_t tag =
        binary ? scanner.raw<std::int32_t>("a node's number", swap) : scanner.number<std::int64_t>("a node's number");
    std::array<double, 3> x;
    for (double& value : x)
      value = binary ? scanner.raw<double>("a node's coordinate", swap) : scanner.number<double>("a node's coordinate");
    builder.add_node(tag, x);
  }
  expect_end(scanner, "$EndNodes");
}

std::size_t nodes_of(const Scanner& scanner, std::int64_t tag, std::int64_t type) {
  const int n = gmsh_element_type(type).nodes;
  if (n == 0)
    scanner.fail("element " + std::to_string(tag) + " has an unknown type", std::to_string(type),
                 "export the file again");
  return static_cast<std::size_t>(n);
}

void read_text_elements(Scanner& scanner, MshBuilder& builder, std::size_t n) {
  std::vector<std::int64_t> nodes;
  for (std::size_t i = 0; i < n; ++i) {
    const auto tag = scanner.number<std::int64_t>("an element's number");
    const auto type = scanner.number<std::int64_t>("an element's type");
    nodes.resize(nodes_of(scanner, tag, type));
    const auto n_tags = scanner.checked_count(scanner.number<std::int64_t>("an element's number of tags"), 2, "tags");
    std::int64_t physical = 0;
    for (std::size_t k = 0; k < n_tags; ++k) {
      const auto value = scanner.number<std::int64_t>("an element's tag");
      if (k == 0) physical = value;
    }
    for (auto& node : nodes) node = scanner.number<std::int64_t>("an element's node");
    builder.add_element(tag, type, nodes, {physical});
  }
}

void read_binary_elements(Scanner& scanner, MshBuilder& builder, std::size_t n, bool swap) {
  scanner.line();
  std::vector<std::int64_t> nodes;
  const auto integer = [&](const char* what) { return scanner.raw<std::int32_t>(what, swap); };
  for (std::size_t read = 0; read < n;) {
    const auto type = integer("an element block's type");
    const auto block = scanner.checked_count(integer("an element block's size"), 4, "elements of a block");
    const auto n_tags = integer("an element block's number of tags");
    nodes.resize(nodes_of(scanner, static_cast<std::int64_t>(read), type));
    if (block == 0 || block > n - read || n_tags < 0)
      scanner.fail("impossible size of an element block", std::to_string(block), "export the file again");
    for (std::size_t i = 0; i < block; ++i) {
      const auto tag = integer("an element's number");
      std::int64_t physical = 0;
      for (int k = 0; k < n_tags; ++k) {
        const auto value = integer("an element's tag");
        if (k == 0) physical = value;
      }
      for (auto& node : nodes) node = integer("an element's node");
      builder.add_element(tag, type, nodes, {physical});
    }
    read += block;
  }
}

}  // namespace

RawMesh read_msh_2(Scanner& scanner, bool binary, bool swap) {
  MshBuilder builder(scanner);
  bool nodes_seen = false, elements_seen = false;
  while (true) {
    const std::string section(scanner.word_or_end());
    if (section.empty()) break;
    if (section == "$PhysicalNames") {
      read_physical_names(scanner, builder);
      expect_end(scanner, "$EndPhysicalNames");
    } else if (section == "$Nodes") {
      read_nodes(scanner, builder, binary, swap);
      nodes_seen = true;
    } else if (section == "$Elements") {
      if (!nodes_seen) scanner.fail("$Elements is before $Nodes", "", "export the file again");
      const auto n = scanner.checked_count(scanner.number<std::int64_t>("the number of elements"), 8, "elements");
      if (binary)
        read_binary_elements(scanner, builder, n, swap);
      else
        read_text_elements(scanner, builder, n);
      expect_end(scanner, "$EndElements");
      elements_seen = true;
    } else if (section.starts_with("$") && !section.starts_with("$End")) {
      skip_section(scanner, section);
    } else {
      scanner.fail("expected the start of a section", section.substr(0, 40), "export the file again");
    }
  }
  if (!nodes_seen) scanner.truncated("$Nodes");
  if (!elements_seen) scanner.truncated("$Elements");
  return builder.finish();
}

}  // namespace phynness::meshes
