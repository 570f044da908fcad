// VTK's XML files of unstructured grids (.vtu), as ParaView, PyVista and `phynness show` write them.
// Their arrays are text, base64 or appended, with or without zlib compression.
// https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <phynness/formats/error.hpp>
#include <pugixml.hpp>
#include <stdexcept>

#include "raw_mesh.hpp"
#include "scanner.hpp"
#include "vtk_cells.hpp"

namespace phynness::meshes {
namespace {

// Numbers of one array for ten million tetrahedra, a hundred times the number that can be solved.
constexpr std::uint64_t most_numbers = 40'000'000;
struct DataEncoding {
  bool big_endian = false;
  int header_bytes = 4;  ///< length of each size before the data
  bool zlib = false;
};

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/// The bytes of base64 up to the next tag. Parts that were encoded separately, each with its padding, are one sequence.
std::string from_base64(std::string_view text) {
  std::string bytes;
  unsigned bits = 0;
  int n_bits = 0;
  for (const char c : text.substr(0, text.find('<'))) {
    if (c == ' ' || c == '\t' || c == '\n' || c == '\r') continue;
    const int value = base64_value(c);
    if (value < 0 && c != '=') throw std::runtime_error("it holds characters that are not base64");
    bits = value < 0 ? 0 : bits << 6 | static_cast<unsigned>(value);
    n_bits = value < 0 ? 0 : n_bits + 6;
    if (n_bits < 8) continue;
    n_bits -= 8;
    bytes += static_cast<char>(bits >> n_bits & 255);
  }
  return bytes;
}

/// The data of an array: sizes, then the bytes, with or without zlib compression. Errors have neither file nor place,
/// which the caller adds.
class EncodedData {
 public:
  EncodedData(std::string_view bytes, const DataEncoding& encoding) : _bytes(bytes), _encoding(encoding) {}

  /// @param most_bytes  larger data are refused before any allocation
  std::string decoded(std::uint64_t most_bytes) {
    if (_encoding.zlib) return decompressed(most_bytes);
    return std::string(take(at_most(size(), most_bytes)));
  }

 private:
  static std::uint64_t at_most(std::uint64_t bytes, std::uint64_t most_bytes) {
    if (bytes > most_bytes)
      throw std::runtime_error("it holds " + std::to_string(bytes) + " bytes, more than the " +
                               std::to_string(most_bytes) + " bytes of the numbers that are declared");
    return bytes;
  }

  std::string_view take(std::uint64_t n) {
    if (n > _bytes.size()) throw std::runtime_error("it ends too early");
    const std::string_view part = _bytes.substr(0, n);
    _bytes.remove_prefix(n);
    return part;
  }

  std::uint64_t size() {
    const auto width = static_cast<std::size_t>(_encoding.header_bytes);
    const std::string_view digits = take(width);
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < width; ++k)
      value = value << 8 | static_cast<unsigned char>(digits[_encoding.big_endian ? k : width - 1 - k]);
    return value;
  }

  /// Number of blocks, size of a block, size of the last one, compressed sizes; then the blocks.
  std::string decompressed(std::uint64_t most_bytes) {
    const std::uint64_t n_blocks = size(), block_size = size(), last = size();
    if (n_blocks > _bytes.size() / static_cast<std::size_t>(_encoding.header_bytes))
      throw std::runtime_error("it declares more blocks than it holds");
    at_most(block_size, std::max(most_bytes, std::uint64_t{1} << 20));  // small data use a part of a block
    at_most(last, most_bytes);
    std::vector<std::uint64_t> compressed(n_blocks);
    for (auto& bytes : compressed) bytes = size();
    std::string bytes;
    for (std::uint64_t b = 0; b < n_blocks; ++b) {
      const std::uint64_t before = bytes.size(), add = b + 1 == n_blocks && last > 0 ? last : block_size;
      bytes.resize(at_most(before + add, most_bytes));
      const std::string_view block = take(compressed[b]);
      auto length = static_cast<uLongf>(add);
      const int code = uncompress(reinterpret_cast<Bytef*>(bytes.data() + before), &length,
                                  reinterpret_cast<const Bytef*>(block.data()), static_cast<uLong>(block.size()));
      if (code != Z_OK || length != add) throw std::runtime_error("a compressed block of it is damaged");
    }
    return bytes;
  }

