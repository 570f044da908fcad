// VTK's legacy files: unstructured grids and poly data, as text or binary.
#include <algorithm>
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
    for (std::string section = next_section(); !section.empty(); section = next_section()) {
      if (section == "POINTS") {
        read_points();
      } else if (section == "CELL_TYPES") {
        _types.resize(count("cell types", 4));
        begin();
        for (auto& type : _types) type = integer("int", "a cell's type");
      } else {
        read_cells();
        if (_poly_data)
          _types.resize(_ends.size(), section == "POLYGONS"          ? vtk_polygon
                                      : section == "TRIANGLE_STRIPS" ? vtk_strip
                                      : section == "LINES"           ? vtk_poly_line
                                                                     : vtk_poly_vertex);
      }
    }
    if (_raw.nodes.empty() || (_types.empty() && !_poly_data))
      _scanner.truncated(_raw.nodes.empty() ? "POINTS" : "CELLS and CELL_TYPES");
    if (_types.size() != _ends.size())
      _scanner.fail("the numbers of cells and of cell types differ",
                    std::to_string(_ends.size()) + " and " + std::to_string(_types.size()));
    if (!_regions.empty() && _regions.size() != _types.size())
      _scanner.fail("the array '" + _region_array + "' has another number of values than there are cells",
                    std::to_string(_regions.size()) + " and " + std::to_string(_types.size()));
    add_vtk_cells(_ends, _points, _raw.nodes.size(), 0, _types, _regions, _raw,
                  [this](const auto&... text) { _scanner.fail(text...); });
    return std::move(_raw);
  }

 private:
  /// Moves behind the name of the next section of the mesh; empty at the end of the file. The lines of fields, metadata
  /// and attributes before it are skipped.
  std::string next_section() {
    double number = 0;
    Scanner next = _scanner;
    if (const auto word = next.word_or_end(); !_binary && !_raw.nodes.empty() && Scanner::is_number(word, number))
      _scanner.fail("a section has more values than it declares", word);
    constexpr std::string_view names = " POINTS CELLS CELL_TYPES POLYGONS LINES VERTICES TRIANGLE_STRIPS ";
    while (!_scanner.at_end()) {
      next = _scanner;
      Scanner words(_scanner.line(), "");
      const std::string original(words.word_or_end()), name = upper(original);
      if (name == "CELL_DATA" || name == "POINT_DATA") _of_cells = name == "CELL_DATA";
      if (_of_cells) read_regions(original, words);
      if (names.find(" " + name + " ") == names.npos || !Scanner::is_number(words.word_or_end(), number)) continue;
      // An array of a field may have such a name, but has more words.
      const bool alone = words.word_or_end().empty();
      if (alone != (name == "CELL_TYPES") || !words.word_or_end().empty()) continue;
      _scanner = next;
      _scanner.word_or_end();
      return name;
    }
    return "";
  }

  /// Reads the values if a line begins an array of region_arrays: "SCALARS NAME TYPE [1]" and "LOOKUP_TABLE default",
  /// or "NAME 1 N TYPE" in a field. @param words  behind the first one
  void read_regions(const std::string& first, Scanner words) {
    const bool scalars = upper(first) == "SCALARS";
    const std::string name = scalars ? std::string(words.word_or_end()) : first;
    if (!_regions.empty() ||
        std::find(std::begin(region_arrays), std::end(region_arrays), name) == std::end(region_arrays))
      return;
    std::int64_t components = 1, n = std::ssize(_types);
    std::string type(scalars ? words.word_or_end() : "");
    if (scalars && !Scanner::is_number(words.word_or_end(), components)) components = 1;
    if (!scalars &&
        (!Scanner::is_number(words.word_or_end(), components) || !Scanner::is_number(words.word_or_end(), n)))
      return;
    if (!scalars) type = words.word_or_end();
    if (components != 1 || (type != "int" && type != "long" && type != "vtktypeint64" && type != "vtktypeint32"))
      return _raw.notes.push_back(not_groups(name, type + " with " + std::to_string(components) + " component(s)"));
    if (scalars) _scanner.line();  // the name of a table of colours
    _region_array = name;
    _regions.resize(_scanner.checked_count(n, _binary ? 4 : 2, "values of an array"));
    for (auto& value : _regions) value = integer(type, "a value of an array");
    if (!_binary) _scanner.line();
  }

  void read_header() {
    const std::string header(_scanner.line().substr(0, 256));  // the largest length in the format
    const std::string_view magic = "# vtk DataFile Version ";
    if (!header.starts_with(magic))
      throw input_error(_scanner.source() + ":1: not a legacy VTK file", header.substr(0, 40),
                        "save the mesh as legacy VTK or as .vtu");
    _with_offsets = header.compare(magic.size(), std::string::npos, "5.1") >= 0;
    _scanner.line();
    const std::string encoding = upper(_scanner.word("ASCII or BINARY"));
    if (encoding != "ASCII" && encoding != "BINARY") _scanner.fail("expected ASCII or BINARY", encoding);
    _binary = encoding == "BINARY";
    expect("DATASET");
    const std::string dataset = upper(_scanner.word("the kind of the data set"));
    if (dataset != "UNSTRUCTURED_GRID" && dataset != "POLYDATA")
      _scanner.fail("unsupported kind of data set", dataset, "save the mesh as UNSTRUCTURED_GRID or POLYDATA");
    _poly_data = dataset == "POLYDATA";
  }

  void expect(const char* name) {
    if (upper(_scanner.word(name)) != name) _scanner.fail(std::string("expected ") + name);
  }

  /// To be called before the values of an array: binary data start on the next line.
  void begin() {
    if (_binary) _scanner.line();
  }
  std::int64_t integer(const std::string& type, const char* what) {
    if (!_binary) return _scanner.number<std::int64_t>(what);
    return type == "vtktypeint64" || type == "long" ? _scanner.raw<std::int64_t>(what, swap)
                                                    : _scanner.raw<std::int32_t>(what, swap);
  }
  std::size_t count(const char* what, std::size_t binary_bytes) {
    return _scanner.checked_count(_scanner.number<std::int64_t>(what), _binary ? binary_bytes : 2, what);
  }

  void read_points() {
    const std::size_t n = count("points", 12);
    const std::string type = upper(_scanner.word("the type of the points"));
    if (type != "FLOAT" && type != "DOUBLE")
      _scanner.fail("unsupported type of the points", type, "save them as float or double");
    begin();
    _raw.nodes.resize(_scanner.checked_count(static_cast<std::int64_t>(n), 6, "points"));
    constexpr const char* what = "a point's coordinate";
    for (auto& x : _raw.nodes)
      for (double& value : x)
        value = !_binary           ? _scanner.number<double>(what)
                : type == "DOUBLE" ? _scanner.raw<double>(what, swap)
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
  void read_cells() {
    const std::size_t n = count("cells", 4), size = count("cell entries", 4), first = _points.size();
    if (_with_offsets) {
      const auto ends = array("OFFSETS", n), points = array("CONNECTIVITY", size);
      if (n > 0 && ends[0] != 0) _scanner.fail("the first cell offset is not 0", std::to_string(ends[0]));
      for (std::size_t c = 1; c < n; ++c) {
        if (ends[c] < 0 || static_cast<std::uint64_t>(ends[c]) > size)
          _scanner.fail("a cell offset is not in the file", std::to_string(ends[c]));
        _ends.push_back(static_cast<std::int64_t>(first) + ends[c]);
      }
      _points.insert(_points.end(), points.begin(), points.end());
      return;
    }
    begin();
    for (std::size_t c = 0; c < n; ++c) {
      const std::size_t corners =
          _scanner.checked_count(integer("int", "a cell's number of points"), 2, "points of a cell");
      for (std::size_t k = 0; k < corners; ++k) _points.push_back(integer("int", "a cell's point"));
      _ends.push_back(static_cast<std::int64_t>(_points.size()));
    }
    if (_points.size() - first + n != size)
      _scanner.fail("the cells do not hold the declared number of entries",
                    std::to_string(_points.size() - first + n) + " instead of " + std::to_string(size));
  }

  static constexpr bool swap = std::endian::native == std::endian::little;  // the format is big-endian
  Scanner& _scanner;
  bool _binary = false, _with_offsets = false, _poly_data = false;
  RawMesh _raw;
  bool _of_cells = false;  ///< attributes at the present place are of cells
  std::string _region_array;
  std::vector<std::int64_t> _ends, _points, _types, _regions;
};

}  // namespace

RawMesh read_vtk(const std::string& bytes, const std::string& source) {
  Scanner scanner(bytes, source);
  return VtkFile(scanner).read();
}

}  // namespace phynness::meshes
