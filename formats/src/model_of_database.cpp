#include <phynness/formats/database.hpp>
#include <phynness/formats/model.hpp>

namespace phynness {

Model model_of_database(const DatabaseHeader& header, Family family, const std::string& title) {
  Model model;
  model.family = family;
  model.title = title;
  model.mesh_hash = header.mesh_hash;
  model.physics_hash = header.physics_hash;
  model.software_version = header.software_version;
  model.directions = header.directions;
  model.max_displacement_m = header.magnitudes_m.back();
  model.n_mesh_nodes = header.mesh.n_nodes();
  model.fixed = header.sets.fixed;
  model.output = header.sets.output;
  model.output_points.resize(static_cast<Eigen::Index>(model.output.size()), 3);
  for (std::size_t i = 0; i < model.output.size(); ++i)
    model.output_points.row(static_cast<Eigen::Index>(i)) = header.mesh.nodes.row(model.output[i]);
  return model;
}

}  // namespace phynness
