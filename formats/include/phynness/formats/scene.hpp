// A scene: body, probes, and settings of training and validation. Each key is a row of
// formats/src/scene/scene_rows.cpp.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <phynness/formats/fields.hpp>
#include <phynness/formats/law.hpp>
#include <phynness/formats/selector.hpp>
#include <phynness/schema/family.hpp>

namespace phynness {

enum class Shape { none, liver, block, cylinder, tube, drain };

/// A built-in shape with its standard dimensions. It has the keys of [mesh] whose numbers are not zero here.
struct ShapeRow {
  Shape shape;
  const char* name;  ///< in a scene
  int target_nodes;
  Vec3 size_m;
  double radius_m;
  double wall;  ///< inner over outer radius
  double length_m;
  double slit, slit_width_m;  ///< length of the slit over the shape's; largest width, or half the radius if less
  double thickness_m;
};
std::span<const ShapeRow> shapes();
/// @pre the shape is not `none`
const ShapeRow& row(Shape shape);

/// Exactly one of `shape` and `file` is given.
struct MeshSpec {
  Shape shape = Shape::none;
  std::filesystem::path file;           ///< absolute, resolved against the scene file's folder
  double scale_to_m = 1.0;              ///< file units -> m
  std::optional<int> target_nodes;      ///< built-in shapes: target number of nodes ...
  std::optional<double> target_size_m;  ///< ... or edge length; surfaces (.stl, .obj): edge length of the tetrahedra
  Vec3 size_m{0, 0, 0};                 ///< block: edges; liver: bounding box; 0 = the shape's default
  double radius_m = 0, inner_radius_m = 0, length_m = 0;  ///< cylinder, tube, drain
  double slit_length_m = 0, slit_width_m = 0;             ///< drain
  double thickness_m = 0;                                 ///< of the shell whose midsurface is the mesh; 0: a solid
  bool remesh = false;  ///< make new tetrahedra within the surface of a file of tetrahedra
  bool repair = false;  ///< allow repairs (flip cells, keep the largest component, ...)
  SourceLocation where;
};
/// The dimensions and the number of nodes of a built-in shape, where those that are not given have the standard of the
/// shape.
MeshSpec with_standard_sizes(MeshSpec spec);

/// The law's parameters, in the order of its row, and the moduli at rest, for any set of numbers given in the scene.
struct Material : Moduli {
  Law law = law_named("neo-hookean");
  std::vector<double> parameters;
  bool d1_given = false;  ///< K is 1/D1 of the scene
  SourceLocation where;
  double bulk_to_shear() const { return bulk_modulus_Pa / shear_modulus_Pa; }
  double youngs_modulus_Pa() const {
    return 9 * bulk_modulus_Pa * shear_modulus_Pa / (3 * bulk_modulus_Pa + shear_modulus_Pa);
  }
  double poisson_ratio() const { return youngs_modulus_Pa() / (2 * shear_modulus_Pa) - 1; }
};
/// The material from one of the sets of keys that the law accepts. Ranges are not checked here.
/// @throws Error (input) if the keys are not one of these sets
Material material_of(Law law, const std::vector<std::pair<std::string_view, double>>& given);

/// A part of a solid with parameters of its own in the body's law.
struct Region {
  std::string name;
  Selection cells;    ///< by their centroids, or by physical groups of cells
  int order = 0;      ///< where regions overlap, the highest counts
  Material material;  ///< numbers that the region does not give are those of the body
  SourceLocation where;
};

/// Prony series of the stress of the shear modulus (docs/theory.md, Relaxation). Without terms nothing relaxes.
struct Relaxation {
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> terms{};  ///< rows of g and tau [s]
  double length_m = 0;  ///< of a model or body: the radius of its tool, 0 for node probes; scenes do not set it
  bool empty() const { return terms.rows() == 0; }
  /// "30 % in 2 s, 20 % in 20 s", or "none".
  std::string sentence() const;
};

struct SolverSpec {
  Element element = element_named("p1-p1");  ///< default of node probes; of patches es-p1-p1, of shells `shell`
  double relative_tolerance = 1e-8;          ///< |free residual| / |reactions|
  int max_iterations = 40;
  int max_cutbacks = 6;  ///< steps are halved down to 2^-max_cutbacks of an increment
};

enum class ProbeKind { node, patch };
/// What is stored for the points of the free surface that are not probed.
enum class Elsewhere { linear, none };
enum class Directions { three, fourteen, twenty_six, ninety_eight, hemisphere };

struct ProbeSpec {
  ProbeKind kind = ProbeKind::node;
  bool kind_given = false;                  ///< false: the scene does not name a kind
  double tool_radius_m = 0;                 ///< patch only
  int tools = 1;                            ///< at the same time; of more than one, `run` also makes a reduced body
  Elsewhere elsewhere = Elsewhere::linear;  ///< patch only
  Directions directions = Directions::twenty_six;
  int increments = 6;
  double max_displacement_m = 0;
  double max_force_N = 0;  ///< rays end at a larger force; 0: no limit
  /// Rays end at a smaller J. The default is reasoned in docs/decisions/ends-of-rays.md.
  double min_jacobian = 0.03;
  bool stop_at_fold = true;
  SourceLocation where;
};

struct DatabaseSpec {
  bool tangents = false;       ///< store the condensed 3x3 tangent of every increment
  bool float64 = false;        ///< displacements as float64 instead of float32
  double field_tolerance = 0;  ///< to which displacements are rounded, as a share of the prescribed one; 0: not at all
  std::vector<Field> fields;   ///< stored in addition to the displacement, each once, in the order of the enum
};

struct TrainingSpec {
  Family family = Family::modal;
  int deformation_neurons = 200;
  int force_neurons = 60;
  double deformation_spread = 0.75;  ///< in scaled inputs; <= 0: search
  double force_spread = 0;           ///< in scaled inputs; <= 0: search
  int samples = 5000;                ///< training points per deformation network
  double target_mse = 0;             ///< of scaled outputs; 0: grow to the largest number of neurons
  int force_centers = 80;            ///< modal: centers of each node's conservative force network
  int amplitude_centers = 80;        ///< modal: centers of the amplitudes, shared by all nodes
  int modes = 16;                    ///< modal: modes of each node's deformation
  int shared_modes = 64;             ///< modal: shared modes, from which the modes of all nodes are mixed
  int near_nodes = 24;               ///< modal: nodes near the touched one with modes of their own
  int levels = 1;                    ///< number of levels, each half as large as the next
  std::uint64_t seed = 1;
};

struct ValidationSpec {
  std::optional<int> probes, calibration_rays;  ///< empty: sizes_of_checks() of validation
  std::uint64_t seed = 1;
  std::optional<int> check_probes;  ///< of run; 0: no check
};

struct Scene {
  std::string title;
  MeshSpec mesh;
  Material material;
  std::vector<Region> regions;
  Relaxation relaxation;  ///< changes no solve
  SolverSpec solver;
  Selection fixed, active = Selection(1), output = Selection(1);  ///< a default selector is the free surface
  SourceLocation fixed_where, active_where, output_where;
  ProbeSpec probe;
  DatabaseSpec database;
  TrainingSpec training;
  ValidationSpec validation;
  std::string text;         ///< the file, verbatim
  std::string source_name;  ///< file name in messages
};

/// @throws Error (input) "file:line: what: value, remedy" on unknown keys, wrong types, missing or impossible values
Scene read_scene(const std::filesystem::path& file);
/// Whether a mesh file that the scene names must exist. A database stores its mesh together with its scene.
enum class MeshFile { must_exist, may_be_absent };
/// @param folder  folder of relative mesh paths
Scene parse_scene(const std::string& text, const std::string& source_name, const std::filesystem::path& folder,
                  MeshFile mesh_file = MeshFile::must_exist);

/// The scene text of imported responses, which has no body and no material: title, [probe], [training].
/// @throws Error (input) as parse_scene()
Scene parse_imported_scene(const std::string& text, const std::string& source_name);

/// [training] of a scene with other values of some keys, which are checked as in a scene.
/// @param keys  TOML of the section, without its name
/// @throws Error (input), as parse_scene()
TrainingSpec changed_training(Scene scene, const std::string& keys, const std::string& source_name);

/// The material of the body, then those of its regions.
std::vector<const Material*> materials(const Scene& scene);
/// The largest ratio of shear moduli of two materials of a scene between which elements were measured (docs/theory.md).
inline constexpr double largest_measured_ratio = 1000;

/// Notes about the meaning of important defaults, one sentence each, with file and line.
std::vector<std::string> scene_notes(const Scene& scene);

/// All keys of the parser as "section.key"; keys of selectors as "selector.key" and "selector.box.key".
std::vector<std::string> scene_keys();
/// The tables of keys in formats/scene.md, each between the comments that mark it there.
std::string scene_key_tables();

/// Hash (16 hexadecimal digits) of all keys that affect a solve: material, regions, element, tolerances, selections,
/// probe and mesh specification. Training, validation, title, comments and layout of the file have no effect on it.
std::string physics_hash(const Scene& scene);
/// The hashed text: every such key with its value, one "key = value" per line, for the comparison of two scenes.
std::string physics_summary(const Scene& scene);
/// The values of the other keys, one "key = value" per line.
std::string other_settings(const Scene& scene);

const char* name(Shape);
const char* name(ProbeKind);
const char* name(Directions);
const char* name(Elsewhere);
const char* name(Family);

/// The exploratory directions of a kind as unit vectors, in the order of formats/database.md. `hemisphere` has the 26
/// directions; a node's inward normal determines which of them are solved.
std::vector<Vec3> exploratory_directions(Directions kind);

}  // namespace phynness
