#include "small_database.hpp"

#include <cmath>

namespace phynness::fuzz {
namespace {

const char* const scene = R"(title = "a block"
[mesh]
shape = "block"
[material]
law = "neo-hookean"
c10_Pa = 250.0
bulk_modulus_Pa = 100e3
[solver]
element = "P1"
[nodes]
fixed = { nodes = [0] }
[probe]
max_displacement_m = 0.02
increments = 2
)";

}  // namespace

DatabaseHeader small_header(bool rich) {
  DatabaseHeader h;
  h.mesh.nodes.resize(8, 3);
  h.mesh.nodes << -1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1;
  h.mesh.nodes *= 0.05;
  h.mesh.cells.resize(6, 4);
  h.mesh.cells << 0, 1, 3, 7, 0, 3, 2, 7, 0, 2, 6, 7, 0, 6, 4, 7, 0, 4, 5, 7, 0, 5, 1, 7;
  h.mesh.surface = boundary_triangles(h.mesh.cells);
  h.mesh.groups["bottom"] = {0, 1, 2, 3};
  h.sets.fixed = {0, 1, 2, 3};
  h.sets.active = {6, 7};
  h.sets.tools = single_nodes(h.sets.active);
  h.sets.output = {4, 5, 6, 7};
  h.directions = exploratory_directions(Directions::twenty_six);
  h.directions.resize(6);
  h.magnitudes_m = {0.01, 0.02};
  h.tangents = true;
  h.scene_text = scene;
  h.scene_name = "block.toml";
  h.scene_folder = "/somewhere";
  h.software_version = "phynness";
  if (rich) h.fields = {every_field.begin(), every_field.end()};
  return h;
}

Ray small_ray(const DatabaseHeader& header, std::int32_t active, std::int32_t direction) {
  constexpr double stiffness_N_per_m = 30, stiffening = 40;
  const auto d = static_cast<std::size_t>(direction);
  const std::size_t n_output = header.sets.output.size();
  Ray ray = empty_ray(header, active, direction);
  ray.end = {};
  for (std::size_t i = 0; i < header.magnitudes_m.size(); ++i) {
    const double magnitude = header.magnitudes_m[i], k = stiffness_N_per_m * (1 + stiffening * magnitude);
    ray.status[i] = Status::converged;
    ray.energy[i] = k * magnitude * magnitude / 2;
    ray.iterations[i] = 3;
    ray.min_jacobian[i] = 0.9;
    ray.seconds[i] = 0.01;
    for (std::size_t c = 0; c < 3; ++c) {
      ray.force[3 * i + c] = k * magnitude * header.directions[d][c];
      if (header.tangents) ray.tangent[9 * i + 4 * c] = k;
    }
    for (std::size_t o = 0; o < n_output; ++o) {
      const bool touched = header.sets.output[o] == header.sets.active[static_cast<std::size_t>(active)];
      const double share = touched ? 1 : 0.2 + 0.1 * static_cast<double>(o) + magnitude;
      for (std::size_t c = 0; c < 3; ++c)
        ray.displacement[3 * (i * n_output + o) + c] = share * magnitude * header.directions[d][c];
      for (auto& field : ray.fields) field[i * n_output + o] = share * magnitude;
    }
  }
  return ray;
}

void write_small_database(const std::filesystem::path& file, bool rich, bool complete) {
  const auto header = small_header(rich);
  DatabaseWriter::create(file, header, false);
  DatabaseWriter writer(file, header, 0);
  for (std::int32_t a = 0; a < static_cast<std::int32_t>(header.sets.active.size()); ++a)
    for (std::int32_t d = 0; d < static_cast<std::int32_t>(header.directions.size()); ++d)
      writer.append(small_ray(header, a, d));
  writer.close();
  if (complete) DatabaseWriter::pack(file, header);
}

}  // namespace phynness::fuzz
