#include "raw_mesh.hpp"
#include "scanner.hpp"

namespace phynness::meshes {

RawMesh read_obj(const std::string& bytes, const std::string& source) {
  Scanner scanner(bytes, source);
  RawMesh raw;
  std::size_t polygons = 0;
  std::vector<std::int32_t> corners;
  while (!scanner.at_end()) {
    const Scanner here = scanner;  // errors name this line, not the next one
    std::string line(scanner.line());
    while (line.ends_with('\\') && !scanner.at_end()) line.back() = ' ', line += scanner.line();
    Scanner words(std::string_view(line).substr(0, line.find('#')), "");
    const std::string_view word = words.word_or_end();
    if (word == "v") {
      auto& x = raw.nodes.emplace_back();
      for (double& value : x) {
        const std::string_view field = words.word_or_end();
        if (field.empty()) here.fail("a vertex has fewer than three coordinates");
        value = here.parse<double>(field, "a vertex coordinate");
      }
    } else if (word == "f") {
      corners.clear();
      for (std::string_view field = words.word_or_end(); !field.empty(); field = words.word_or_end()) {
        const auto index = here.parse<std::int64_t>(field.substr(0, field.find('/')), "a face's vertex");
        const auto n = static_cast<std::int64_t>(raw.nodes.size());
        const std::int64_t position = index > 0 ? index - 1 : n + index;  // negative: relative to the last vertex
        if (index == 0 || position < 0 || position >= n)
          here.fail("a face uses a vertex that is not defined above it", std::to_string(index));
        corners.push_back(static_cast<std::int32_t>(position));
      }
      if (corners.size() < 3) here.fail("a face has fewer than three vertices");
      if (corners.size() > 3) ++polygons;
      raw.add_polygon(corners);
    }
  }
  if (polygons > 0)
    raw.notes.push_back("split " + std::to_string(polygons) + " faces of more than three vertices into triangles");
  return raw;
}

}  // namespace phynness::meshes
