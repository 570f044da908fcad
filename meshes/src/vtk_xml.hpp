// The arrays of VTK's XML files (.vtu, .vtp): ASCII, base64 or appended, compressed by zlib or not.
// https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
#pragma once

#include <cstdint>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "encoded_data.hpp"

namespace phynness::meshes {

class VtkXml {
 public:
  /// @throws Error if the text is no XML file of VTK of this kind, "UnstructuredGrid" or "PolyData"
  VtkXml(const std::string& bytes, const std::string& source, const char* kind);

  /// UnstructuredGrid or PolyData.
  pugi::xml_node grid() const { return _grid; }
  /// An attribute that counts something. @throws Error if it is missing or larger than any mesh needs
  std::size_t count(pugi::xml_node node, const char* attribute) const;
  /// The DataArray of a name, or the only one if `name` is empty. @throws Error
  pugi::xml_node array(pugi::xml_node parent, const std::string& name) const;
  /// @param size  how many numbers the array must hold
  template <class Number>
  std::vector<Number> numbers(pugi::xml_node array, std::size_t size) const;

  /// @throws Error that names the line of the node
  [[noreturn]] void fail(pugi::xml_node node, const std::string& what, const std::string& value,
                         const std::string& remedy) const;

 private:
  void parse_document(const char* kind);
  void read_encoding(pugi::xml_node file);
  std::string_view encoded_text(pugi::xml_node array, bool& base64) const;
  template <class Number>
  std::vector<Number> ascii_numbers(pugi::xml_node array, std::size_t size) const;
  template <class Stored, class Number>
  std::vector<Number> binary_numbers(pugi::xml_node array, std::size_t size) const;

  const std::string& _bytes;
  std::string _source, _text;  ///< the text without appended data; the document points into it
  pugi::xml_document _document;
  pugi::xml_node _grid;
  DataEncoding _encoding;
  std::optional<std::string_view> _appended;
  bool _appended_base64 = false;
};

}  // namespace phynness::meshes
