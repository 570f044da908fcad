#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/mesh.hpp>
#include <string_view>
#include <tuple>

namespace phynness {
namespace {

// Faces of a positively oriented tetrahedron, seen counterclockwise from outside.
constexpr int outward_faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

constexpr std::string_view magic = mesh_text_magic;
constexpr std::string_view version = "1";
constexpr std::string_view checksum_word = "checksum ";
constexpr std::size_t checksum_line_length = checksum_word.size() + 16 + 1;

template <class Unsigned>
void add_little_endian(Fnv1a64& hash, Unsigned value) {
  unsigned char bytes[sizeof value];
  for (std::size_t i = 0; i < sizeof value; ++i) bytes[i] = static_cast<unsigned char>(value >> (8 * i));
  hash.add(bytes, sizeof value);
}

void append(std::string& text, std::int64_t value) {
  char buffer[24];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

void append(std::string& text, double value) {
  char buffer[40];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::hex).ptr);
}

template <class Matrix>
void append_rows(std::string& text, const Matrix& rows) {
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    for (Eigen::Index k = 0; k < rows.cols(); ++k) {
      append(text, rows(i, k));
      text += k + 1 < rows.cols() ? ' ' : '\n';
    }
}

void append_numbers(std::string& text, const std::vector<std::int32_t>& numbers) {
  for (const std::int32_t n : numbers) {
    append(text, std::int64_t{n});
    text += '\n';
  }
}

std::string checksum_of(std::string_view body) {
  Fnv1a64 hash;
  hash.add(body);
  return hash.hex();
}

/// Cursor over the lines of a mesh.txt whose checksum has already been verified.
class Lines {
 public:
  Lines(std::string_view text, const std::string& source) : _text(text), _source(source) {}

  bool at_end() const { return _text.empty(); }

  [[noreturn]] void fail(const std::string& what, std::string_view value) const {
    throw input_error(_source + ":" + std::to_string(_line) + ": " + what, std::string(value),
                      "write the file again with this software; it cannot be edited by hand");
  }

  std::string_view next(const char* expected) {
    ++_line;
    const std::size_t end = _text.find('\n');
    if (end == std::string_view::npos) fail(std::string("the mesh text ends before ") + expected, "");
    const std::string_view line = _text.substr(0, end);
    _text.remove_prefix(end + 1);
    return line;
  }

  /// Reads a line "KEYWORD rest". @return the rest
  std::string_view keyword(std::string_view word) {
    const std::string_view line = next(std::string(word).c_str());
    if (!line.starts_with(word) || line.size() <= word.size() || line[word.size()] != ' ')
      fail("expected the keyword '" + std::string(word) + "'", line);
    return line.substr(word.size() + 1);
  }

  template <class Number>
  Number number(std::string_view& rest) const {
    Number value{};
    std::from_chars_result result{};
    if constexpr (std::is_floating_point_v<Number>)
      result = std::from_chars(rest.data(), rest.data() + rest.size(), value, std::chars_format::hex);
    else
      result = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (result.ec != std::errc{}) fail("malformed number", rest);
    rest.remove_prefix(static_cast<std::size_t>(result.ptr - rest.data()));
    if (!rest.empty()) {
      if (rest[0] != ' ' || rest.size() == 1) fail("malformed number", rest);
      rest.remove_prefix(1);
    }
    return value;
  }

  /// The number of following lines. It is limited by the bytes of the text, so that a wrong count cannot exhaust
  /// memory.
  std::int32_t count(std::string_view& rest) const {
    const auto n = number<std::int32_t>(rest);
    if (n < 0 || static_cast<std::size_t>(n) > _text.size() / 2) fail("impossible count", std::to_string(n));
    return n;
  }

  void finished(std::string_view rest) const {
    if (!rest.empty()) fail("unexpected text at the end of the line", rest);
  }

  std::int32_t node(std::string_view& rest, Eigen::Index n_nodes) const {
    const auto i = number<std::int32_t>(rest);
    if (i < 0 || i >= n_nodes) fail("node number out of range", std::to_string(i));
    return i;
  }

  template <class Matrix>
  void node_rows(Matrix& rows, Eigen::Index n_nodes) {
    for (Eigen::Index r = 0; r < rows.rows(); ++r) {
      std::string_view rest = next("a row of node numbers");
      for (Eigen::Index k = 0; k < rows.cols(); ++k) rows(r, k) = node(rest, n_nodes);
      finished(rest);
    }
  }

