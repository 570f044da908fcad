#include <bit>
#include <unordered_map>

#include "raw_mesh.hpp"
#include "scanner.hpp"

namespace phynness::meshes {
namespace {

constexpr std::size_t binary_header = 84, binary_facet = 50;

/// STL repeats a vertex in every triangle. Equal coordinates become one node, numbered by first appearance.
class Welder {
 public:
  explicit Welder(RawMesh& raw) : _raw(raw) {}

  std::int32_t node(const std::array<double, 3>& x) {
    Key key;
    for (int k = 0; k < 3; ++k) key[k] = std::bit_cast<std::uint64_t>(x[k] == 0 ? 0.0 : x[k]);  // -0 is 0
    const auto [found, is_new] = _nodes.emplace(key, static_cast<std::int32_t>(_raw.nodes.size()));
    if (is_new) _raw.nodes.push_back(x);
    return found->second;
  }

 private:
  using Key = std::array<std::uint64_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& key) const {
      return std::hash<std::string_view>{}({reinterpret_cast<const char*>(key.data()), sizeof key});
    }
  };
  RawMesh& _raw;
  std::unordered_map<Key, std::int32_t, Hash> _nodes;
};

void read_binary(Scanner& scanner, RawMesh& raw) {
  Welder welder(raw);
  const bool swap = std::endian::native == std::endian::big;
  scanner.skip(80, "the header");
  const auto declared = scanner.raw<std::uint32_t>("the number of triangles", swap);
  const std::size_t n = scanner.checked_count(declared, binary_facet, "triangles");
  for (std::size_t t = 0; t < n; ++t) {
    scanner.skip(12, "a triangle's normal");
    Triangle triangle;
    for (auto& corner : triangle) {
      std::array<double, 3> x;
      for (double& value : x) value = scanner.raw<float>("a triangle's corner", swap);
      corner = welder.node(x);
    }
    scanner.skip(2, "a triangle's attribute");
    raw.triangles.push_back(triangle);
  }
  if (scanner.remaining() > 0)
    raw.notes.push_back("ignored " + std::to_string(scanner.remaining()) + " bytes after the last triangle");
}

void expect(Scanner& scanner, const char* word) {
  if (const std::string_view found = scanner.word(word); found != word)
    scanner.fail(std::string("expected '") + word + "'", found);
}

void read_text(Scanner& scanner, RawMesh& raw) {
  Welder welder(raw);
  scanner.line();
  while (true) {
    const std::string_view word = scanner.word("'endsolid'");
    if (word == "endsolid") {
      scanner.line();
      if (scanner.word_or_end().empty()) return;
      scanner.line();  // the name of a further solid of the file
      continue;
    }
    if (word != "facet") scanner.fail("expected 'facet' or 'endsolid'", word);
    expect(scanner, "normal");
    for (int k = 0; k < 3; ++k) scanner.word("a triangle's normal");
    expect(scanner, "outer");
    expect(scanner, "loop");
    Triangle triangle;
    for (auto& corner : triangle) {
      expect(scanner, "vertex");
      std::array<double, 3> x;
      for (double& value : x) value = scanner.number<double>("a triangle's corner");
      corner = welder.node(x);
    }
    expect(scanner, "endloop");
    expect(scanner, "endfacet");
    raw.triangles.push_back(triangle);
  }
}

}  // namespace

RawMesh read_stl(const std::string& bytes, const std::string& source) {
  Scanner scanner(bytes, source);
  RawMesh raw;
  // Binary headers may begin with "solid" too, so that the second word decides: 'facet' or 'endsolid' in a text file.
  Scanner probe = scanner;
  bool text = probe.word_or_end() == "solid";
  if (text) {
    probe.line();
    const std::string_view next = probe.word_or_end();
    text = next == "facet" || next == "endsolid" || bytes.size() < binary_header;
  }
  if (text)
    read_text(scanner, raw);
  else
    read_binary(scanner, raw);
  return raw;
}

}  // namespace phynness::meshes
