#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/formats/mesh_files.hpp>

#include "raw_mesh.hpp"
#include "scanner.hpp"

namespace phynness::meshes {
namespace {

using Reader = RawMesh (*)(const std::string&, const std::string&);

constexpr std::pair<std::string_view, Reader> readers[] = {
    {".msh", &read_msh}, {".vtk", &read_vtk}, {".vtu", &read_vtu}, {".inp", &read_inp},
    {".stl", &read_stl}, {".obj", &read_obj}, {".ply", &read_ply}, {".off", &read_off}};

/// By the extension; the contents tell the two kinds of VTK, whose names are often exchanged.
Reader reader_of(const std::string& extension, std::string_view bytes) {
  const auto first = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
  if (extension == ".vtk" && bytes.substr(first, 1) == "<") return &read_vtu;
  if (extension == ".vtu" && bytes.starts_with("# vtk")) return &read_vtk;
  for (const auto& [ending, reader] : readers)
    if (ending == extension) return reader;
  return nullptr;
}

}  // namespace

RawMesh read_mesh_file(const std::filesystem::path& file) {
  const std::string extension = lower(file.extension().string());
  if (!reader_of(extension, {})) throw input_error("mesh file of an unknown kind", file.string(), mesh_file_kinds());
  // Ten million tetrahedra, a hundred times the number that can be solved, take about 600 MB as text.
  constexpr std::uint64_t most_bytes = 1 << 30;
  const bool is_text = extension == ".obj" || extension == ".inp";  // the others may be binary
  std::string bytes = read_input_file(file, {"the mesh file", mesh_file_kinds(), most_bytes, is_text});
  if (bytes.empty()) throw input_error("the mesh file is empty", file.string(), again);
  if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff"))
    throw input_error("the mesh file has two bytes for each letter (UTF-16)", file.string(), "save it as UTF-8");
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.erase(0, 3);            // the mark of UTF-8
  if (bytes.find_first_of(std::string_view("\n\0", 2)) == bytes.npos)  // text whose lines end with carriage returns
    std::replace(bytes.begin(), bytes.end(), '\r', '\n');
  const auto reader = reader_of(extension, bytes);
  RawMesh raw = reader(bytes, file.filename().string());
  raw.finish(reader == &read_stl);
  if (raw.tetrahedra.empty() && raw.triangles.empty())
    throw input_error(file.filename().string() + ": the file holds neither tetrahedra nor triangles",
                      std::to_string(raw.nodes.size()) + " nodes",
                      "mesh the body with 4-node tetrahedra, or its surface, and save all elements");
  if (bytes.back() >= '0' && bytes.back() <= '9' && bytes.find('\0') == bytes.npos)
    raw.notes.push_back("the file ends without a line break: if it was cut, its last number is incomplete");
  return raw;
}

}  // namespace phynness::meshes
