// gmsh's formats 1, 2 and 4.1, as text or binary: nodes, first-order tetrahedra and triangles, physical groups.
#include <map>
#include <unordered_map>

#include "raw_mesh.hpp"
#include "scanner.hpp"

namespace phynness::meshes {
namespace {

struct ElementType {
  int nodes;  ///< 0: unknown type
  int dimension;
};

/// Nodes and dimension of a gmsh element type, which a reader must know in order to skip or refuse it.
constexpr ElementType element_type(std::int64_t type) {
  constexpr ElementType table[] = {{0, 0},  {2, 1},  {3, 2},  {4, 2},  {4, 3},  {8, 3},  {6, 3},  {5, 3},
                                   {3, 1},  {6, 2},  {9, 2},  {10, 3}, {27, 3}, {18, 3}, {14, 3}, {1, 0},
                                   {8, 2},  {20, 3}, {15, 3}, {13, 3}, {9, 2},  {10, 2}, {12, 2}, {15, 2},
                                   {15, 2}, {21, 2}, {4, 1},  {5, 1},  {6, 1},  {20, 3}, {35, 3}, {56, 3}};
  return type > 0 && type < std::ssize(table) ? table[type] : ElementType{0, 0};
}

using GroupKey = std::pair<int, std::int64_t>;  // dimension, physical tag
using Tags = std::vector<std::int64_t>;

/// Numbers of a file. Text and binary files have the same numbers in the same order.
struct Values {
  Scanner& scanner;
  bool binary = false, swap = false;

  std::int64_t integer(const char* what) {
    return binary ? scanner.raw<std::int32_t>(what, swap) : scanner.number<std::int64_t>(what);
  }
  std::int64_t size(const char* what) {
    return binary ? scanner.raw<std::int64_t>(what, swap) : scanner.number<std::int64_t>(what);
  }
  double real(const char* what) { return binary ? scanner.raw<double>(what, swap) : scanner.number<double>(what); }
  std::array<double, 3> point() {
    std::array<double, 3> x;
    for (double& value : x) value = real("a node's coordinate");
    return x;
  }
  std::size_t checked(std::int64_t n, const char* what, std::size_t text_bytes, std::size_t binary_bytes) const {
    return scanner.checked_count(n, binary ? binary_bytes : text_bytes, what);
  }
  std::size_t count(const char* what, std::size_t text_bytes, std::size_t binary_bytes) {
    return checked(size(what), what, text_bytes, binary_bytes);
  }
  /// The number of entries of a section before version 4, which is text also in binary files.
  std::size_t text_count(const char* what, std::size_t text_bytes, std::size_t binary_bytes) {
    const std::size_t n = checked(scanner.number<std::int64_t>(what), what, text_bytes, binary_bytes);
    begin();
    return n;
  }
  void begin() {
    if (binary) scanner.line();
  }
};

/// Collects nodes and elements by the tags of the file and converts tags to 0-based positions.
class MshBuilder {
 public:
  explicit MshBuilder(const Scanner& scanner) : _scanner(scanner) {}

  void add_node(std::int64_t tag, const std::array<double, 3>& x) {
    if (!_position.emplace(tag, static_cast<std::int32_t>(_raw.nodes.size())).second)
      _scanner.fail("two nodes have the same number", std::to_string(tag));
    _raw.nodes.push_back(x);
  }

  /// Number of nodes of an element type. @throws Error for an unknown type
  std::size_t nodes_of(std::int64_t type) const {
    const int n = element_type(type).nodes;
    if (n == 0) _scanner.fail("an element has an unknown type", std::to_string(type));
    return static_cast<std::size_t>(n);
  }

