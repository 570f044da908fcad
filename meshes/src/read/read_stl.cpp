#include <bit>

#include "raw_mesh.hpp"
#include "scanner.hpp"

namespace phynness::meshes {
namespace {

constexpr std::size_t binary_header = 84, binary_facet = 50;

/// A corner of the last triangle, which STL repeats in every triangle: read_mesh_file() merges them.
template <class Value>
void add_corner(RawMesh& raw, int k, const Value& value) {
  raw.triangles.back()[k] = static_cast<std::int32_t>(raw.nodes.size());
  for (double& x : raw.nodes.emplace_back()) x = value();
}

void read_binary(Scanner& scanner, RawMesh& raw) {
  const bool swap = std::endian::native == std::endian::big;
  scanner.skip(80, "the header");
  const auto declared = scanner.raw<std::uint32_t>("the number of triangles", swap);
  // Programs that write while they compute leave the number open.
  const bool is_open = (declared == 0 || declared == ~0u) && scanner.remaining() >= binary_facet;
  const std::size_t n =
      is_open ? scanner.remaining() / binary_facet : scanner.checked_count(declared, binary_facet, "triangles");
  for (std::size_t t = 0; t < n; ++t) {
    scanner.skip(12, "a triangle's normal");
    raw.triangles.emplace_back();
    for (int k = 0; k < 3; ++k) add_corner(raw, k, [&] { return scanner.raw<float>("a triangle's corner", swap); });
    scanner.skip(2, "a triangle's attribute");
  }
  if (scanner.remaining() > 0)
    raw.notes.push_back("ignored " + std::to_string(scanner.remaining()) + " bytes after the last triangle");
}

void expect(Scanner& scanner, const char* word) {
  if (const std::string_view found = scanner.word(word); upper(found) != word)
    scanner.fail(std::string("expected '") + word + "'", found);
}

/// In any case of letters; what ends a solid begins with "end".
void read_text(Scanner& scanner, RawMesh& raw) {
  scanner.word_or_end();
  scanner.line();
  while (true) {
    const std::string_view word = scanner.word("'endsolid'");
    if (upper(word).starts_with("END")) {
      scanner.line();
      if (scanner.word_or_end().empty()) return;
      scanner.line();  // the name of a further solid of the file
      continue;
    }
    if (upper(word) != "FACET") scanner.fail("expected 'facet' or 'endsolid'", word);
    expect(scanner, "NORMAL");
    for (int k = 0; k < 3; ++k) scanner.word("a triangle's normal");
    expect(scanner, "OUTER");
    expect(scanner, "LOOP");
    raw.triangles.emplace_back();
    for (int k = 0; k < 3; ++k) {
      expect(scanner, "VERTEX");
      add_corner(raw, k, [&] { return scanner.number<double>("a triangle's corner"); });
    }
    expect(scanner, "ENDLOOP");
    expect(scanner, "ENDFACET");
  }
}

}  // namespace

RawMesh read_stl(const std::string& bytes, const std::string& source) {
  Scanner scanner(bytes, source);
  RawMesh raw;
  // Binary headers may begin with "solid" too, so that the next line decides: 'facet' or an end in a text file. Without
  // a byte 0 it is text with something else there.
  Scanner probe = scanner;
  bool text = upper(probe.word_or_end()) == "SOLID";
  if (text) {
    probe.line();
    const std::string next = upper(probe.word_or_end());
    text = next == "FACET" || next.starts_with("END") || bytes.find('\0') == bytes.npos;
  }
  if (text)
    read_text(scanner, raw);
  else
    read_binary(scanner, raw);
  return raw;
}

}  // namespace phynness::meshes
