// Values of keys that need a parser of their own, and the checks of a section whose keys have been read.
#pragma once

#include "scene_table.hpp"

namespace phynness::scene_detail {

/// Range of lengths of a scene [m].
inline constexpr Range length{0, 1e3, true, false};
/// Of a built-in shape: gmsh and the squares and cubes of lengths need more than the smallest number there is.
inline constexpr Range shape_length{1e-9, 1e3};

/// [material] law and its numbers.
Material parse_material(const SceneTable& table);
/// That of a region: the body's law, with the numbers that the region gives.
/// @param body  [material]
Material parse_material(const SceneTable& region, const SceneTable& body, Law law);
/// [material] relaxation.
Relaxation parse_relaxation(const SceneTable& material);
/// The selection under `key` of [nodes].
Selection parse_selection(const SceneTable& nodes, std::string_view key);
/// The selection of cells under `key` of [[region]].
Selection parse_cells(const SceneTable& region, std::string_view key);
/// [probe] directions, an integer or text.
Directions parse_directions(const SceneTable& probe);
/// [database] fields, in the order of enum Field.
std::vector<Field> parse_fields(const SceneTable& database);

/// Completes the path of a file by `folder`, and a shape by its standard number of nodes and thickness.
void check_mesh(const SceneTable& table, const std::filesystem::path& folder, MeshFile mesh_file, MeshSpec& spec);
/// Refuses a law for which the condition of zero stress across the wall of a shell is not implemented, or not accurate
/// enough with these moduli.
void check_material(const SceneTable& table, const Scene& scene);
/// @param table  the section of scene.regions.back()
void check_region(const SceneTable& table, const Scene& scene);
void check_solver(const SceneTable& table, Scene& scene);
void check_nodes(const SceneTable& table, Scene& scene);
void check_probe(const SceneTable& table, ProbeSpec& spec);
/// @param table  [probe]. @pre element and output nodes are known
void check_tools(const SceneTable& table, const Scene& scene);
void check_database(const SceneTable& table, const Scene& scene);
/// Refuses a family that cannot be trained on the material, before its database is computed in hours.
void check_training(const SceneTable& table, const Scene& scene);

}  // namespace phynness::scene_detail
