#include "fine_surface.hpp"

#include <fmt/core.h>

#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/vtk.hpp>
#include <phynness/phynness_surface.hpp>

namespace phynness::cli {
namespace {

std::string obj_text(const VtkGrid& grid, const Eigen::MatrixXd& displacement, const std::string& title) {
  std::string text = "# " + title + "\n";
  for (Eigen::Index i = 0; i < grid.points.rows(); ++i) {
    const Eigen::RowVector3d x = grid.points.row(i) + displacement.row(i);
    text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", x[0], x[1], x[2]);
  }
  for (Eigen::Index t = 0; t < grid.cells.rows(); ++t)
    text += fmt::format("f {} {} {}\n", grid.cells(t, 0) + 1, grid.cells(t, 1) + 1, grid.cells(t, 2) + 1);
  return text;
}

}  // namespace

void check_surface_name(const std::filesystem::path& file) {
  const auto extension = file.extension();
  if (extension != ".vtu" && extension != ".obj")
    throw input_error("the format of the surface file is unknown", file.string(),
                      "give --surface a name that ends in .vtu or .obj");
}

std::int32_t write_fine_surface(const LoadedModel& model, const Points& displacement_m, int levels,
                                const std::filesystem::path& file, const std::string& title) {
  const rt::Surface surface(model.runtime(), levels);
  if (surface.status() == PHN_ERROR_UNDEFINED)
    throw input_error(
        "the model has no surface", file.string(),
        "its triangles connect output and fixed nodes: select the surface as nodes.output and train again");
  if (!surface)
    throw input_error("the surface cannot be subdivided", fmt::format("--subdivide {}", levels),
                      std::string("use fewer levels (") + surface.status().message() + ")");
  const auto n = surface.n_vertices();
  std::vector<float> scratch(surface.n_scratch());
  using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
  FloatRows fine(n, 3);
  const rt::Status status =
      surface.deform(scratch, {displacement_m.data(), static_cast<std::size_t>(displacement_m.size())},
                     {fine.data(), static_cast<std::size_t>(fine.size())});
  if (!status.ok())
    throw failure("the runtime cannot deform the surface", status.message(), "please report this defect");

  VtkGrid grid;
  grid.points = Eigen::Map<const FloatRows>(surface.points().data(), n, 3).cast<double>();
  grid.cells = Eigen::Map<const Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>>(
      surface.triangles().data(), static_cast<Eigen::Index>(surface.triangles().size() / 3), 3);
  for (const auto part : {model.runtime().output_nodes(), model.runtime().fixed_nodes()})
    grid.node_numbers.insert(grid.node_numbers.end(), part.begin(), part.end());
  grid.node_numbers.resize(static_cast<std::size_t>(n), -1);
  const Eigen::MatrixXd displacement = fine.cast<double>();
  if (file.extension() == ".obj") {
    write_text_file(file, obj_text(grid, displacement, title));
  } else {
    write_text_file(file, vtu_text(grid, {0, {{"displacement", displacement}}}));
  }
  return n;
}

}  // namespace phynness::cli