  std::vector<std::int32_t> node_list(std::int32_t n, Eigen::Index n_nodes) {
    std::vector<std::int32_t> list(static_cast<std::size_t>(n));
    for (auto& entry : list) {
      std::string_view rest = next("a node number");
      entry = node(rest, n_nodes);
      finished(rest);
    }
    return list;
  }

 private:
  std::string_view _text;
  const std::string& _source;
  int _line = 0;
};

/// The text before the checksum line. The first line and the checksum are verified.
std::string_view verified_body(std::string_view text, const std::string& source) {
  const std::string_view first = text.substr(0, text.find('\n'));
  if (!first.starts_with(magic) || (first.size() > magic.size() && first[magic.size()] != ' '))
    throw input_error(
        source + ":1: not a phynness mesh: the first line does not start with '" + std::string(magic) + "'",
        std::string(first.substr(0, 40)), "give the mesh.txt of a model folder");
  if (text.find('\n') == std::string_view::npos)
    throw input_error(source + ": the mesh text is truncated", "it ends in its first line", "copy the file again");
  const std::string_view found = first.substr(std::min(first.size(), magic.size() + 1));
  if (found != version)
    throw input_error(source + ":1: the mesh text has another version", std::string(found),
                      "write the file again with this software, which reads version " + std::string(version));
  if (text.size() < checksum_line_length || text.back() != '\n' ||
      !text.substr(text.size() - checksum_line_length).starts_with(checksum_word))
    throw input_error(source + ": the mesh text is truncated", "no checksum in its last line", "copy the file again");
  const std::string_view body = text.substr(0, text.size() - checksum_line_length);
  const std::string_view stored = text.substr(body.size() + checksum_word.size(), 16);
  if (const std::string actual = checksum_of(body); actual != stored)
    throw input_error(source + ": the mesh text is corrupted",
                      "checksum " + std::string(stored) + " instead of " + actual, "copy the file again");
  return body;
}

}  // namespace

Triangles boundary_triangles(const Cells& cells) {
  struct Face {
    std::array<std::int32_t, 3> key;
    Eigen::Index cell;
    int local;
  };
  std::vector<Face> faces;
  faces.reserve(static_cast<std::size_t>(cells.rows()) * 4);
  for (Eigen::Index c = 0; c < cells.rows(); ++c)
    for (int f = 0; f < 4; ++f) {
      std::array<std::int32_t, 3> key{cells(c, outward_faces[f][0]), cells(c, outward_faces[f][1]),
                                      cells(c, outward_faces[f][2])};
      std::sort(key.begin(), key.end());
      faces.push_back({key, c, f});
    }
  std::sort(faces.begin(), faces.end(), [](const Face& p, const Face& q) {
    return std::tie(p.key, p.cell, p.local) < std::tie(q.key, q.cell, q.local);
  });
  std::vector<std::pair<Eigen::Index, int>> boundary;
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t j = i + 1;
    while (j < faces.size() && faces[j].key == faces[i].key) ++j;
    if (j == i + 1) boundary.emplace_back(faces[i].cell, faces[i].local);
    i = j;
  }
  std::sort(boundary.begin(), boundary.end());
  Triangles triangles(static_cast<Eigen::Index>(boundary.size()), 3);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) triangles(t, k) = cells(boundary[t].first, outward_faces[boundary[t].second][k]);
  return triangles;
}