  std::string_view _bytes;
  DataEncoding _encoding;
};

class VtkXml {
 public:
  VtkXml(const std::string& bytes, const std::string& source) : _bytes(bytes), _source(source) { parse_document(); }

  pugi::xml_node grid() const { return _grid; }

  /// A count in an attribute. @throws Error if it is missing or larger than for any useful mesh
  std::size_t count(pugi::xml_node node, const char* attribute) const {
    std::uint64_t n = 0;
    if (!Scanner::is_number(node.attribute(attribute).value(), n) || n > most_numbers)
      fail(node, std::string(attribute) + " must be a number up to " + std::to_string(most_numbers),
           node.attribute(attribute).value());
    return static_cast<std::size_t>(n);
  }

  /// The DataArray with this name, or the only one if `name` is empty. @throws Error
  pugi::xml_node array(pugi::xml_node parent, const std::string& name) const {
    for (const auto node : parent.children("DataArray"))
      if (name.empty() || name == node.attribute("Name").value()) return node;
    fail(parent, "the array " + (name.empty() ? "of coordinates" : "'" + name + "'") + " is missing", parent.name(),
         again);
  }

  /// @param size  number of values of the array
  template <class Number>
  std::vector<Number> numbers(pugi::xml_node array, std::size_t size) const {
    if (size > most_numbers)
      fail(array, "the array is larger than that of any mesh that can be solved", std::to_string(size) + " numbers",
           "give a coarser mesh");
    const std::string_view type = array.attribute("type").value(), format = array.attribute("format").value();
    if (size == 0) return {};
    if (format == "ascii") return ascii_numbers<Number>(array, size);
    if (type == "Float64") return binary_numbers<double, Number>(array, size);
    if (type == "Float32") return binary_numbers<float, Number>(array, size);
    if constexpr (std::is_integral_v<Number>) {
      if (type == "Int64" || type == "UInt64") return binary_numbers<std::int64_t, Number>(array, size);
      if (type == "Int32") return binary_numbers<std::int32_t, Number>(array, size);
      if (type == "UInt32") return binary_numbers<std::uint32_t, Number>(array, size);
      if (type == "Int16") return binary_numbers<std::int16_t, Number>(array, size);
      if (type == "UInt16") return binary_numbers<std::uint16_t, Number>(array, size);
      if (type == "UInt8") return binary_numbers<std::uint8_t, Number>(array, size);
      if (type == "Int8") return binary_numbers<std::int8_t, Number>(array, size);
    }
    fail(array, "unsupported type of an array", type);
  }

  /// @throws Error with the line of the node
  [[noreturn]] void fail(pugi::xml_node node, const std::string& what, std::string_view value = {},
                         const std::string& remedy = again) const {
    throw input_error(place(node.offset_debug()) + what, std::string(value.substr(0, 60)), remedy);
  }

 private:
  /// The beginning of a message: file and line.
  std::string place(std::ptrdiff_t offset) const {
    const auto end = _bytes.begin() + std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(_bytes));
    return _source + ":" + std::to_string(1 + std::count(_bytes.begin(), end, '\n')) + ": ";
  }

