#include "database_layout.hpp"

#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <sstream>

#include "ray_columns.hpp"

namespace phynness::database_layout {
namespace {

const char* const format_name = "phynness database";

template <class T>
void write_array(hdf5::File& file, const char* name, const hdf5::Shape& shape, const T* values, const char* unit,
                 const char* description) {
  // A single chunk, because only chunked datasets have checksums.
  const bool empty = std::find(shape.begin(), shape.end(), hsize_t{0}) != shape.end();
  file.create_dataset(name, hdf5::type_of(T{}).stored, shape, empty ? hdf5::Shape{} : shape, unit, description);
  if (!empty) file.write_slab(name, 0, shape[0], values);
}

template <class T>
void write_list(hdf5::File& file, const std::string& name, const std::vector<T>& list, const std::string& description,
                const char* unit = "1") {
  write_array(file, name.c_str(), {list.size()}, list.data(), unit, description.c_str());
}

template <class Matrix>
void write_rows(hdf5::File& file, const char* name, const Matrix& matrix, const char* unit, const char* description) {
  write_array(file, name, {static_cast<hsize_t>(matrix.rows()), static_cast<hsize_t>(matrix.cols())}, matrix.data(),
              unit, description);
}

template <class T>
std::vector<T> read_list(const hdf5::File& file, const std::string& name) {
  auto shape = file.shape(name);
  shape.resize(1);
  return file.read<T>(name, shape);
}

/// Reads rows of `columns` entries; the file determines the number of rows.
template <class Matrix>
Matrix read_rows(const hdf5::File& file, const char* name, hsize_t columns = 3) {
  const auto shape = file.shape(name);
  const hsize_t rows = shape.empty() ? 0 : shape[0];
  const auto values = file.read<typename Matrix::Scalar>(name, {rows, columns});
  return Eigen::Map<const Matrix>(values.data(), static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
}

bool read_flag(const hdf5::File& file, const char* object, const char* name) {
  const auto value = file.read_int_attribute(object, name);
  if (value != 0 && value != 1)
    file.refuse(std::string("attribute ") + name + " of " + object + " is neither 0 nor 1", std::to_string(value));
  return value == 1;
}

/// @throws Error (input) if a name is unknown, repeated or out of order
std::vector<Field> fields_of(const std::string& text) {
  std::vector<Field> fields;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const auto field = field_named(word);
    if (!field || (!fields.empty() && *field <= fields.back()))
      throw input_error("the database has unknown fields, or fields in the wrong order", text, hdf5::damaged);
    fields.push_back(*field);
  }
  return fields;
}

std::string in(const char* group, const char* dataset) { return std::string(group) + "/" + dataset; }

/// The tools one after another, in a group of their own.
void write_tools(hdf5::File& file, const char* group, const std::vector<TouchedNodes>& tools,
                 const std::string& where) {
  std::vector<std::int32_t> ends, nodes;
  std::vector<double> weights;
  for (const auto& tool : tools) {
    nodes.insert(nodes.end(), tool.nodes.begin(), tool.nodes.end());
    weights.insert(weights.end(), tool.weights.begin(), tool.weights.end());
    ends.push_back(static_cast<std::int32_t>(nodes.size()));
  }
  file.create_group(group);
  file.write_attribute(group, "mean", std::int32_t{!tools.empty() && tools.front().mean});
  write_list(file, in(group, "ends"), ends,
             "of the tool at each " + where + ", the position behind its last node in the next two");
  write_list(file, in(group, "nodes"), nodes, "ascending node numbers that each tool moves");
  write_list(file, in(group, "weights"), weights, "their weights");
}

/// @throws Error (input) unless the numbers are those of nodes of the mesh
void require_nodes(const hdf5::File& file, const char* name, const NodeList& numbers, Eigen::Index n_nodes) {
  for (const auto number : numbers)
    if (number < 0 || number >= n_nodes)
      file.refuse(std::string(name) + " has a number that no node has", std::to_string(number));
}

std::vector<TouchedNodes> read_tools(const hdf5::File& file, const char* group, Eigen::Index n_nodes) {
  const bool mean = read_flag(file, group, "mean");
  const auto all_ends = in(group, "ends"), all_nodes = in(group, "nodes"), all_weights = in(group, "weights");
  const auto ends = read_list<std::int32_t>(file, all_ends), nodes = read_list<std::int32_t>(file, all_nodes);
  const auto weights = read_list<double>(file, all_weights);
  if (weights.size() != nodes.size())
    file.refuse(all_weights + " and " + all_nodes + " have different lengths",
                std::to_string(weights.size()) + " and " + std::to_string(nodes.size()));
  require_nodes(file, all_nodes.c_str(), nodes, n_nodes);
  std::vector<TouchedNodes> tools;
  std::int32_t first = 0;
  for (const auto end : ends) {
    if (end <= first || end > std::ssize(nodes))
      file.refuse(all_ends + " must ascend, up to the length of " + all_nodes,
                  std::to_string(end) + " after " + std::to_string(first));
    tools.push_back(
        {{nodes.begin() + first, nodes.begin() + end}, {weights.begin() + first, weights.begin() + end}, mean});
    first = end;
  }
  return tools;
}

/// Attributes that name the values of an enumeration.
template <class Code, std::size_t n>
void write_flags(hdf5::File& file, const char* dataset, const CodeRow<Code> (&rows)[n]) {
  std::vector<std::int8_t> values;
  std::string meanings;
  for (const auto& row : rows) {
    values.push_back(static_cast<std::int8_t>(row.code));
    if (!meanings.empty()) meanings += ' ';
    meanings += row.name;
  }
  file.write_attribute(dataset, "flag_values", values);
  file.write_attribute(dataset, "flag_meanings", meanings);
}

void create_column(hdf5::File& file, const StoredColumn& column, const DatabaseHeader& header) {
  hdf5::Shape shape{header.sets.active.size(), header.directions.size()};
  shape.insert(shape.end(), column.shape.begin(), column.shape.end());
  const hid_t type =
      std::visit([](auto member) { return hdf5::type_of(ValueOf<decltype(member)>{}).stored; }, column.member);
  const bool is_field = std::holds_alternative<RayColumn::FieldIndex>(column.member);
  file.create_dataset(column.path, column.float32 ? hdf5::type_of(float{}).stored : type, shape,
                      chunk_shape(column, header), column.unit,
                      std::string(column.description) + (is_field ? ", at the output nodes" : ""));
}

}  // namespace

std::uint64_t header_bytes(const DatabaseHeader& header) {
  const Mesh& mesh = header.mesh;
  // With sets, groups and images of nodes, and twice because what does not compress becomes a little longer.
  return 2 * (static_cast<std::uint64_t>(mesh.nodes.rows()) * 64 +
              static_cast<std::uint64_t>(mesh.cells.size() + mesh.surface.size()) * sizeof(std::int32_t) +
              header.directions.size() * sizeof(Vec3) + header.scene_text.size());
}

void write_header(hdf5::File& file, const DatabaseHeader& header, bool complete) {
  file.write_attribute("/", "format", std::string(format_name));
  file.write_attribute("/", "format_version", format_version);
  file.write_attribute("/", "software_version", header.software_version);
  file.write_attribute("/", "complete", std::int32_t{complete});
  file.write_attribute("/", "physics_hash", header.physics_hash);
  file.write_attribute("/", "mesh_hash", header.mesh_hash);
  file.write_attribute("/", "tangents", std::int32_t{header.tangents});
  file.write_attribute("/", "displacement_precision", std::string(header.float64 ? "float64" : "float32"));
  file.write_attribute("/", "field_bits", std::int32_t{header.field_bits});
  file.write_attribute("/", "fields", names(header.fields, " "));
  file.write_attribute("/", "scene_name", header.scene_name);
  file.write_attribute("/", "scene_folder", header.scene_folder);
  if (header.imported) file.write_attribute("/", "imported", std::int32_t{1});
  // A dataset, because attributes are limited to 64 kB and a scene may list many nodes.
  file.write_text(path::scene, header.scene_text, "the scene file, verbatim (TOML)");

  const Mesh& mesh = header.mesh;
  file.create_group("/mesh");
  write_rows(file, path::nodes, mesh.nodes, "m", "reference positions of the nodes");
  write_rows(file, path::cells, mesh.cells, "1", "node numbers of each cell, 0-based, positively oriented");
  write_rows(file, path::surface, mesh.surface, "1", "node numbers of each boundary triangle, normal outward");
  file.create_group(path::groups);
  int number = 0;
  for (const auto& [group, nodes] : mesh.groups) {
    const std::string name = std::string(path::groups) + "/" + std::to_string(number++);
    write_list(file, name, nodes, "nodes of a physical group of the mesh file");
    file.write_attribute(name, "name", group);
  }

  if (!mesh.regions.empty())
    write_list(file, path::regions, mesh.regions, "of each cell: 0 = [material], i + 1 = the i-th [[region]] from 0");

  file.create_group("/sets");
  write_list(file, path::fixed, header.sets.fixed, "node numbers where u = 0");
  write_list(file, path::active, header.sets.active, "node numbers that are probed; axis A of the responses");
  write_list(file, path::output, header.sets.output,
             "node numbers whose displacement is stored; axis O of the responses");
  write_tools(file, path::tools, header.sets.tools, "active node");
  if (!header.sets.linear.empty()) {
    write_tools(file, path::rest, header.sets.linear_tools, "of these points");
    write_list(file, path::rest_points, header.sets.linear,
               "node numbers of the free surface beside those that are probed; axis L of the responses at rest");
  }
  const Vec3* first = header.directions.data();
  const Eigen::Map<const Points> directions(first ? first->data() : nullptr, std::ssize(header.directions), 3);
  write_rows(file, path::directions, directions, "1",
             "unit vectors of the exploratory directions; axis D of the responses");
  write_list(file, path::magnitudes, header.magnitudes_m,
             "prescribed displacement of each increment; axis I of the responses", "m");
}

bool read_complete(const hdf5::File& file) {
  if (!file.has_attribute("/", "format") || file.read_text_attribute("/", "format") != format_name)
    throw input_error("the HDF5 file is not a phynness database", file.path().string(),
                      "give a file written by phynness precompute");
  const auto version = file.read_int_attribute("/", "format_version");
  if (version != format_version)
    throw input_error("the database " + file.path().string() + " has another version of the format",
                      std::to_string(version) + " instead of " + std::to_string(format_version),
                      "make it anew with: phynness precompute SCENE -o DATABASE");
  return read_flag(file, "/", "complete");
}

DatabaseHeader read_header(const hdf5::File& file) {
  read_complete(file);
  DatabaseHeader header;
  header.software_version = file.read_text_attribute("/", "software_version");
  header.physics_hash = file.read_text_attribute("/", "physics_hash");
  header.mesh_hash = file.read_text_attribute("/", "mesh_hash");
  header.tangents = read_flag(file, "/", "tangents");
  const auto precision = file.read_text_attribute("/", "displacement_precision");
  if (precision != "float32" && precision != "float64")
    file.refuse("attribute displacement_precision is neither float32 nor float64", precision);
  header.float64 = precision == "float64";
  header.field_bits = file.read_int_attribute("/", "field_bits");
  header.fields = fields_of(file.read_text_attribute("/", "fields"));
  header.scene_name = file.read_text_attribute("/", "scene_name");
  header.scene_folder = file.read_text_attribute("/", "scene_folder");
  header.scene_text = file.read_text(path::scene);

  header.imported = file.has_attribute("/", "imported") && read_flag(file, "/", "imported");

  header.mesh.nodes = read_rows<Points>(file, path::nodes);
  const auto cell_shape = file.shape(path::cells);
  header.mesh.cells = read_rows<Cells>(file, path::cells, cell_shape.size() == 2 ? cell_shape[1] : 0);
  header.mesh.surface = read_rows<Triangles>(file, path::surface);
  for (int number = 0;; ++number) {
    const std::string name = std::string(path::groups) + "/" + std::to_string(number);
    if (!file.exists(name)) break;
    const auto group = file.read_text_attribute(name, "name");
    if (!header.mesh.groups.emplace(group, read_list<std::int32_t>(file, name)).second)
      file.refuse("two groups have the same name", group);
  }

  if (file.exists(path::regions)) {
    header.mesh.regions = read_list<std::uint8_t>(file, path::regions);
    if (std::ssize(header.mesh.regions) != header.mesh.cells.rows())
      file.refuse("/mesh/regions does not have a number for each cell", std::to_string(header.mesh.regions.size()));
  }

  header.sets.fixed = read_list<std::int32_t>(file, path::fixed);
  header.sets.active = read_list<std::int32_t>(file, path::active);
  header.sets.output = read_list<std::int32_t>(file, path::output);
  for (const auto& [name, set] : {std::pair{path::fixed, &header.sets.fixed},
                                  {path::active, &header.sets.active},
                                  {path::output, &header.sets.output}})
    require_nodes(file, name, *set, header.mesh.n_nodes());
  header.sets.tools = read_tools(file, path::tools, header.mesh.n_nodes());
  if (file.exists(path::rest)) {
    header.sets.linear = read_list<std::int32_t>(file, path::rest_points);
    require_nodes(file, path::rest_points, header.sets.linear, header.mesh.n_nodes());
    header.sets.linear_tools = read_tools(file, path::rest, header.mesh.n_nodes());
    if (header.sets.linear_tools.size() != header.sets.linear.size())
      file.refuse(
          "the points and the tools of /rest are not as many",
          std::to_string(header.sets.linear.size()) + " and " + std::to_string(header.sets.linear_tools.size()));
  }
  const auto directions = read_rows<Points>(file, path::directions);
  for (const auto& d : directions.rowwise()) header.directions.push_back({d[0], d[1], d[2]});
  header.magnitudes_m = read_list<double>(file, path::magnitudes);
  double last = 0;
  for (const double magnitude : header.magnitudes_m) {
    if (!(magnitude > last))
      file.refuse(std::string(path::magnitudes) + " must ascend from 0", std::to_string(magnitude));
    last = magnitude;
  }

  if (const auto hash = mesh_hash(header.mesh); hash != header.mesh_hash)
    throw input_error(
        "the mesh inside the database " + file.path().string() + " is not the mesh on which it was computed",
        "hash " + hash + " instead of " + header.mesh_hash, hdf5::damaged);
  return header;
}

void write_at_rest(hdf5::File& file, const DatabaseHeader& header,
                   const std::function<AtRest(std::int32_t point)>& at_rest) {
  const auto& sets = header.sets;
  if (sets.linear.empty()) return;
  file.reserve(static_cast<std::uint64_t>(at_rest_bytes(header)));
  const hsize_t n = sets.linear.size(), n_output = sets.output.size();
  const auto type = header.float64 ? hdf5::type_of(double{}) : hdf5::type_of(float{});
  file.create_dataset(path::rest_stiffness, hdf5::type_of(double{}).stored, {n, 3, 3}, {n, 3, 3}, "N/m",
                      "dF/dd of a tool at each of /rest/points; row: force, column: displacement");
  file.create_dataset(path::rest_displacement, type.stored, {n, 3, n_output, 3},
                      n_output > 0 ? hdf5::Shape{1, 3, n_output, 3} : hdf5::Shape{}, "1",
                      "displacement of the output nodes per unit of the tool's along x, y and z");
  std::vector<double> stiffness;
  for (hsize_t i = 0; i < n; ++i) {
    auto response = at_rest(static_cast<std::int32_t>(i));
    stiffness.insert(stiffness.end(), response.stiffness_N_per_m.begin(), response.stiffness_N_per_m.end());
    if (header.field_bits > 0)
      for (double& u : response.displacement)
        u = std::ldexp(std::round(std::ldexp(u, header.field_bits)), -header.field_bits);
    if (n_output > 0) file.write_slab(path::rest_displacement, i, 1, response.displacement.data());
  }
  file.write_slab(path::rest_stiffness, 0, n, stiffness.data());
}

hsize_t nodes_per_chunk(const DatabaseHeader& header) {
  // The size of the forces determines the chunks: large enough to compress, and so small that reading one node does not
  // unpack many others.
  constexpr hsize_t chunk_bytes = 64 * 1024;
  const hsize_t per_node = header.directions.size() * header.magnitudes_m.size() * 3 * sizeof(double);
  return std::clamp<hsize_t>(chunk_bytes / per_node, 1, header.sets.active.size());
}

hdf5::Shape chunk_shape(const StoredColumn& column, const DatabaseHeader& header) {
  if (column.count == 0) return {};  // without output nodes
  const hsize_t n_directions = header.directions.size();
  hdf5::Shape chunk{nodes_per_chunk(header), n_directions};
  if (column.of == ColumnOf::output_node) {
    // A chunk has one active node and as many directions as fit into a megabyte.
    constexpr hsize_t chunk_bytes = 1024 * 1024;
    const hsize_t per_direction = column.count * (column.float32 ? sizeof(float) : sizeof(double));
    chunk = {1, std::clamp<hsize_t>(chunk_bytes / per_direction, 1, n_directions)};
  }
  chunk.insert(chunk.end(), column.shape.begin(), column.shape.end());
  return chunk;
}

void create_responses(hdf5::File& file, const DatabaseHeader& header) {
  file.create_group("/responses");
  for (const auto of : {ColumnOf::increment, ColumnOf::ray})
    for (const auto& column : columns_of(header, of)) create_column(file, column, header);
  write_flags(file, "/responses/end_reason", every_end);
  write_flags(file, "/responses/status", every_status);
  bool has_group_of_fields = false;
  for (const auto& column : columns_of(header, ColumnOf::output_node)) {
    if (std::holds_alternative<RayColumn::FieldIndex>(column.member) && !std::exchange(has_group_of_fields, true))
      file.create_group("/responses/fields");
    create_column(file, column, header);
  }
}

}  // namespace phynness::database_layout

double phynness::at_rest_bytes(const DatabaseHeader& header) {
  const std::size_t of_point =
      9 * (sizeof(double) + header.sets.output.size() * (header.float64 ? sizeof(double) : sizeof(float)));
  return static_cast<double>(header.sets.linear.size() * of_point);
}