std::vector<std::int32_t> surface_nodes(const Triangles& surface) {
  std::vector<std::int32_t> nodes(surface.data(), surface.data() + surface.size());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

Points node_normals(const Points& nodes, const Triangles& surface) {
  Points normals = Points::Zero(nodes.rows(), 3);
  for (Eigen::Index t = 0; t < surface.rows(); ++t) {
    const Eigen::RowVector3d a = nodes.row(surface(t, 0));
    const Eigen::RowVector3d b = nodes.row(surface(t, 1));
    const Eigen::RowVector3d c = nodes.row(surface(t, 2));
    const Eigen::RowVector3d twice_area = (b - a).cross(c - a);
    for (int k = 0; k < 3; ++k) normals.row(surface(t, k)) += twice_area;
  }
  for (Eigen::Index i = 0; i < normals.rows(); ++i)
    if (const double length = normals.row(i).norm(); length > 0) normals.row(i) /= length;
  return normals;
}

std::string mesh_hash(const Mesh& mesh) {
  Fnv1a64 hash;
  for (Eigen::Index i = 0; i < mesh.nodes.size(); ++i)
    add_little_endian(hash, std::bit_cast<std::uint64_t>(mesh.nodes.data()[i]));
  for (Eigen::Index i = 0; i < mesh.cells.size(); ++i)
    add_little_endian(hash, std::bit_cast<std::uint32_t>(mesh.cells.data()[i]));
  return hash.hex();
}

std::string write_mesh_text(const Mesh& mesh, const std::vector<std::int32_t>& fixed) {
  const auto header = [](std::string& text, const char* word, std::int64_t n) {
    (text += word) += ' ';
    append(text, n);
  };
  std::string text = std::string(magic) + ' ' + std::string(version) + '\n';
  text += "hash " + mesh_hash(mesh) + '\n';
  header(text, "nodes", mesh.nodes.rows());
  text += '\n';
  append_rows(text, mesh.nodes);
  header(text, "cells", mesh.cells.rows());
  text += ' ';
  append(text, std::int64_t{mesh.cells.cols()});
  text += '\n';
  append_rows(text, mesh.cells.cast<std::int64_t>());
  header(text, "surface", mesh.surface.rows());
  text += '\n';
  append_rows(text, mesh.surface.cast<std::int64_t>());
  header(text, "fixed", static_cast<std::int64_t>(fixed.size()));
  text += '\n';
  append_numbers(text, fixed);
  for (const auto& [name, nodes] : mesh.groups) {
    if (name.empty() || name.find_first_of("\r\n") != std::string::npos)
      throw input_error("the name of a physical group is empty or contains a line break", name, "rename the group");
    header(text, "group", static_cast<std::int64_t>(nodes.size()));
    text += ' ' + name + '\n';
    append_numbers(text, nodes);
  }
  const std::string checksum = checksum_of(text);
  return text + std::string(checksum_word) + checksum + '\n';
}

Mesh read_mesh_text(const std::string& text, const std::string& source_name, std::vector<std::int32_t>* fixed) {
  Lines lines(verified_body(text, source_name), source_name);
  lines.next("the first line");
  const std::string_view hash = lines.keyword("hash");

  Mesh mesh;
  std::string_view rest = lines.keyword("nodes");
  mesh.nodes.resize(lines.count(rest), 3);
  lines.finished(rest);
  for (Eigen::Index i = 0; i < mesh.nodes.rows(); ++i) {
    rest = lines.next("a node");
    for (int k = 0; k < 3; ++k) mesh.nodes(i, k) = lines.number<double>(rest);
    lines.finished(rest);
    if (!mesh.nodes.row(i).allFinite()) lines.fail("a node's coordinates are not finite", std::to_string(i));
  }

  rest = lines.keyword("cells");
  const std::int32_t n_cells = lines.count(rest);
  const auto nodes_per_cell = lines.number<std::int32_t>(rest);
  lines.finished(rest);
  if (nodes_per_cell != 3 && nodes_per_cell != 4)
    lines.fail("cells must have 3 or 4 nodes", std::to_string(nodes_per_cell));
  mesh.cells.resize(n_cells, nodes_per_cell);
  lines.node_rows(mesh.cells, mesh.nodes.rows());

  rest = lines.keyword("surface");
  mesh.surface.resize(lines.count(rest), 3);
  lines.finished(rest);
  lines.node_rows(mesh.surface, mesh.nodes.rows());

  rest = lines.keyword("fixed");
  const std::int32_t n_fixed = lines.count(rest);
  lines.finished(rest);
  auto fixed_nodes = lines.node_list(n_fixed, mesh.nodes.rows());
  if (fixed) *fixed = std::move(fixed_nodes);

  while (!lines.at_end()) {
    rest = lines.keyword("group");
    const std::int32_t n = lines.count(rest);
    if (rest.empty()) lines.fail("a group has no name", "");
    const std::string name(rest);
    mesh.groups[name] = lines.node_list(n, mesh.nodes.rows());
  }
  if (const std::string actual = mesh_hash(mesh); actual != hash)
    throw input_error(source_name + ": the mesh does not have the stored hash",
                      "hash " + std::string(hash) + " instead of " + actual, "write the file again");
  return mesh;
}

}  // namespace phynness