  void parse_document() {
    const auto last = _bytes.find_last_not_of(" \t\r\n", std::string::npos, 4);
    constexpr std::string_view end = "</VTKFile>";
    const bool whole = last != std::string::npos && std::string_view(_bytes).substr(0, last + 1).ends_with(end);
    const auto begin = _bytes.find("<AppendedData");
    _text = _bytes.substr(0, begin);
    if (begin != std::string::npos) {
      // Appended data may contain any bytes, so that the whole file is not valid XML.
      const auto tag_end = _bytes.find('>', begin), data = _bytes.find('_', tag_end);
      if (tag_end == std::string::npos || data == std::string::npos)
        throw input_error(_source + ": the file is truncated: its appended data are missing", "", again);
      _text += _bytes.substr(begin, tag_end - begin) + "/>" + std::string(end);
      _appended = std::string_view(_bytes).substr(data + 1, last - data);
    }
    const auto parsed = _document.load_buffer_inplace(_text.data(), _text.size());
    const auto file = _document.child("VTKFile");
    if (!file || !parsed || !whole)
      throw input_error(
          place(parsed.offset) + (file && parsed ? "the file is truncated: it does not end with </VTKFile>"
                                                 : "the file is not an XML file of VTK"),
          parsed ? "" : parsed.description(), again);
    _grid = file.child("UnstructuredGrid");
    if (!_grid)
      fail(file, "the file holds no UnstructuredGrid", file.attribute("type").value(),
           "save the mesh as an unstructured grid (.vtu)");
    read_encoding(file);
  }

  void read_encoding(pugi::xml_node file) {
    const std::string order = file.attribute("byte_order").value(), header = file.attribute("header_type").value(),
                      compressor = file.attribute("compressor").value(),
                      appended = file.child("AppendedData").attribute("encoding").value();
    if (order != "LittleEndian" && order != "BigEndian") fail(file, "unknown byte_order", order);
    if (!header.empty() && header != "UInt32" && header != "UInt64") fail(file, "unknown header_type", header);
    if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
      fail(file, "unsupported compressor", compressor, "save the file with zlib or without compression");
    if (_appended && appended != "raw" && appended != "base64")
      fail(file.child("AppendedData"), "unknown encoding of the appended data", appended);
    _encoding = {order == "BigEndian", header == "UInt64" ? 8 : 4, !compressor.empty()};
    _appended_base64 = appended == "base64";
  }

  std::string_view encoded_text(pugi::xml_node array, bool& base64) const {
    const std::string_view format = array.attribute("format").value();
    if (format == "binary") {
      base64 = true;
      return array.text().get();
    }
    if (format != "appended") fail(array, "unknown format of an array", format);
    const std::size_t size = _appended ? _appended->size() : 0;
    const char* text = array.attribute("offset").value();
    std::uint64_t offset = 0;
    if (!Scanner::is_number(text, offset) || offset >= size)
      fail(array, "the offset of an array is outside of the appended data of " + std::to_string(size) + " bytes", text);
    base64 = _appended_base64;
    return _appended->substr(offset);
  }

  template <class Number>
  std::vector<Number> ascii_numbers(pugi::xml_node array, std::size_t size) const {
    std::vector<Number> values;
    Scanner words(array.text().get(), _source);
    for (auto word = words.word_or_end(); !word.empty(); word = words.word_or_end())
      if (!Scanner::is_number(word, values.emplace_back())) fail(array, "expected a number in an array", word);
    if (values.size() != size)
      fail(array, "an array holds another number of values than declared",
           std::to_string(values.size()) + " instead of " + std::to_string(size));
    return values;
  }

  template <class Stored, class Number>
  std::vector<Number> binary_numbers(pugi::xml_node array, std::size_t size) const {
    std::string bytes;
    bool base64 = false;
    const std::string_view text = encoded_text(array, base64);
    try {
      const std::string decoded = base64 ? from_base64(text) : std::string();
      bytes = EncodedData(base64 ? decoded : text, _encoding).decoded(size * sizeof(Stored));
    } catch (const std::runtime_error& error) {
      fail(array, "the data of an array cannot be read", error.what());
    }
    if (bytes.size() != size * sizeof(Stored))
      fail(array, "an array holds another number of bytes than declared",
           std::to_string(bytes.size()) + " instead of " + std::to_string(size * sizeof(Stored)));
    const bool swap = _encoding.big_endian != (std::endian::native == std::endian::big);
    std::vector<Number> values(size);
    for (std::size_t i = 0; i < size; ++i) {
      char* first = bytes.data() + i * sizeof(Stored);
      if (swap) std::reverse(first, first + sizeof(Stored));
      Stored value;
      std::memcpy(&value, first, sizeof value);
      values[i] = static_cast<Number>(value);  // NOLINT(bugprone-signed-char-misuse): Int8 holds numbers
    }
    return values;
  }

