#include "vtk_xml.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <phynness/formats/error.hpp>

namespace phynness::meshes {
namespace {

// Numbers of one array for ten million tetrahedra, a hundred times the number that can be solved.
constexpr std::uint64_t most_numbers = 40'000'000;
constexpr const char* again = "export the file again";

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

}  // namespace

VtkXml::VtkXml(const std::string& bytes, const std::string& source, const char* kind) : _bytes(bytes), _source(source) {
  parse_document(kind);
}

void VtkXml::fail(pugi::xml_node node, const std::string& what, const std::string& value,
                  const std::string& remedy) const {
  const auto at = std::clamp<std::ptrdiff_t>(node.offset_debug(), 0, static_cast<std::ptrdiff_t>(_bytes.size()));
  const auto line = 1 + std::count(_bytes.begin(), _bytes.begin() + at, '\n');
  throw input_error(_source + ":" + std::to_string(line) + ": " + what, value, remedy);
}

void VtkXml::parse_document(const char* kind) {
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
  if (!file || !parsed || !whole) {
    const auto at =
        static_cast<std::ptrdiff_t>(std::min<std::size_t>(std::max<std::ptrdiff_t>(parsed.offset, 0), _bytes.size()));
    throw input_error(_source + ":" + std::to_string(1 + std::count(_bytes.begin(), _bytes.begin() + at, '\n')) +
                          (file && parsed ? ": the file is truncated: it does not end with </VTKFile>"
                                          : ": the file is not an XML file of VTK"),
                      parsed ? "" : parsed.description(), again);
  }
  _grid = file.child(kind);
  if (!_grid)
    fail(file, std::string("the file holds no ") + kind, file.attribute("type").value(),
         "save the mesh as an unstructured grid (.vtu), or its surface as poly data (.vtp)");
  read_encoding(file);
}

void VtkXml::read_encoding(pugi::xml_node file) {
  const std::string order = file.attribute("byte_order").value(), header = file.attribute("header_type").value(),
                    compressor = file.attribute("compressor").value(),
                    appended = file.child("AppendedData").attribute("encoding").value();
  if (order != "LittleEndian" && order != "BigEndian") fail(file, "unknown byte_order", order, again);
  if (!header.empty() && header != "UInt32" && header != "UInt64") fail(file, "unknown header_type", header, again);
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
    fail(file, "unsupported compressor", compressor, "save the file with zlib or without compression");
  if (_appended && appended != "raw" && appended != "base64")
    fail(file.child("AppendedData"), "unknown encoding of the appended data", appended, again);
  _encoding = {order == "BigEndian", header == "UInt64" ? 8 : 4, !compressor.empty()};
  _appended_base64 = appended == "base64";
}

std::size_t VtkXml::count(pugi::xml_node node, const char* attribute) const {
  const std::string_view text = node.attribute(attribute).value();
  std::uint64_t n = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), n);
  if (code != std::errc{} || end != text.data() + text.size() || n > most_numbers)
    fail(node, std::string(attribute) + " must be a number up to " + std::to_string(most_numbers),
         std::string(text.substr(0, 40)), again);
  return static_cast<std::size_t>(n);
}

pugi::xml_node VtkXml::array(pugi::xml_node parent, const std::string& name) const {
  for (const auto node : parent.children("DataArray"))
    if (name.empty() || name == node.attribute("Name").value()) return node;
  fail(parent, "the array " + (name.empty() ? "of coordinates" : "'" + name + "'") + " is missing", parent.name(),
       again);
}

std::string_view VtkXml::encoded_text(pugi::xml_node array, bool& base64) const {
  const std::string_view format = array.attribute("format").value();
  if (format == "binary") {
    base64 = true;
    return array.text().get();
  }
  if (format != "appended") fail(array, "unknown format of an array", std::string(format.substr(0, 40)), again);
  const std::size_t size = _appended ? _appended->size() : 0;
  const std::string_view text = array.attribute("offset").value();
  std::uint64_t offset = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), offset);
  if (code != std::errc{} || end != text.data() + text.size() || offset >= size)
    fail(array, "the offset of an array is outside of the appended data of " + std::to_string(size) + " bytes",
         std::string(text.substr(0, 40)), again);
  base64 = _appended_base64;
  return _appended->substr(offset);
}

template <class Number>
std::vector<Number> VtkXml::ascii_numbers(pugi::xml_node array, std::size_t size) const {
  std::vector<Number> values;
  std::string_view text = array.text().get();
  while (true) {
    const auto begin = std::find_if_not(text.begin(), text.end(), is_space);
    if (begin == text.end()) break;
    const auto end = std::find_if(begin, text.end(), is_space);
    Number value{};
    const auto [stop, code] = std::from_chars(&*begin, &*begin + (end - begin), value);
    if (stop != &*begin + (end - begin) || (code != std::errc{} && code != std::errc::result_out_of_range))
      fail(array, "expected a number in an array",
           std::string(begin, begin + std::min<std::ptrdiff_t>(40, end - begin)), again);
    // Values that are too large are refused; values that are too small are 0.
    if (code == std::errc::result_out_of_range && std::find(begin, end, '-') == end)
      fail(array, "a number of an array is out of range", std::string(begin, end).substr(0, 40), again);
    values.push_back(value);
    text.remove_prefix(static_cast<std::size_t>(end - text.begin()));
  }
  if (values.size() != size)
    fail(array, "an array holds another number of values than declared",
         std::to_string(values.size()) + " instead of " + std::to_string(size), again);
  return values;
}

template <class Stored, class Number>
std::vector<Number> VtkXml::binary_numbers(pugi::xml_node array, std::size_t size) const {
  std::string bytes;
  bool base64 = false;
  const std::string_view text = encoded_text(array, base64);
  try {
    bytes = decoded_data(text, base64, _encoding, size * sizeof(Stored));
  } catch (const EncodedDataError& error) {
    fail(array, "the data of an array cannot be read", error.what(), again);
  }
  if (bytes.size() != size * sizeof(Stored))
    fail(array, "an array holds another number of bytes than declared",
         std::to_string(bytes.size()) + " instead of " + std::to_string(size * sizeof(Stored)), again);
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

template <class Number>
std::vector<Number> VtkXml::numbers(pugi::xml_node array, std::size_t size) const {
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
  fail(array, "unsupported type of an array", std::string(type.substr(0, 40)), again);
}

template std::vector<double> VtkXml::numbers(pugi::xml_node, std::size_t) const;
template std::vector<std::int64_t> VtkXml::numbers(pugi::xml_node, std::size_t) const;

}  // namespace phynness::meshes
