#include <bit>

#include "raw_mesh.hpp"
#include "scanner.hpp"
#include "vtk_cells.hpp"

namespace phynness::meshes {
namespace {

/// Numbers of a legacy VTK file: text, or big-endian binary of the type that the file names.
class Numbers {
 public:
  Numbers(Scanner& scanner, bool binary) : _scanner(scanner), _binary(binary) {}

  /// Call once before the values of an array; binary data starts on the next line.
  void begin() {
    if (_binary) _scanner.line();
  }
  double real(const std::string& type, const char* what) {
    if (!_binary) return _scanner.closed_number<double>(what);
    return type == "double" ? _scanner.raw<double>(what, swap) : _scanner.raw<float>(what, swap);
  }
  std::int64_t integer(const std::string& type, const char* what) {
    if (!_binary) return _scanner.closed_number<std::int64_t>(what);
    return type == "vtktypeint64" ? _scanner.raw<std::int64_t>(what, swap) : _scanner.raw<std::int32_t>(what, swap);
  }
  std::size_t count(const char* what, std::size_t binary_bytes) {
    return _scanner.checked_count(_scanner.number<std::int64_t>(what), _binary ? binary_bytes : 2, what);
  }
  std::string integer_type(const char* what) {
    const std::string type(_scanner.word(what));
    if (type != "vtktypeint64" && type != "int" && type != "vtktypeint32")
      _scanner.fail("unsupported integer type", type, "save the mesh as legacy VTK with vtktypeint64");
    return type;
  }

