// Functions that parse the sections of a scene.
#pragma once

#include "scene_table.hpp"

namespace phynness::scene_detail {

/// Range of lengths of a scene [m].
inline constexpr Range length{0, 1e3, true, false};
/// Of a built-in shape: gmsh and the squares and cubes of lengths need more than the smallest number there is.
inline constexpr Range shape_length{1e-9, 1e3};

/// A position under the key `stem`_m or `stem`_fraction, one of which must be given.
Vec3 parse_position(const SceneTable& table, const std::string& stem, bool& fraction);
/// The key `normal`, a vector of any length except zero, as a unit vector.
Vec3 parse_normal(const SceneTable& table);

/// [mesh] symmetry, a word or a table; empty if it is not given.
std::optional<SymmetryPlane> parse_symmetry(const SceneTable& mesh);
MeshSpec parse_mesh(const SceneTable& table, const std::filesystem::path& folder, MeshFile mesh_file);
Material parse_material(const SceneTable& table);
/// @param solid_element  default element of a mesh without thickness
SolverSpec parse_solver(const SceneTable& table, const Material& material, const MeshSpec& mesh, Element solid_element);
/// The selection under `key` of [nodes].
Selection parse_selection(const SceneTable& nodes, std::string_view key);
/// Sets the selections fixed, active and output, and their positions in the file.
void parse_nodes(const SceneTable& table, Scene& scene);
ProbeSpec parse_probe(const SceneTable& table);
DatabaseSpec parse_database(const SceneTable& table);
/// [database] fields, in the order of enum Field.
std::vector<Field> parse_fields(const SceneTable& database);
/// Refuses a family that cannot be trained on the material, before its database is computed in hours.
TrainingSpec parse_training(const SceneTable& table, const Material& material);
ValidationSpec parse_validation(const SceneTable& table);

}  // namespace phynness::scene_detail