  /// @param physical  physical tags of the element; 0: none
  void add_element(std::int64_t tag, std::int64_t type, const Tags& node_tags, const Tags& physical) {
    const int dimension = element_type(type).dimension;
    _nodes.clear();
    for (const std::int64_t node : node_tags) {
      const auto found = _position.find(node);
      if (found == _position.end())
        _scanner.fail("element " + std::to_string(tag) + " uses a node that is not in the file's node list",
                      "node " + std::to_string(node));
      _nodes.push_back(found->second);
    }
    for (const std::int64_t group : physical)
      if (group != 0) {
        append(_groups[{dimension, group}], _nodes);
        if (dimension == 3) _cells[group].push_back(_nodes);
      }
    if (dimension == 2 && _nodes.size() <= 4) _raw.add_polygon(_nodes);
    if (dimension == 3 && !_raw.add_cell(_nodes))
      _scanner.fail(
          "element " + std::to_string(tag) + " is not of first order",
          "gmsh element type " + std::to_string(type) + " with " + std::to_string(node_tags.size()) + " nodes",
          "mesh the body with first-order tetrahedra (gmsh -3 -order 1) and export it again");
  }

  /// Lines of dimension, tag and "name".
  void read_names(Scanner& scanner) {
    const auto n =
        scanner.checked_count(scanner.number<std::int64_t>("the number of physical names"), 3, "physical names");
    for (std::size_t i = 0; i < n; ++i) {
      const int dimension = scanner.number<int>("a physical group's dimension");
      const auto tag = scanner.number<std::int64_t>("a physical group's tag");
      const std::string_view rest = scanner.line();
      const std::size_t open = rest.find('"'), close = rest.rfind('"');
      if (dimension < 0 || dimension > 3 || open == rest.npos || close == open)
        scanner.fail("malformed physical name", std::string(rest), "write: dimension tag \"name\"");
      if (close > open + 1) _names[{dimension, tag}] = rest.substr(open + 1, close - open - 1);
    }
  }

  RawMesh finish() {
    finish_groups();
    return std::move(_raw);
  }

 private:
  template <class T>
  static void append(std::vector<T>& list, const std::vector<T>& more) {
    list.insert(list.end(), more.begin(), more.end());
  }

  /// Groups by name, or by tag number if the file gives no name. A tag without a name that several dimensions use
  /// becomes one group "7" for all of them and one group for each, "line 7", "surface 7", with a note.
  void finish_groups() {
    constexpr const char* dimension_names[] = {"point", "line", "surface", "volume"};
    std::map<std::int64_t, std::vector<int>> unnamed;
    for (const auto& [key, nodes] : _groups) {
      const auto found = _names.find(key);
      if (found == _names.end()) unnamed[key.second].push_back(key.first);
      const std::string name = found == _names.end() ? std::to_string(key.second) : found->second;
      append(_raw.groups[name], nodes);
      if (key.first == 3) append(_raw.cell_groups[name], _cells.at(key.second));
    }
    for (const auto& [tag, dimensions] : unnamed) {
      if (dimensions.size() < 2) continue;
      std::string note = "physical tag " + std::to_string(tag) + " is used by several dimensions: group '" +
                         std::to_string(tag) + "' holds all of them, and there are";
      for (const int dimension : dimensions) {
        const std::string name = std::string(dimension_names[dimension]) + ' ' + std::to_string(tag);
        append(_raw.groups[name], _groups.at({dimension, tag}));
        if (dimension == 3) _raw.cell_groups[name] = _cells.at(tag);
        note += " '" + name + "'";
      }
      _raw.notes.push_back(note);
    }
    for (auto& [name, nodes] : _raw.groups) sort_unique(nodes);
  }

  const Scanner& _scanner;
  RawMesh _raw;
  std::map<GroupKey, std::string> _names;
  std::map<GroupKey, std::vector<std::int32_t>> _groups;
  std::map<std::int64_t, std::vector<std::vector<std::int32_t>>> _cells;  ///< corners, by tag of a volume's group
  std::unordered_map<std::int64_t, std::int32_t> _position;
  std::vector<std::int32_t> _nodes;  // of the present element
};

/// Nodes of version 1 and 2.
void read_nodes(Values& values, MshBuilder& builder) {
  const std::size_t n = values.text_count("nodes", 8, 28);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int64_t tag = values.integer("a node's number");
    builder.add_node(tag, values.point());
  }
}

void read_elements_1(Values& values, MshBuilder& builder) {
  const std::size_t n = values.text_count("elements", 12, 12);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int64_t tag = values.integer("an element's number"), type = values.integer("an element's type"),
                       physical = values.integer("an element's physical tag");
    values.integer("an element's entity");
    Tags nodes(builder.nodes_of(type));
    if (const auto count = values.integer("an element's number of nodes");
        count != static_cast<std::int64_t>(nodes.size()))
      values.scanner.fail("element " + std::to_string(tag) + " has a wrong number of nodes", std::to_string(count),
                          again);
    for (auto& node : nodes) node = values.integer("an element's node");
    builder.add_element(tag, type, nodes, {physical});
  }
}

