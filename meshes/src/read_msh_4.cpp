#include "element_types.hpp"
#include "msh_elements.hpp"

namespace phynness::meshes {
namespace {

/// Reads values of version 4.1. Text and binary files have the same values in the same order.
class Values {
 public:
  Values(Scanner& scanner, bool binary, bool swap) : _scanner(scanner), _binary(binary), _swap(swap) {}

  std::int64_t integer(const char* what) {
    return _binary ? _scanner.raw<std::int32_t>(what, _swap) : _scanner.number<std::int64_t>(what);
  }
  std::int64_t size(const char* what) {
    return _binary ? _scanner.raw<std::int64_t>(what, _swap) : _scanner.number<std::int64_t>(what);
  }
  double real(const char* what) { return _binary ? _scanner.raw<double>(what, _swap) : _scanner.number<double>(what); }
  std::size_t count(const char* what, std::size_t text_bytes, std::size_t binary_bytes) {
    const std::int64_t n = size(what);
    return _scanner.checked_count(n, _binary ? binary_bytes : text_bytes, what);
  }
  void begin() {
    if (_binary) _scanner.line();
  }
  Scanner& scanner() { return _scanner; }

 private:
  Scanner& _scanner;
  bool _binary, _swap;
};

using Physical = std::map<std::pair<int, std::int64_t>, std::vector<std::int64_t>>;

Physical read_entities(Values& values) {
  Physical physical;
  values.begin();
  std::size_t counts[4];
  for (auto& n : counts) n = values.count("entities", 6, 28);
  for (int dimension = 0; dimension < 4; ++dimension)
    for (std::size_t i = 0; i < counts[dimension]; ++i) {
      const std::int64_t tag = values.integer("an entity's tag");
      for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) values.real("an entity's bounding box");
      auto& tags = physical[{dimension, tag}];
      tags.resize(values.count("physical tags", 2, 4));
      // gmsh negates a tag if the group and the entity have opposite orientations.
      for (auto& group : tags) group = std::abs(values.integer("a physical tag"));
      if (dimension == 0) continue;
      const std::size_t n = values.count("bounding entities", 2, 4);
      for (std::size_t k = 0; k < n; ++k) values.integer("a bounding entity");
    }
  return physical;
}

void read_nodes(Values& values, MshBuilder& builder) {
  values.begin();
  const std::size_t blocks = values.count("node blocks", 8, 20);
  const std::size_t n = values.count("nodes", 8, 32);
  values.size("the smallest node number");
  values.size("the largest node number");
  std::size_t read = 0;
  std::vector<std::int64_t> tags;
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::int64_t dimension = values.integer("a node block's dimension");
    values.integer("a node block's entity");
    const std::int64_t parametric = values.integer("a node block's parametric flag");
    tags.resize(values.count("nodes of a block", 8, 32));
    for (auto& tag : tags) tag = values.size("a node's number");
    for (const std::int64_t tag : tags) {
      std::array<double, 3> x;
      for (double& value : x) value = values.real("a node's coordinate");
      for (std::int64_t k = 0; parametric != 0 && k < dimension; ++k) values.real("a parametric coordinate");
      builder.add_node(tag, x);
    }
    read += tags.size();
  }
  if (read != n)
    values.scanner().fail("the node blocks do not hold the declared number of nodes",
                          std::to_string(read) + " instead of " + std::to_string(n), "export the file again");
  expect_end(values.scanner(), "$EndNodes");
}

void read_elements(Values& values, MshBuilder& builder, const Physical& physical) {
  values.begin();
  const std::size_t blocks = values.count("element blocks", 8, 20);
  const std::size_t n = values.count("elements", 4, 16);
  values.size("the smallest element number");
  values.size("the largest element number");
  std::size_t read = 0;
  std::vector<std::int64_t> nodes;
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto dimension = static_cast<int>(values.integer("an element block's dimension"));
    const std::int64_t entity = values.integer("an element block's entity");
    const std::int64_t type = values.integer("an element block's type");
    const auto info = gmsh_element_type(type);
    if (info.nodes == 0)
      values.scanner().fail("an element block has an unknown type", std::to_string(type), "export the file again");
    const auto found = physical.find({dimension, entity});
    const std::vector<std::int64_t> groups = found == physical.end() ? std::vector<std::int64_t>{} : found->second;
    const std::size_t count = values.count("elements of a block", 4, 16);
    nodes.resize(static_cast<std::size_t>(info.nodes));
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t tag = values.size("an element's number");
      for (auto& node : nodes) node = values.size("an element's node");
      builder.add_element(tag, type, nodes, groups);
    }
    read += count;
  }
  if (read != n)
    values.scanner().fail("the element blocks do not hold the declared number of elements",
                          std::to_string(read) + " instead of " + std::to_string(n), "export the file again");
  expect_end(values.scanner(), "$EndElements");
}

}  // namespace

RawMesh read_msh_4(Scanner& scanner, bool binary, bool swap) {
  MshBuilder builder(scanner);
  Values values(scanner, binary, swap);
  Physical physical;
  bool nodes_seen = false, elements_seen = false;
  while (true) {
    const std::string section(scanner.word_or_end());
    if (section.empty()) break;
    if (section == "$PhysicalNames") {
      read_physical_names(scanner, builder);
      expect_end(scanner, "$EndPhysicalNames");
    } else if (section == "$Entities") {
      physical = read_entities(values);
      expect_end(scanner, "$EndEntities");
    } else if (section == "$Nodes") {
      read_nodes(values, builder);
      nodes_seen = true;
    } else if (section == "$Elements") {
      if (!nodes_seen) scanner.fail("$Elements is before $Nodes", "", "export the file again");
      read_elements(values, builder, physical);
      elements_seen = true;
    } else if (section.starts_with("$") && !section.starts_with("$End")) {
      if (section == "$PartitionedEntities")
        scanner.fail("the mesh is partitioned", section,
                     "save it unpartitioned (gmsh: Mesh.PartitionSplitMeshFiles 0)");
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
