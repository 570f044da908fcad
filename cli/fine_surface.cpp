#include "fine_surface.hpp"

#include <fmt/core.h>

#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/vtk.hpp>

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
  if (extension != ".vtk" && extension != ".vtu" && extension != ".obj")
    throw input_error("the name of the surface does not end in a format that can be written", file.string(),
                      "--surface file.vtk, file.vtu or file.obj");
}

std::int32_t write_fine_surface(const LoadedModel& model, const Points& displacement_m, int levels,
                                const std::filesystem::path& file, const std::string& title) {
  const phn_model* handle = model.handle();
  std::size_t bytes = 0;
  const int status = phn_surface_size(handle, levels, &bytes);
  if (status == PHN_ERROR_UNDEFINED)
    throw input_error("the model has no surface", file.string(),
                      "its triangles join output and fixed nodes: select the surface as nodes.output");
  if (status < 0)
    throw input_error("the surface cannot be subdivided", fmt::format("--subdivide {}", levels),
                      std::string("fewer levels; the runtime says: ") + phn_status_message(status));
  std::vector<std::byte> memory(bytes);
  const phn_surface* surface = nullptr;
  const auto require = [](int code) {
    if (code < 0) throw failure("the runtime refuses a surface", phn_status_message(code), "report this");
  };
  require(phn_surface_init(memory.data(), bytes, handle, levels, &surface));
  const auto n = phn_surface_n_vertices(surface);
  std::vector<float> scratch(phn_surface_scratch(surface));
  using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
  FloatRows fine(n, 3);
  require(phn_surface_deform(surface, scratch.data(), displacement_m.data(), fine.data()));

  VtkGrid grid;
  grid.points = Eigen::Map<const FloatRows>(phn_surface_points(surface), n, 3).cast<double>();
  grid.cells = Eigen::Map<const Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>>(
      phn_surface_triangles(surface), phn_surface_n_triangles(surface), 3);
  const Model& parts = model.model();
  grid.node_numbers = parts.output;
  grid.node_numbers.insert(grid.node_numbers.end(), parts.fixed.begin(), parts.fixed.end());
  grid.node_numbers.resize(static_cast<std::size_t>(n), -1);
  const Eigen::MatrixXd displacement = fine.cast<double>();
  if (file.extension() == ".obj") {
    write_text_file(file, obj_text(grid, displacement, title));
  } else {
    const VtkState state{0, {{"displacement", displacement}}};
    write_text_file(file,
                    file.extension() == ".vtu" ? vtu_text(grid, state) : legacy_vtk_text(grid, state, title));
  }
  return n;
}

}  // namespace phynness::cli