/// In binary files elements of one type form a block, in text files each has its own type.
void read_elements_2(Values& values, MshBuilder& builder) {
  const std::size_t n = values.text_count("elements", 8, 8);
  for (std::size_t read = 0; read < n;) {
    std::int64_t tag = values.binary ? 0 : values.integer("an element's number");
    const std::int64_t type = values.integer("an element's type");
    const std::size_t block =
        values.binary ? values.checked(values.integer("an element block's size"), "elements of a block", 4, 4) : 1;
    const std::size_t n_tags = values.checked(values.integer("an element's number of tags"), "tags", 2, 4);
    Tags nodes(builder.nodes_of(type)), tags(n_tags);
    if (block == 0 || block > n - read)
      values.scanner.fail("impossible size of an element block", std::to_string(block));
    for (std::size_t i = 0; i < block; ++i) {
      if (values.binary) tag = values.integer("an element's number");
      for (auto& value : tags) value = values.integer("an element's tag");
      for (auto& node : nodes) node = values.integer("an element's node");
      builder.add_element(tag, type, nodes, {tags.empty() ? 0 : tags[0]});
    }
    read += block;
  }
}

using Physical = std::map<GroupKey, Tags>;  // of each entity

/// @param is_partitioned  of $PartitionedEntities, whose blocks of nodes and elements refer to these
Physical read_entities(Values& values, bool is_partitioned) {
  Physical physical;
  values.begin();
  if (is_partitioned) {
    values.size("the number of partitions");
    const std::size_t n = values.count("ghost entities", 4, 8);
    for (std::size_t i = 0; i < 2 * n; ++i) values.integer("a ghost entity");
  }
  std::size_t counts[4];
  for (auto& n : counts) n = values.count("entities", 6, 28);
  for (int dimension = 0; dimension < 4; ++dimension)
    for (std::size_t i = 0; i < counts[dimension]; ++i) {
      const std::int64_t tag = values.integer("an entity's tag");
      if (is_partitioned) {
        for (int k = 0; k < 2; ++k) values.integer("an entity's parent");
        const std::size_t n = values.count("partitions of an entity", 2, 4);
        for (std::size_t k = 0; k < n; ++k) values.integer("a partition");
      }
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

/// Reads the blocks of a section of version 4.1 and requires that they have the declared number of entries.
/// @param read_block  reads one block. @return number of entries
template <class ReadBlock>
void read_blocks(Values& values, const char* what, std::size_t text_bytes, std::size_t binary_bytes,
                 const ReadBlock& read_block) {
  values.begin();
  const std::size_t blocks = values.count("blocks", 8, 20), n = values.count(what, text_bytes, binary_bytes);
  values.size("the smallest number");
  values.size("the largest number");
  std::size_t read = 0;
  for (std::size_t b = 0; b < blocks; ++b) read += read_block();
  if (read != n)
    values.scanner.fail(std::string("the blocks do not hold the declared number of ") + what,
                        std::to_string(read) + " instead of " + std::to_string(n));
}

void read_nodes_4(Values& values, MshBuilder& builder) {
  Tags tags;
  read_blocks(values, "nodes", 8, 32, [&] {
    const std::int64_t dimension = values.integer("a node block's dimension");
    values.integer("a node block's entity");
    const std::int64_t parametric = values.integer("a node block's parametric flag");
    tags.resize(values.count("nodes of a block", 8, 32));
    for (auto& tag : tags) tag = values.size("a node's number");
    for (const std::int64_t tag : tags) {
      builder.add_node(tag, values.point());
      for (std::int64_t k = 0; parametric != 0 && k < dimension; ++k) values.real("a parametric coordinate");
    }
    return tags.size();
  });
}

void read_elements_4(Values& values, MshBuilder& builder, const Physical& physical) {
  read_blocks(values, "elements", 4, 16, [&] {
    const auto dimension = static_cast<int>(values.integer("an element block's dimension"));
    const std::int64_t entity = values.integer("an element block's entity");
    const std::int64_t type = values.integer("an element block's type");
    Tags nodes(builder.nodes_of(type));
    const auto found = physical.find({dimension, entity});
    const Tags groups = found == physical.end() ? Tags{} : found->second;
    const std::size_t count = values.count("elements of a block", 4, 16);
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t tag = values.size("an element's number");
      for (auto& node : nodes) node = values.size("an element's node");
      builder.add_element(tag, type, nodes, groups);
    }
    return count;
  });
}

/// Moves past the word that ends a section; binary data need no line break before it.
void skip_section(Scanner& scanner, const std::string& name) {
  const std::string end = "$End" + name.substr(1);
  if (!scanner.skip_past(end)) scanner.truncated(end);
}

void expect_end(Scanner& scanner, const std::string& name) {
  if (const std::string_view found = scanner.word(name.c_str()); found != name) {
    if (name.starts_with(found) && scanner.at_end()) scanner.truncated(name);
    scanner.fail("expected " + name, found,
                 "export the file again; the section has more or fewer entries than it declares");
  }
}

/// The sections after the header.
RawMesh read_sections(Values values, int version) {
  Scanner& scanner = values.scanner;
  MshBuilder builder(scanner);
  Physical physical;
  const std::string nodes = version == 1 ? "$NOD" : "$Nodes", elements = version == 1 ? "$ELM" : "$Elements";
  bool nodes_seen = false, elements_seen = false;
  for (std::string section(scanner.word_or_end()); !section.empty(); section = scanner.word_or_end()) {
    if (section == nodes) {
      version == 4 ? read_nodes_4(values, builder) : read_nodes(values, builder);
      nodes_seen = true;
    } else if (section == elements) {
      if (!nodes_seen) scanner.fail(elements + " is before " + nodes);
      if (version == 1) read_elements_1(values, builder);
      if (version == 2) read_elements_2(values, builder);
      if (version == 4) read_elements_4(values, builder, physical);
      elements_seen = true;
    } else if (version > 1 && section == "$PhysicalNames") {
      builder.read_names(scanner);
    } else if (version == 4 && (section == "$Entities" || section == "$PartitionedEntities")) {
      Physical more = read_entities(values, section != "$Entities");  // the parts go before the whole
      more.merge(physical);
      physical = std::move(more);
    } else {
      if (version == 1 || !section.starts_with("$") || section.starts_with("$End"))
        scanner.fail("expected the start of a section", section);
      skip_section(scanner, section);
      continue;
    }
    expect_end(scanner, (version == 1 ? "$END" : "$End") + section.substr(1));
  }
  if (!nodes_seen) scanner.truncated(nodes);
  if (!elements_seen) scanner.truncated(elements);
  return builder.finish();
}

}  // namespace

RawMesh read_msh(const std::string& bytes, const std::string& source) {
  Scanner scanner(bytes, source);
  Scanner probe = scanner;
  constexpr std::size_t longest_name = 40;  // limits the message for a damaged file of one word
  std::string section(probe.word_or_end().substr(0, longest_name));
  if (section == "$NOD") return read_sections({scanner}, 1);
  // Comments are allowed before the header.
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
      scanner.fail("the byte order mark of the binary file is damaged", std::to_string(one));
    swap = one != 1;
  }
  expect_end(scanner, "$EndMeshFormat");
  if (version == "2" || version.starts_with("2.")) return read_sections({scanner, binary == 1, swap}, 2);
  if (version == "4.1") return read_sections({scanner, binary == 1, swap}, 4);
  scanner.fail("unsupported .msh version", version, "export the mesh as version 4.1 or 2.2 (gmsh -format msh41)");
}

}  // namespace phynness::meshes
