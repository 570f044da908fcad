// Geomview's object files as text: vertices and faces. Normals and colours are skipped.

#include "raw_mesh.hpp"
#include "scanner.hpp"

namespace phynness::meshes {
namespace {

/// The next line with contents, without its comment; empty at the end of the file.
/// @param here  output, the place of this line
std::string_view filled_line(Scanner& scanner, Scanner& here) {
  while (!scanner.at_end()) {
    here = scanner;
    std::string_view line = scanner.line();
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") != std::string_view::npos) return line;
  }
  return {};
}

/// Reads numbers of a line; the rest of the line is skipped.
class LineNumbers {
 public:
  LineNumbers(Scanner& file, const char* expected)
      : _here(file), _words(filled_line(file, _here), ""), _expected(expected) {
    if (_words.at_end()) file.truncated(expected + std::string(", each of which has a line of its own"));
  }
  template <class Number>
  Number next() {
    const auto word = _words.word_or_end();
    if (word.empty()) fail(std::string("a line is too short for ") + _expected);
    return _here.parse<Number>(word, _expected);
  }
  [[noreturn]] void fail(const std::string& what, std::string_view value = {}) const { _here.fail(what, value); }

 private:
  Scanner _here, _words;
  const char* _expected;
};

/// Moves the scanner to the counts, which may be on the line of the format's name.
void read_format(Scanner& scanner, const std::string& source) {
  Scanner begin = scanner, here = scanner;
  const std::string_view line = filled_line(begin, here);
  Scanner words(line, source);
  const std::string format(words.word_or_end());
  if (format.empty() || format.find_first_not_of("0123456789") == std::string::npos) return;  // the name may be absent
  if (!upper(format).ends_with("OFF") || format.size() > 7)
    throw input_error(source + ":1: not an .off file", format.substr(0, 40), again);
  if (format.find('4') != std::string::npos || format.find('n') != std::string::npos || words.word_or_end() == "BINARY")
    throw input_error(source + ":1: unsupported kind of .off file", std::string(line.substr(0, 40)),
                      "save it as text with three coordinates");
  scanner = here;
  scanner.word_or_end();
}

}  // namespace

RawMesh read_off(const std::string& bytes, const std::string& source) {
  Scanner scanner(bytes, source);
  read_format(scanner, source);
  LineNumbers counts(scanner, "the numbers of vertices and faces");
  const auto n_nodes = scanner.checked_count(counts.next<std::int64_t>(), 6, "vertices");
  const auto n_faces = scanner.checked_count(counts.next<std::int64_t>(), 6, "faces");
  RawMesh raw;
  raw.nodes.resize(n_nodes);
  for (auto& x : raw.nodes) {
    LineNumbers numbers(scanner, "a vertex");
    for (double& value : x) value = numbers.next<double>();
  }
  for (std::size_t f = 0; f < n_faces; ++f) {
    LineNumbers numbers(scanner, "a face");
    const auto n = numbers.next<std::int64_t>();
    if (n < 3) numbers.fail("a face has fewer than three vertices", std::to_string(n));
    std::vector<std::int32_t> corners;
    for (std::int64_t k = 0; k < n; ++k) {
      const auto i = numbers.next<std::int64_t>();
      if (i < 0 || static_cast<std::size_t>(i) >= n_nodes)
        numbers.fail("a face uses a vertex that is not in the file", std::to_string(i));
      corners.push_back(static_cast<std::int32_t>(i));
    }
    raw.add_polygon(corners);
  }
  return raw;
}

}  // namespace phynness::meshes
