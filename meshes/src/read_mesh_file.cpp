#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/formats/mesh_files.hpp>

#include "raw_mesh.hpp"

namespace phynness::meshes {
namespace {

const char* dimension_name(int dimension) {
  constexpr const char* names[] = {"point", "line", "surface", "volume"};
  return names[dimension];
}

void sort_unique(std::vector<std::int32_t>& nodes) {
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

using Reader = RawMesh (*)(const std::string&, const std::string&);

/// In the order of mesh_file_extensions.
constexpr std::pair<std::string_view, Reader> readers[] = {
    {".msh", &read_msh}, {".vtk", &read_vtk}, {".vtu", &read_vtu}, {".vtp", &read_vtp}, {".inp", &read_inp},
    {".stl", &read_stl}, {".obj", &read_obj}, {".ply", &read_ply}, {".off", &read_off}};

Reader reader_of(const std::string& extension) {
  for (const auto& [ending, reader] : readers)
    if (ending == extension) return reader;
  return nullptr;
}

std::string extensions() {
  std::string list;
  for (const auto& ending : mesh_file_extensions)
    list.append(list.empty() ? "" : ending == mesh_file_extensions.back() ? " or " : ", ").append(ending);
  return list;
}

}  // namespace

void GroupBuilder::add(int dimension, std::int64_t tag, const std::vector<std::int32_t>& nodes) {
  if (tag == 0) return;  // in gmsh's format: belongs to no physical group
  auto& list = _nodes[{dimension, tag}];
  list.insert(list.end(), nodes.begin(), nodes.end());
}

void GroupBuilder::finish(RawMesh& raw) const {
  std::map<std::int64_t, std::vector<int>> unnamed;
  const auto join = [&raw](const std::string& name, const std::vector<std::int32_t>& nodes) {
    auto& list = raw.groups[name];
    list.insert(list.end(), nodes.begin(), nodes.end());
  };
  for (const auto& [key, nodes] : _nodes) {
    const auto found = _names.find(key);
    if (found == _names.end()) unnamed[key.second].push_back(key.first);
    join(found == _names.end() ? std::to_string(key.second) : found->second, nodes);
  }
  for (const auto& [tag, dimensions] : unnamed) {
    if (dimensions.size() < 2) continue;
    std::string note = "physical tag " + std::to_string(tag) + " is used by several dimensions: group '" +
                       std::to_string(tag) + "' holds all of them, and there are";
    for (const int dimension : dimensions) {
      const std::string name = std::string(dimension_name(dimension)) + ' ' + std::to_string(tag);
      join(name, _nodes.at({dimension, tag}));
      note += " '" + name + "'";
    }
    raw.notes.push_back(note);
  }
  for (auto& [name, nodes] : raw.groups) sort_unique(nodes);
}

RawMesh read_mesh_file(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  const auto reader = reader_of(extension);
  if (!reader)
    throw input_error("mesh file of an unknown kind", file.string(), "give a file whose name ends in " + extensions());
  // Ten million tetrahedra, a hundred times the number that can be solved, take about 600 MB as text.
  constexpr std::uint64_t most_bytes = 1 << 30;
  const bool is_text = extension == ".obj" || extension == ".inp";  // the others may be binary
  const std::string bytes =
      read_input_file(file, {"the mesh file", "name a file that ends in " + extensions(), most_bytes, is_text});
  if (bytes.empty()) throw input_error("the mesh file is empty", file.string(), "export the file again");
  return reader(bytes, file.filename().string());
}

}  // namespace phynness::meshes
