// The sections of a scene, each parsed by one function from its table.
#pragma once

#include "scene_table.hpp"

namespace phynness::scene_detail {

/// Lengths of a scene, in m.
inline constexpr Range length{0, 1e3, true, false};
/// Of a built-in shape: gmsh and the squares and cubes of lengths need more than the smallest number there is.
inline constexpr Range shape_length{1e-9, 1e3};

/// A position under `stem`_m or `stem`_fraction, one of which must be there.
Vec3 parse_position(const SceneTable& table, const std::string& stem, bool& fraction);
/// `normal`, of any length but zero, made a unit vector.
Vec3 parse_normal(const SceneTable& table);

/// [mesh] symmetry, if it is there: a word or a table.
std::optional<SymmetryPlane> parse_symmetry(const SceneTable& mesh);
MeshSpec parse_mesh(const SceneTable& table, const std::filesystem::path& folder, MeshFile mesh_file);
Material parse_material(const SceneTable& table);
/// @param solid_element  where the scene names none and the mesh has no thickness
SolverSpec parse_solver(const SceneTable& table, const Material& material, const MeshSpec& mesh, Element solid_element);
/// A selection under `key` of [nodes].
Selection parse_selection(const SceneTable& nodes, std::string_view key);
/// Fills fixed, active and output with their locations.
void parse_nodes(const SceneTable& table, Scene& scene);
ProbeSpec parse_probe(const SceneTable& table);
DatabaseSpec parse_database(const SceneTable& table);
/// [database] fields, in the order of enum Field.
std::vector<Field> parse_fields(const SceneTable& database);
/// Refuses a family that cannot be trained on the material, before hours are spent on its database.
TrainingSpec parse_training(const SceneTable& table, const Material& material);
ValidationSpec parse_validation(const SceneTable& table);

}  // namespace phynness::scene_detail
