// VTK's legacy files: unstructured grids and poly data, as text or binary.
#include <bit>

#include "raw_mesh.hpp"
#include "scanner.hpp"
#include "vtk_cells.hpp"

namespace phynness::meshes {
namespace {

class VtkFile {
 public:
  explicit VtkFile(Scanner& scanner) : _scanner(scanner) { read_header(); }

  RawMesh read() {
    bool points_seen = false, cells_seen = false, types_seen = _poly_data;
    while (!(points_seen && cells_seen && types_seen)) {
      const std::string section(_scanner.word("the next section"));
      if (section == "POINTS") {
        read_points();
        points_seen = true;
      } else if (section == "CELLS" || section == "POLYGONS") {
        if (!points_seen) _scanner.fail(section + " is before POINTS");
        read_cells(_ends, _points);
        cells_seen = true;
      } else if (section == "CELL_TYPES") {
        _types.resize(count("cell types", 4));
        begin();
        for (auto& type : _types) type = integer("int", "a cell's type");
        types_seen = true;
      } else if (section == "VERTICES" || section == "LINES") {
        std::vector<std::int64_t> ends, points;
        read_cells(ends, points);
      } else if (section == "METADATA") {
        while (!_scanner.at_end() && !_scanner.line().empty()) {
        }
      } else {
        _scanner.fail("unsupported section before the cells", section, "save the mesh alone, without other data");
      }
    }
    if (!_poly_data && _types.size() != _ends.size())
      _scanner.fail("the numbers of cells and of cell types differ",
                    std::to_string(_ends.size()) + " and " + std::to_string(_types.size()));
    add_vtk_cells(_ends, _points, _raw.nodes.size(), 0, _types, _raw,
                  [this](const auto&... text) { _scanner.fail(text...); });
    return std::move(_raw);
  }

 private:
  void read_header() {
    const std::string header(_scanner.line().substr(0, 256));  // the largest length in the format
    const std::string_view magic = "# vtk DataFile Version ";
    if (!header.starts_with(magic))
      throw input_error(_scanner.source() + ":1: not a legacy VTK file", header.substr(0, 40),
                        "give an XML file the name .vtu, or save the mesh as legacy VTK");
    _with_offsets = header.compare(magic.size(), std::string::npos, "5.1") >= 0;
    _scanner.line();
    const std::string encoding(_scanner.word("ASCII or BINARY"));
    if (encoding != "ASCII" && encoding != "BINARY") _scanner.fail("expected ASCII or BINARY", encoding);
    _binary = encoding == "BINARY";
    expect("DATASET");
    const std::string dataset(_scanner.closed_word("the kind of the data set"));
    if (dataset != "UNSTRUCTURED_GRID" && dataset != "POLYDATA")
      _scanner.fail("unsupported kind of data set", dataset, "save the mesh as UNSTRUCTURED_GRID or POLYDATA");
    _poly_data = dataset == "POLYDATA";
  }

  void expect(const char* name) {
    if (_scanner.word(name) != name) _scanner.fail(std::string("expected ") + name);
  }

  /// To be called before the values of an array: binary data start on the next line.
  void begin() {
    if (_binary) _scanner.line();
  }
  std::int64_t integer(const std::string& type, const char* what) {
    if (!_binary) return _scanner.closed_number<std::int64_t>(what);
    return type == "vtktypeint64" ? _scanner.raw<std::int64_t>(what, swap) : _scanner.raw<std::int32_t>(what, swap);
  }
  std::size_t count(const char* what, std::size_t binary_bytes) {
    return _scanner.checked_count(_scanner.number<std::int64_t>(what), _binary ? binary_bytes : 2, what);
  }

  void read_points() {
    const std::size_t n = count("points", 12);
    const std::string type(_scanner.closed_word("the type of the points"));
    if (type != "float" && type != "double")
      _scanner.fail("unsupported type of the points", type, "save them as float or double");
    begin();
    _raw.nodes.resize(_scanner.checked_count(static_cast<std::int64_t>(n), 6, "points"));
    constexpr const char* what = "a point's coordinate";
    for (auto& x : _raw.nodes)
      for (double& value : x)
        value = !_binary           ? _scanner.closed_number<double>(what)
                : type == "double" ? _scanner.raw<double>(what, swap)
                                   : _scanner.raw<float>(what, swap);
  }

  /// An array of version 5.1: its name, its type and its values.
  std::vector<std::int64_t> array(const char* name, std::size_t n) {
    expect(name);
    const std::string type(_scanner.word("the type of an array"));
    if (type != "vtktypeint64" && type != "int" && type != "vtktypeint32")
      _scanner.fail("unsupported integer type", type, "save the mesh as legacy VTK with vtktypeint64");
    begin();
    std::vector<std::int64_t> values(n);
    for (auto& value : values) value = integer(type, "a number of an array");
    return values;
  }

  /// In both layouts: "n a b c ..." (up to version 4.2), and offsets with connectivity (5.1).
  void read_cells(std::vector<std::int64_t>& ends, std::vector<std::int64_t>& points) {
    const std::size_t n = count("cells", 4), size = count("cell entries", 4);
    if (_with_offsets) {
      ends = array("OFFSETS", n);
      points = array("CONNECTIVITY", size);
      if (n > 0 && ends[0] != 0) _scanner.fail("the first cell offset is not 0", std::to_string(ends[0]));
      if (n > 0) ends.erase(ends.begin());
      return;
    }
    begin();
    for (std::size_t c = 0; c < n; ++c) {
      const std::size_t corners =
          _scanner.checked_count(integer("int", "a cell's number of points"), 2, "points of a cell");
      for (std::size_t k = 0; k < corners; ++k) points.push_back(integer("int", "a cell's point"));
      ends.push_back(static_cast<std::int64_t>(points.size()));
    }
    if (points.size() + n != size)
      _scanner.fail("the cells do not hold the declared number of entries",
                    std::to_string(points.size() + n) + " instead of " + std::to_string(size));
  }

  static constexpr bool swap = std::endian::native == std::endian::little;  // the format is big-endian
  Scanner& _scanner;
  bool _binary = false, _with_offsets = false, _poly_data = false;
  RawMesh _raw;
  std::vector<std::int64_t> _ends, _points, _types;
};

}  // namespace

RawMesh read_vtk(const std::string& bytes, const std::string& source) {
  Scanner scanner(bytes, source);
  return VtkFile(scanner).read();
}

}  // namespace phynness::meshes