  const std::string& _bytes;
  std::string _source, _text;  ///< the text without appended data; the document refers to it
  pugi::xml_document _document;
  pugi::xml_node _grid;
  DataEncoding _encoding;
  std::optional<std::string_view> _appended;
  bool _appended_base64 = false;
};

std::size_t append_points(const VtkXml& file, pugi::xml_node piece, RawMesh& raw) {
  const std::size_t n = file.count(piece, "NumberOfPoints");
  if (n == 0) return 0;
  const auto array = file.array(piece.child("Points"), "");
  if (array.attribute("NumberOfComponents").as_int(3) != 3)
    file.fail(array, "the points do not have three coordinates", array.attribute("NumberOfComponents").value());
  const auto x = file.numbers<double>(array, 3 * n);
  for (std::size_t i = 0; i < n; ++i) raw.nodes.push_back({x[3 * i], x[3 * i + 1], x[3 * i + 2]});
  return n;
}

/// The numbers of the first array of region_arrays that the piece holds; empty: none, or none of integers.
std::vector<std::int64_t> regions_of(const VtkXml& file, pugi::xml_node piece, std::size_t n_cells, RawMesh& raw) {
  for (const char* name : region_arrays) {
    const auto array = piece.child("CellData").find_child_by_attribute("DataArray", "Name", name);
    if (!array) continue;
    const std::string type = array.attribute("type").value();
    const int components = array.attribute("NumberOfComponents").as_int(1);
    if (type.find("Int") != type.npos && components <= 1) return file.numbers<std::int64_t>(array, n_cells);
    raw.notes.push_back(not_groups(name, type + " with " + std::to_string(components) + " component(s)"));
  }
  return {};
}

void append_cells(const VtkXml& file, pugi::xml_node piece, std::size_t n_points, RawMesh& raw) {
  const auto cells = piece.child("Cells");
  const std::size_t n_cells = file.count(piece, "NumberOfCells");
  if (n_cells == 0) return;
  const auto ends = file.numbers<std::int64_t>(file.array(cells, "offsets"), n_cells);
  const auto array = file.array(cells, "connectivity");
  const auto points =
      file.numbers<std::int64_t>(array, static_cast<std::size_t>(std::max<std::int64_t>(ends.back(), 0)));
  const auto types = file.numbers<std::int64_t>(file.array(cells, "types"), n_cells);
  add_vtk_cells(ends, points, n_points, static_cast<std::int32_t>(raw.nodes.size() - n_points), types,
                regions_of(file, piece, n_cells, raw), raw, [&](const auto&... text) { file.fail(array, text...); });
}

}  // namespace

RawMesh read_vtu(const std::string& bytes, const std::string& source) {
  const VtkXml file(bytes, source);
  RawMesh raw;
  std::size_t n_pieces = 0;
  for (const auto piece : file.grid().children("Piece")) {
    const std::size_t n = append_points(file, piece, raw);
    constexpr std::size_t most_points = 40'000'000;
    if (raw.nodes.size() > most_points)
      file.fail(piece, "the file holds more points than can be solved", std::to_string(raw.nodes.size()),
                "give a coarser mesh");
    append_cells(file, piece, n, raw);
    if (n > 0) ++n_pieces;
  }
  if (n_pieces > 1) raw.notes.push_back("the file holds " + std::to_string(n_pieces) + " pieces");
  return raw;
}

}  // namespace phynness::meshes
