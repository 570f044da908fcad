// VTK's XML files: unstructured grids (.vtu) and poly data (.vtp), as ParaView, PyVista and `phynness show` write them.
#include <phynness/formats/error.hpp>

#include "raw_mesh.hpp"
#include "vtk_cells.hpp"
#include "vtk_xml.hpp"

namespace phynness::meshes {
namespace {

constexpr const char* again = "export the file again";

/// Cells as lists of node numbers from `offsets` and `connectivity`; `first` is added to each.
std::vector<std::vector<std::int32_t>> cells_of(const VtkXml& file, pugi::xml_node parent, std::size_t n_cells,
                                                std::size_t n_points, std::int32_t first) {
  std::vector<std::vector<std::int32_t>> cells;
  if (n_cells == 0) return cells;
  const auto offset_array = file.array(parent, "offsets"), point_array = file.array(parent, "connectivity");
  const auto offsets = file.numbers<std::int64_t>(offset_array, n_cells);
  std::int64_t before = 0;
  for (const std::int64_t offset : offsets) {
    if (offset < before) file.fail(offset_array, "the cell offsets do not ascend", std::to_string(offset), again);
    before = offset;
  }
  const auto points = file.numbers<std::int64_t>(point_array, static_cast<std::size_t>(before));
  before = 0;
  for (const std::int64_t offset : offsets) {
    auto& cell = cells.emplace_back();
    for (; before < offset; ++before) {
      const std::int64_t point = points[static_cast<std::size_t>(before)];
      if (point < 0 || static_cast<std::size_t>(point) >= n_points)
        file.fail(point_array, "a cell uses a point that is not in the file", std::to_string(point), again);
      cell.push_back(static_cast<std::int32_t>(first + point));
    }
  }
  return cells;
}

std::size_t append_points(const VtkXml& file, pugi::xml_node piece, RawMesh& raw) {
  const std::size_t n = file.count(piece, "NumberOfPoints");
  if (n == 0) return 0;
  const auto array = file.array(piece.child("Points"), "");
  if (array.attribute("NumberOfComponents").as_int(3) != 3)
    file.fail(array, "the points do not have three coordinates", array.attribute("NumberOfComponents").value(), again);
  const auto x = file.numbers<double>(array, 3 * n);
  for (std::size_t i = 0; i < n; ++i) raw.nodes.push_back({x[3 * i], x[3 * i + 1], x[3 * i + 2]});
  return n;
}

template <class AddCells>
RawMesh read_pieces(const std::string& bytes, const std::string& source, const char* kind, const AddCells& add_cells) {
  const VtkXml file(bytes, source, kind);
  RawMesh raw;
  std::size_t n_pieces = 0;
  for (const auto piece : file.grid().children("Piece")) {
    const auto first = static_cast<std::int32_t>(raw.nodes.size());
    const std::size_t n = append_points(file, piece, raw);
    constexpr std::size_t most_points = 40'000'000;
    if (raw.nodes.size() > most_points)
      file.fail(piece, "the file holds more points than can be solved", std::to_string(raw.nodes.size()),
                "give a coarser mesh");
    add_cells(file, piece, n, first, raw);
    if (n > 0) ++n_pieces;
  }
  if (n_pieces > 1) raw.notes.push_back("the file holds " + std::to_string(n_pieces) + " pieces");
  if (raw.tetrahedra.empty() && raw.triangles.empty())
    throw input_error(source + ": the file holds neither tetrahedra nor polygons",
                      std::to_string(raw.nodes.size()) + " points", "save the mesh with its cells");
  return raw;
}

/// Reports the cell where `array` is.
auto failing_at(const VtkXml& file, pugi::xml_node array) {
  return [&file, array](const std::string& what, const std::string& value, const std::string& remedy) {
    file.fail(array, what, value, remedy);
  };
}

}  // namespace

RawMesh read_vtu(const std::string& bytes, const std::string& source) {
  return read_pieces(bytes, source, "UnstructuredGrid",
                     [](const VtkXml& file, pugi::xml_node piece, std::size_t n, std::int32_t first, RawMesh& raw) {
                       const auto node = piece.child("Cells");
                       const auto cells = cells_of(file, node, file.count(piece, "NumberOfCells"), n, first);
                       if (cells.empty()) return;
                       const auto array = file.array(node, "types");
                       const auto types = file.numbers<std::int64_t>(array, cells.size());
                       for (std::size_t c = 0; c < cells.size(); ++c)
                         add_vtk_cell(cells[c], c, types[c], raw, failing_at(file, array));
                     });
}

RawMesh read_vtp(const std::string& bytes, const std::string& source) {
  return read_pieces(bytes, source, "PolyData",
                     [](const VtkXml& file, pugi::xml_node piece, std::size_t n, std::int32_t first, RawMesh& raw) {
                       if (piece.attribute("NumberOfStrips").as_uint(0) > 0)
                         file.fail(piece, "the file holds triangle strips", piece.attribute("NumberOfStrips").value(),
                                   "triangulate the surface (in ParaView: filter Triangulate) and save it again");
                       const auto node = piece.child("Polys");
                       if (!node) return;
                       const auto cells = cells_of(file, node, file.count(piece, "NumberOfPolys"), n, first);
                       for (std::size_t c = 0; c < cells.size(); ++c)
                         add_vtk_cell(cells[c], c, vtk_polygon, raw, failing_at(file, node));
                     });
}

}  // namespace phynness::meshes