 private:
  static constexpr bool swap = std::endian::native == std::endian::little;
  Scanner& _scanner;
  bool _binary;
};

/// Cells as lists of point numbers, in both layouts: "n a b c ..." (up to version 4.2), and offsets with connectivity
/// (5.1).
std::vector<std::vector<std::int32_t>> read_cells(Scanner& scanner, Numbers& numbers, bool with_offsets,
                                                  std::size_t n_points) {
  std::vector<std::vector<std::int32_t>> cells;
  const auto point = [&](std::int64_t index) {
    if (index < 0 || static_cast<std::size_t>(index) >= n_points)
      scanner.fail("a cell uses a point that is not in the file", std::to_string(index), "export the file again");
    return static_cast<std::int32_t>(index);
  };
  const std::size_t n = numbers.count("cells", 4), size = numbers.count("cell entries", 4);
  if (!with_offsets) {
    numbers.begin();
    std::size_t used = 0;
    for (std::size_t c = 0; c < n; ++c) {
      auto& cell = cells.emplace_back(
          scanner.checked_count(numbers.integer("int", "a cell's number of points"), 2, "points of a cell"));
      for (auto& node : cell) node = point(numbers.integer("int", "a cell's point"));
      used += cell.size() + 1;
    }
    if (used != size)
      scanner.fail("the cells do not hold the declared number of entries",
                   std::to_string(used) + " instead of " + std::to_string(size), "export the file again");
    return cells;
  }
  if (scanner.word("OFFSETS") != "OFFSETS") scanner.fail("expected OFFSETS", "", "export the file again");
  std::string type = numbers.integer_type("the type of the offsets");
  numbers.begin();
  std::vector<std::int64_t> offsets(n);
  for (auto& offset : offsets) offset = numbers.integer(type, "a cell's offset");
  if (scanner.word("CONNECTIVITY") != "CONNECTIVITY")
    scanner.fail("expected CONNECTIVITY", "", "export the file again");
  type = numbers.integer_type("the type of the connectivity");
  numbers.begin();
  std::vector<std::int32_t> connectivity(size);
  for (auto& node : connectivity) node = point(numbers.integer(type, "a cell's point"));
  for (std::size_t c = 0; c + 1 < n; ++c) {
    if (offsets[c] < 0 || offsets[c] > offsets[c + 1] || static_cast<std::size_t>(offsets[c + 1]) > size)
      scanner.fail("the cell offsets do not ascend", std::to_string(offsets[c + 1]), "export the file again");
    cells.emplace_back(connectivity.begin() + offsets[c], connectivity.begin() + offsets[c + 1]);
  }
  return cells;
}

}  // namespace

RawMesh read_vtk(const std::string& bytes, const std::string& source) {
  Scanner scanner(bytes, source);
  const std::string header(scanner.line().substr(0, 256));  // the largest length in the format
  const std::string_view magic = "# vtk DataFile Version ";
  if (!header.starts_with(magic))
    throw input_error(source + ":1: not a legacy VTK file", header.substr(0, 40),
                      "give an XML file the name .vtu (or .vtp), or save the mesh as legacy VTK");
  const bool with_offsets = header.compare(magic.size(), std::string::npos, "5.1") >= 0;
  scanner.line();
  const std::string encoding(scanner.word("ASCII or BINARY"));
  if (encoding != "ASCII" && encoding != "BINARY")
    scanner.fail("expected ASCII or BINARY", encoding.substr(0, 40), "export the file again");
  Numbers numbers(scanner, encoding == "BINARY");
  if (scanner.word("DATASET") != "DATASET") scanner.fail("expected DATASET", "", "export the file again");
  const std::string dataset(scanner.closed_word("the kind of the data set"));
  if (dataset != "UNSTRUCTURED_GRID" && dataset != "POLYDATA")
    scanner.fail("unsupported kind of data set", dataset.substr(0, 40),
                 "save the mesh as UNSTRUCTURED_GRID or POLYDATA");

  RawMesh raw;
  std::vector<std::vector<std::int32_t>> cells;
  std::vector<std::int64_t> types;
  bool points_seen = false, cells_seen = false, types_seen = dataset == "POLYDATA";
  while (!(points_seen && cells_seen && types_seen)) {
    const std::string section(scanner.word("the next section"));
    if (section == "POINTS") {
      const std::size_t n = numbers.count("points", 12);
      const std::string type(scanner.closed_word("the type of the points"));
      if (type != "float" && type != "double")
        scanner.fail("unsupported type of the points", type, "save them as float or double");
      numbers.begin();
      raw.nodes.resize(scanner.checked_count(static_cast<std::int64_t>(n), 6, "points"));
      for (auto& x : raw.nodes)
        for (double& value : x) value = numbers.real(type, "a point's coordinate");
      points_seen = true;
    } else if (section == "CELLS" || section == "POLYGONS") {
      if (!points_seen) scanner.fail(section + " is before POINTS", "", "export the file again");
      cells = read_cells(scanner, numbers, with_offsets, raw.nodes.size());
      cells_seen = true;
    } else if (section == "CELL_TYPES") {
      types.resize(numbers.count("cell types", 4));
      numbers.begin();
      for (auto& type : types) type = numbers.integer("int", "a cell's type");
      types_seen = true;
    } else if (section == "VERTICES" || section == "LINES") {
      read_cells(scanner, numbers, with_offsets, raw.nodes.size());
    } else if (section == "METADATA") {
      while (!scanner.at_end() && !scanner.line().empty()) {
      }
    } else {
      scanner.fail("unsupported section before the cells", section.substr(0, 40),
                   "save the mesh alone, without other data");
    }
  }
  if (dataset == "POLYDATA") types.assign(cells.size(), vtk_polygon);
  if (types.size() != cells.size())
    scanner.fail("the numbers of cells and of cell types differ",
                 std::to_string(cells.size()) + " and " + std::to_string(types.size()), "export the file again");
  const auto fail = [&](const std::string& what, const std::string& value, const std::string& remedy) {
    scanner.fail(what, value, remedy);
  };
  for (std::size_t c = 0; c < cells.size(); ++c) add_vtk_cell(cells[c], c, types[c], raw, fail);
  if (raw.tetrahedra.empty() && raw.triangles.empty())
    throw input_error(source + ": the file holds neither tetrahedra nor polygons",
                      std::to_string(raw.nodes.size()) + " points", "save the mesh with its cells");
  return raw;
}

}  // namespace phynness::meshes
