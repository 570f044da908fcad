// Specification: https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html.
#include <bit>
#include <cassert>
#include <phynness/formats/printable.hpp>
#include <phynness/formats/vtk.hpp>

namespace phynness {
namespace {

std::string attribute(const char* name, Eigen::Index value) {
  return std::string(" ") + name + "=\"" + std::to_string(value) + "\"";
}

std::string base64(const std::string& data) {
  static constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((data.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < data.size(); i += 3) {
    const std::size_t left = data.size() - i;
    const auto byte = [&](std::size_t k) {
      return k < left ? static_cast<std::uint32_t>(static_cast<unsigned char>(data[i + k])) : 0u;
    };
    const std::uint32_t word = byte(0) << 16 | byte(1) << 8 | byte(2);
    text += letters[word >> 18];
    text += letters[word >> 12 & 63];
    text += left > 1 ? letters[word >> 6 & 63] : '=';
    text += left > 2 ? letters[word & 63] : '=';
  }
  return text;
}

template <class Number>
void append_bytes(std::string& bytes, Number value) {
  static_assert(std::endian::native == std::endian::little, "byte swaps for this host are not implemented");
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// A DataArray of VTU: length in bytes (UInt64) and data, encoded together.
template <class Matrix>
std::string data_array(const std::string& name, const char* type, const Matrix& values, bool components) {
  std::string data;
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    for (Eigen::Index k = 0; k < values.cols(); ++k) append_bytes(data, values(i, k));
  std::string bytes;
  append_bytes(bytes, std::uint64_t{data.size()});
  return "        <DataArray type=\"" + std::string(type) + "\" Name=\"" + name + "\"" +
         (components ? attribute("NumberOfComponents", values.cols()) : "") + " format=\"binary\">" +
         base64(bytes + data) + "</DataArray>\n";
}

using Column = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 1>;

}  // namespace

std::string vtu_text(const VtkGrid& grid, const VtkState& state) {
  const Eigen::Index n_cells = grid.cells.rows(), width = grid.cells.cols();
  assert(static_cast<Eigen::Index>(grid.node_numbers.size()) == grid.points.rows());
  const Eigen::Map<const Column> numbers(grid.node_numbers.data(), grid.points.rows());
  const std::uint8_t cell_type = width == 4 ? 10 : width == 3 ? 5 : 1;
  Column offsets(n_cells);
  for (Eigen::Index i = 0; i < n_cells; ++i) offsets[i] = static_cast<std::int32_t>((i + 1) * width);
  const Eigen::Matrix<std::uint8_t, Eigen::Dynamic, 1> types =
      Eigen::Matrix<std::uint8_t, Eigen::Dynamic, 1>::Constant(n_cells, cell_type);
  const Eigen::Matrix<double, 1, 1> time{state.time};

  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n  <UnstructuredGrid>\n";
  std::string time_array = data_array("TimeValue", "Float64", time, false);
  time_array.insert(time_array.find(" format"), " NumberOfTuples=\"1\"");
  text += "    <FieldData>\n" + time_array + "    </FieldData>\n";
  text += "    <Piece" + attribute("NumberOfPoints", grid.points.rows()) + attribute("NumberOfCells", n_cells) + ">\n";
  text += "      <Points>\n" + data_array("Points", "Float64", grid.points, true) + "      </Points>\n";
  text += "      <Cells>\n" + data_array("connectivity", "Int32", grid.cells, false) +
          data_array("offsets", "Int32", offsets, false) + data_array("types", "UInt8", types, false) +
          "      </Cells>\n      <PointData>\n" + data_array("node", "Int32", numbers, false);
  for (const auto& field : state.fields) text += data_array(field.name, "Float64", field.values, true);
  text += "      </PointData>\n";
  if (!grid.regions.empty()) {
    assert(static_cast<Eigen::Index>(grid.regions.size()) == n_cells);
    const Eigen::Map<const Eigen::Matrix<std::uint8_t, Eigen::Dynamic, 1>> regions(grid.regions.data(), n_cells);
    text += "      <CellData>\n" + data_array("region", "UInt8", regions, false) + "      </CellData>\n";
  }
  return text + "    </Piece>\n  </UnstructuredGrid>\n</VTKFile>\n";
}

std::string pvd_text(const std::vector<std::string>& files, const std::vector<double>& times) {
  assert(files.size() == times.size());
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "  <Collection>\n";
  for (std::size_t i = 0; i < files.size(); ++i)
    text += "    <DataSet timestep=\"" + number_text(times[i]) + "\" part=\"0\" file=\"" + escaped(files[i]) + "\"/>\n";
  return text + "  </Collection>\n</VTKFile>\n";
}

}  // namespace phynness
