// Stanford's polygon files: text and binary with both byte orders. Only vertices and faces are read.
#include <bit>

#include "raw_mesh.hpp"
#include "scanner.hpp"

namespace phynness::meshes {
namespace {

struct Property {
  std::string name, type;
  std::string count_type;  ///< of a list; otherwise empty
};

struct Element {
  std::string name;
  std::int64_t count;
  std::vector<Property> properties;
};

std::size_t bytes_of_type(const std::string& type) {
  for (const auto& [names, bytes] :
       {std::pair("char uchar int8 uint8 ", 1), std::pair("short ushort int16 uint16 ", 2),
        std::pair("int uint int32 uint32 float float32 ", 4), std::pair("double float64 ", 8)})
    if (std::string(" ").append(names).find(" " + type + " ") != std::string::npos)
      return static_cast<std::size_t>(bytes);
  return 0;
}

bool is_real(const std::string& type) { return type.starts_with("float") || type == "double"; }

class PlyFile {
 public:
  explicit PlyFile(Scanner& scanner) : _scanner(scanner) { read_header(); }

  RawMesh read() {
    for (const Element& element : _elements) {
      std::size_t least = 0;  // bytes of an item
      for (const auto& p : element.properties)
        least += _text ? 2 : bytes_of_type(p.count_type.empty() ? p.type : p.count_type);
      if (least == 0 && element.count > 0) _scanner.fail("an element has no properties", element.name);
      if (element.name == "tristrips" && element.count > 0)
        _scanner.fail("the triangles are written as strips", element.name, "save them as faces");
      const std::size_t n =
          _scanner.checked_count(element.count, std::max<std::size_t>(least, 1), "items of an element");
      for (std::size_t i = 0; i < n; ++i)
        element.name == "vertex" ? read_vertex(element) : read_other(element, element.name == "face");
      _vertices_known |= element.name == "vertex";
    }
    return std::move(_raw);
  }

 private:
  void read_header() {
    if (_scanner.word_or_end() != "ply") throw input_error(_scanner.source() + ":1: not a .ply file", "", again);
    _scanner.line();
    bool format_known = false;
    while (true) {
      if (_scanner.at_end()) _scanner.truncated("'end_header'");
      const std::string line(_scanner.line());
      Scanner words(line, _scanner.source());
      const auto word = words.word_or_end();
      if (word == "end_header") break;
      if (word == "format") {
        read_format(std::string(words.word_or_end()));
        format_known = true;
      } else if (word == "element") {
        const std::string name(words.word_or_end()), count(words.word_or_end());
        _elements.push_back({name, _scanner.parse<std::int64_t>(count, "the number of items of an element"), {}});
      } else if (word == "property") {
        if (_elements.empty()) _scanner.fail("a property is before the first element", line);
        _elements.back().properties.push_back(property(words, line));
      } else if (!word.empty() && word != "comment" && word != "obj_info") {
        _scanner.fail("an unknown word in the header", word);
      }
    }
    if (!format_known) _scanner.fail("the header names no format");
  }

  void read_format(const std::string& format) {
    _text = format == "ascii";
    _swap = (format == "binary_big_endian") == (std::endian::native == std::endian::little);
    if (!_text && format != "binary_big_endian" && format != "binary_little_endian")
      _scanner.fail("unknown format", format, "save the file as ascii or binary_little_endian");
  }

  Property property(Scanner& words, const std::string& line) const {
    Property p;
    p.type = words.word_or_end();
    if (p.type == "list") {
      p.count_type = words.word_or_end();
      p.type = words.word_or_end();
    }
    p.name = words.word_or_end();
    if (p.name.empty() || bytes_of_type(p.type) == 0 ||
        (!p.count_type.empty() && (bytes_of_type(p.count_type) == 0 || is_real(p.count_type))))
      _scanner.fail("a property of an unknown type", line);
    return p;
  }

  double value(const std::string& type) {
    constexpr const char* what = "a value";
    if (_text) return _scanner.number<double>(what);
    switch (bytes_of_type(type)) {
      case 1:
        return type[0] == 'u' ? _scanner.raw<std::uint8_t>(what, _swap) : _scanner.raw<std::int8_t>(what, _swap);
      case 2:
        return type[0] == 'u' ? _scanner.raw<std::uint16_t>(what, _swap) : _scanner.raw<std::int16_t>(what, _swap);
      case 4:
        if (is_real(type)) return _scanner.raw<float>(what, _swap);
        return type[0] == 'u' ? _scanner.raw<std::uint32_t>(what, _swap) : _scanner.raw<std::int32_t>(what, _swap);
      default:
        return _scanner.raw<double>(what, _swap);
    }
  }

  /// A value that is a count or a number; -1 if it is neither.
  std::int64_t integer(const std::string& type) {
    const double x = value(type);
    const auto i = x >= 0 && x < 4e9 ? static_cast<std::int64_t>(x) : -1;
    return static_cast<double>(i) == x ? i : -1;
  }

  std::size_t length(const Property& p) {
    const std::int64_t n = integer(p.count_type);
    return _scanner.checked_count(n, _text ? 2 : bytes_of_type(p.type), "entries of a list");
  }

  void read_vertex(const Element& element) {
    auto& x = _raw.nodes.emplace_back();
    int found = 0;
    for (const auto& p : element.properties) {
      if (!p.count_type.empty()) {
        skip_list(p);
        continue;
      }
      const double number = value(p.type);
      for (int k = 0; k < 3; ++k)
        if (p.name == std::string(1, static_cast<char>('x' + k))) x[k] = number, found |= 1 << k;
    }
    if (found != 7) _scanner.fail("the vertices do not have x, y and z");
  }

  void skip_list(const Property& p) {
    const std::size_t n = length(p);
    for (std::size_t i = 0; i < n; ++i) value(p.type);
  }

  void read_other(const Element& element, bool face) {
    for (const auto& p : element.properties) {
      if (p.count_type.empty())
        value(p.type);
      else if (face && (p.name == "vertex_indices" || p.name == "vertex_index"))
        read_face(p);
      else
        skip_list(p);
    }
  }

  void read_face(const Property& p) {
    if (!_vertices_known) _scanner.fail("faces are before the vertices");
    const std::size_t n = length(p);
    if (n < 3) _scanner.fail("a face has fewer than three vertices", std::to_string(n));
    std::vector<std::int32_t> corners(n);
    for (auto& corner : corners) {
      const std::int64_t i = integer(p.type);
      if (i < 0 || static_cast<std::size_t>(i) >= _raw.nodes.size())
        _scanner.fail("a face uses a vertex that is not in the file", std::to_string(i));
      corner = static_cast<std::int32_t>(i);
    }
    _raw.add_polygon(corners);
  }

  Scanner& _scanner;
  std::vector<Element> _elements;
  RawMesh _raw;
  bool _text = false, _swap = false, _vertices_known = false;
};

}  // namespace

RawMesh read_ply(const std::string& bytes, const std::string& source) {
  Scanner scanner(bytes, source);
  return PlyFile(scanner).read();
}

}  // namespace phynness::meshes
