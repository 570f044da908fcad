// A scene: what is simulated, how it is probed, what is made of it. Key by key in formats/scene.md.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
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

/// A plane in which the scene says the body is its own mirror image.
struct SymmetryPlane {
  Vec3 point{0.5, 0.5, 0.5};  ///< a point of the plane
  bool fraction = true;       ///< `point` is in fractions of the bounding box, not metres
  Vec3 normal{};              ///< unit
  double tolerance_m = 0;     ///< how far an image may lie from its node; 0: a millionth of the body's diagonal
  bool half = false;          ///< the file holds one half; the other is made by mirroring
  SourceLocation where;
};

/// Exactly one of `shape` and `file` is given.
struct MeshSpec {
  Shape shape = Shape::none;
  std::filesystem::path file;           ///< absolute, resolved against the scene file's folder
  double scale_to_m = 1.0;              ///< file units -> m
  std::optional<int> target_nodes;      ///< built-in shapes: wanted number of nodes ...
  std::optional<double> target_size_m;  ///< ... or edge length; surfaces (.stl, .obj): edge length to fill with
  Vec3 size_m{0, 0, 0};                 ///< block: edges; liver: bounding box; 0 = the shape's default
  double radius_m = 0, inner_radius_m = 0, length_m = 0;  ///< cylinder, tube, drain
  double slit_length_m = 0, slit_width_m = 0;             ///< drain
  double thickness_m = 0;                                 ///< of the shell whose middle surface the mesh is; 0: a solid
  bool repair = false;                    ///< allow named repairs (flip cells, keep the largest component, ...)
  std::optional<SymmetryPlane> symmetry;  ///< only one half of the active nodes is solved
  SourceLocation where;
};

/// Whatever set of numbers the scene gave: the law's parameters, in the order of its row, and the moduli at rest.
struct Material : Moduli {
  Law law = law_named("neo-hookean");
  std::vector<double> parameters;
  SourceLocation where;
  double bulk_to_shear() const { return bulk_modulus_Pa / shear_modulus_Pa; }
};
/// The material of one of the sets of keys that the law accepts.
/// @throws Error (input) if the keys are none of these sets. Ranges are the parser's matter.
Material material_of(Law law, const std::vector<std::pair<std::string_view, double>>& given);

struct SolverSpec {
  Element element = element_named("p1-p1");  ///< of a scene that names none: `shell` where the mesh has a thickness
  bool element_given = false;                ///< false: the scene does not name an element
  double relative_tolerance = 1e-8;          ///< |free residual| / |reactions|
  int max_iterations = 40;
  int max_cutbacks = 6;  ///< an increment is cut to at most 2^-max_cutbacks of its length
};

enum class ProbeKind { node, patch };
enum class Directions { three, fourteen, twenty_six, ninety_eight, hemisphere };

struct ProbeSpec {
  ProbeKind kind = ProbeKind::node;
  bool kind_given = false;   ///< false: the scene does not name a kind
  double tool_radius_m = 0;  ///< patch only
  Directions directions = Directions::twenty_six;
  int increments = 6;
  double max_displacement_m = 0;
  SourceLocation where;
};

struct DatabaseSpec {
  bool tangents = false;      ///< store the condensed 3x3 tangent of every increment
  bool float64 = false;       ///< displacements as float64 instead of float32
  std::vector<Field> fields;  ///< stored beside the displacement, each once, in the order of the enum
};

struct TrainingSpec {
  Family family = Family::modal;
  int deformation_neurons = 200;
  int force_neurons = 60;
  double deformation_spread = 0.75;  ///< in scaled inputs; <= 0: search
  double force_spread = 0;           ///< in scaled inputs; <= 0: search
  int samples = 5000;                ///< training points per deformation network
  double target_mse = 0;             ///< of scaled outputs; 0: grow to the maximum
  int force_centers = 80;            ///< modal: of each node's conservative force network
  int amplitude_centers = 80;        ///< modal: of the amplitudes, shared by all nodes
  int modes = 16;                    ///< modal: of each node's deformation
  int shared_modes = 64;             ///< modal: that all nodes' modes are mixed from
  int near_nodes = 24;               ///< modal: nodes where a node's modes are stored as they are
  int levels = 1;                    ///< networks that the model holds, each half as large as the next
  std::uint64_t seed = 1;
};

struct ValidationSpec {
  int probes = 200;
  std::uint64_t seed = 1;
};

struct Scene {
  std::string title;
  MeshSpec mesh;
  Material material;
  SolverSpec solver;
  Selection fixed, active, output;
  SourceLocation fixed_where, active_where, output_where;
  ProbeSpec probe;
  DatabaseSpec database;
  TrainingSpec training;
  ValidationSpec validation;
  std::string text;         ///< the file, verbatim
  std::string source_name;  ///< file name for messages
};

/// @throws Error (input) "file:line: what: value, remedy" on unknown keys, wrong types, missing or impossible values
Scene read_scene(const std::filesystem::path& file);
/// Whether a mesh file that the scene names must be there. A scene kept in a database has its mesh beside it.
enum class MeshFile { must_exist, may_be_absent };
/// @param folder         where relative mesh paths start
/// @param solid_element  what a scene means that names no element and whose mesh has no thickness
Scene parse_scene(const std::string& text, const std::string& source_name, const std::filesystem::path& folder,
                  MeshFile mesh_file = MeshFile::must_exist, Element solid_element = SolverSpec{}.element);

/// What is allowed but deserves a word before hours are spent on it, one sentence each with file and line.
std::vector<std::string> scene_warnings(const Scene& scene);
/// What a default means, where that is worth a word: one sentence each with file and line.
std::vector<std::string> scene_notes(const Scene& scene);

/// Every key the parser knows as "section.key"; the keys of selectors as "selector.key" and "selector.box.key".
std::vector<std::string> scene_keys();

/// Hash (16 hexadecimal digits) of everything that decides a solve: material, element, tolerances, selections,
/// probe and mesh specification; not training, validation, title, comments or layout of the file.
std::string physics_hash(const Scene& scene);
/// The same, one "key = value" per line, so that two scenes can be compared by a person.
std::string physics_summary(const Scene& scene);

const char* name(Shape);
const char* name(ProbeKind);
const char* name(Directions);
const char* name(Family);

/// The exploratory directions of a kind, unit vectors, in the fixed order of formats/database.md
/// (`hemisphere` has the 26; which of them are solved depends on the node's inward normal).
std::vector<Vec3> exploratory_directions(Directions kind);

}  // namespace phynness
