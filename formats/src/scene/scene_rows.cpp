// The keys of a scene, a row each: name, member, allowed values, whether it is hashed, meaning. The default is that of
// the member.
#include <limits>

#include "scene_values.hpp"

namespace phynness {
namespace {

constexpr ShapeRow every_shape[] = {{Shape::liver, "liver", 739, {0.20, 0.14, 0.05}, 0, 0, 0, 0, 0, 0},
                                    {Shape::block, "block", 739, {0.10, 0.10, 0.05}, 0, 0, 0, 0, 0, 0},
                                    {Shape::cylinder, "cylinder", 739, {}, 0.03, 0, 0.10, 0, 0, 0},
                                    {Shape::tube, "tube", 739, {}, 0.01, 0.75, 0.10, 0, 0, 0},
                                    // Nodes and size of the drain in the paper, about half an inch.
                                    {Shape::drain, "drain", 239, {}, 0.00635, 0, 0.038, 0.5, 0.004, 0.0005}};

}  // namespace

std::span<const ShapeRow> shapes() { return every_shape; }
const ShapeRow& row(Shape shape) { return every_shape[static_cast<std::size_t>(shape) - 1]; }

const char* name(Shape shape) { return shape == Shape::none ? "none" : row(shape).name; }
const char* name(ProbeKind kind) { return kind == ProbeKind::node ? "node" : "patch"; }
const char* name(Elsewhere elsewhere) { return elsewhere == Elsewhere::linear ? "linear" : "none"; }
const char* name(Family family) { return schema::word(family); }

namespace scene_detail {
namespace {

constexpr bool hashed = true, not_hashed = false;

/// The values of an enum from `first` to before `end`.
template <class Enum>
OneOf<Enum> words_from(std::size_t first, std::size_t end) {
  OneOf<Enum> word{{}, phynness::name};
  for (; first < end; ++first) word.values.push_back(static_cast<Enum>(first));
  return word;
}
OneOf<Element> element_words() {
  OneOf<Element> word{{}, phynness::name};
  for (const auto& element : elements()) word.values.push_back(&element);
  return word;
}

// Inputs are scaled to [-1, 1]. Far smaller spreads separate all points, far larger ones separate none.
constexpr NumberOrSearch spread{{{1e-3, 1e3}}};
constexpr Integer seed{0, std::numeric_limits<std::int64_t>::max()}, many{1, 100'000};

using Keys = std::vector<SceneKey>;
constexpr auto whole_scene = [](auto& scene) -> decltype(auto) { return (scene); };

Keys mesh_keys() {
  const auto mesh = section("mesh", &Scene::mesh);
  return {
      mesh("shape", &MeshSpec::shape, words_from<Shape>(1, std::size(every_shape) + 1), hashed,
           "a built-in body; the drain is the middle surface of a slit tube, a shell"),
      mesh("file", &MeshSpec::file, Text{}, hashed,
           "path of a file of a mesh, see below; a relative one starts at the scene file's folder"),
      mesh("scale_to_m", &MeshSpec::scale_to_m, Number{{0, 1e6, true}}, hashed,
           "file units to metres (0.001 for a file in mm). The body must be 1e-9 to 1e9 m long. Files only"),
      mesh("repair", &MeshSpec::repair, Flag{}, hashed,
           "allow repairs of a file's mesh; each repair is reported. Files only"),
      mesh("remesh", &MeshSpec::remesh, Flag{}, hashed,
           "make new tetrahedra within the surface of a file of tetrahedra, of the target size below; without one the "
           "surface's triangles remain. Not with `group`, `nodes` or `thickness_m`"),
      mesh("size_m", &MeshSpec::size_m, ThreeNumbers{shape_length}, hashed,
           "edges of a block, bounding box of the liver, in m"),
      mesh("radius_m", &MeshSpec::radius_m, Number{shape_length}, hashed,
           "outer radius of cylinder and tube, or radius of a drain's middle surface, in m"),
      mesh("inner_radius_m", &MeshSpec::inner_radius_m, Number{shape_length}, hashed,
           "less than `radius_m`; tube only, in m"),
      mesh("length_m", &MeshSpec::length_m, Number{shape_length}, hashed, "length of cylinder, tube and drain, in m"),
      mesh("slit_length_m", &MeshSpec::slit_length_m, Number{shape_length}, hashed,
           "of the ellipse cut out of a drain's upper wall (y > 0), in the middle; at most 0.9 of `length_m`"),
      mesh("slit_width_m", &MeshSpec::slit_width_m, Number{shape_length}, hashed,
           "of that ellipse; at most `radius_m` and `slit_length_m`"),
      mesh("thickness_m", &MeshSpec::thickness_m, Number{length}, hashed,
           "makes the mesh the middle surface of a shell of this thickness. The mesh consists of triangles, open or "
           "closed. For the drain, or for a file of triangles, which are used as they are. Must be less than the "
           "length of the surface, and at least 1e-12 of it. Beyond half the radius of a bend it gives a warning; "
           "where the inner face meets itself it is refused"),
      mesh("target_nodes", &MeshSpec::target_nodes, Integer{8, 5'000'000}, hashed,
           "approximate number of nodes of a built-in shape, whose default is below, or of the tetrahedra that fill a "
           "surface file, without a default; excludes `target_size_m`"),
      mesh("target_size_m", &MeshSpec::target_size_m, Number{shape_length}, hashed,
           "wanted edge length in m on the surface of a built-in shape, or of a surface file that is filled; edges "
           "inside are about 1.4 times as long; excludes `target_nodes`")};
}

/// Material, solver and nodes.
Keys equilibrium_keys() {
  const Section material{"material", whole_scene}, nodes{"nodes", whole_scene};
  const auto solver = section("solver", &Scene::solver);
  return {
      material("law", &Scene::material, LawAndNumbers{}, hashed, "required"),
      material("relaxation", &Scene::relaxation, PronySeries{}, not_hashed, ""),

      solver(
          "element", &SolverSpec::element, element_words(), hashed,
          "`\"taylor-hood\"` has P2 displacement and P1 pressure, `\"p1-p1\"` displacement and pressure on linear "
          "tetrahedra, stabilized, and `\"es-p1-p1\"` the same unknowns with the shear energy as a function of strains "
          "averaged over the cells at each edge, which is the default of patches. Where `[mesh]` has a thickness, "
          "`\"shell\"` is the default and the only choice"),
      solver("relative_tolerance", &SolverSpec::relative_tolerance, Number{{1e-14, 1e-2}}, hashed,
             "norm of the free residual over that of the reactions"),
      solver("max_iterations", &SolverSpec::max_iterations, Integer{1, 1000}, hashed,
             "Newton and quasi-Newton iterations of one step before it is halved"),
      solver("max_cutbacks", &SolverSpec::max_cutbacks, Integer{0, 30}, hashed,
             "the shortest step is 2^-n of an increment"),

      nodes("fixed", &Scene::fixed, Nodes{}, hashed,
            "required: nodes that do not move. Without them the body could move as a rigid body"),
      nodes("active", &Scene::active, Nodes{}, hashed, "nodes that a tool may touch; each is probed"),
      nodes("output", &Scene::output, Nodes{}, hashed, "nodes whose displacement is stored and modelled")};
}

/// The numbers of a region's material are keys of the laws.
Keys region_keys() {
  const Section region{"region", [](auto& scene) -> decltype(auto) { return (scene.regions.back()); }};
  return {region("name", &Region::name, Text{}, not_hashed, "required; in messages and reports"),
          region("cells", &Region::cells, CellsOfRegion{}, hashed,
                 "required: a selector of places, by the centroids of cells; `group`, by a group of the mesh file's "
                 "cells; or `near`, cells within `distance_m` of selected nodes"),
          region("order", &Region::order, Integer{-1000, 1000}, hashed,
                 "where regions overlap, the one with the highest order counts; equal orders are refused")};
}

Keys probe_keys() {
  const auto probe = section("probe", &Scene::probe);
  return {
      probe("kind", &ProbeSpec::kind, words_from<ProbeKind>(0, 2), hashed,
            "`\"node\"`: one vertex is displaced, as in the paper. Its force has no limit under mesh refinement; a "
            "note says so if the key is absent. `\"patch\"`: a round tool of `tool_radius_m` moves the mean "
            "displacement of the surface under it by an even pressure "
            "([theory](../docs/theory.md#what-a-probe-is)). Its force has a limit"),
      probe("tool_radius_m", &ProbeSpec::tool_radius_m, Number{shape_length}, hashed,
            "in m; required for `\"patch\"`, refused for `\"node\"`"),
      probe("tools", &ProbeSpec::tools, Integer{1, 8}, not_hashed,
            "how many round tools touch the body at the same time. From 2 on `phynness run` also makes `body.txt`, a "
            "[reduced body](body.md), which needs element `\"p1-p1\"` or `\"es-p1-p1\"`, and `\"free\"` in "
            "`nodes.output`"),
      probe(
          "elsewhere", &ProbeSpec::elsewhere, words_from<Elsewhere>(0, 2), not_hashed,
          "of the free surface that is not probed: `\"linear\"` stores the linear response at rest for points with the "
          "spacing of `nodes.active`, or a third of the radius if it has none, so that points of `count` have linear "
          "ones between them; `\"none\"` stores nothing. Patch only"),
      probe("directions", &ProbeSpec::directions, DirectionSet{}, hashed,
            "`26`: axes and diagonals; `14`: axes and space diagonals only; `98`: the 26 and the middles between "
            "neighbors; `3`: +x, +y, +z; `\"hemisphere\"`: those of the 26 that push in or slide"),
      probe("increments", &ProbeSpec::increments, Integer{1, most_increments}, hashed,
            "number of steps to the full depth"),
      probe("max_displacement_m", &ProbeSpec::max_displacement_m, Number{{0, 10, true}}, hashed,
            "required, in m; `max_displacement_m / increments` is at least 1e-12 of the diagonal of the body, below "
            "which double precision holds no force"),
      probe("max_force_N", &ProbeSpec::max_force_N, Number{{0, 1e9, true}}, hashed,
            "in N. The first increment with a larger force is the last one of its ray. Absent: no limit. Give the "
            "largest force of the device"),
      probe("min_jacobian", &ProbeSpec::min_jacobian, Number{{0, 0.9}}, hashed,
            "a ray ends before the first increment in which a quadrature point keeps less than this share of its "
            "volume. The linear law has no such end"),
      probe("stop_at_fold", &ProbeSpec::stop_at_fold, Flag{}, hashed,
            "a ray ends before the first increment that loses energy at once. `false`: the fold is recorded, and the "
            "ray goes on")};
}

Keys database_keys() {
  const auto database = section("database", &Scene::database);
  const OneOf<bool> precisions{{false, true}, [](bool float64) { return float64 ? "float64" : "float32"; }};
  return {
      database("tangents", &DatabaseSpec::tangents, Flag{}, not_hashed,
               "store the condensed 3x3 tangent dF/dd of every increment"),
      database("displacement_precision", &DatabaseSpec::float64, precisions, not_hashed, ""),
      database("field_tolerance", &DatabaseSpec::field_tolerance, Number{{0, 0.1}}, not_hashed,
               "displacements of output nodes are rounded by at most this share of the prescribed one, so that they "
               "take less space on disk; 0 keeps every bit"),
      database("fields", &DatabaseSpec::fields, FieldNames{}, not_hashed,
               "scalar fields stored beside the displacement of the output nodes: `\"von-mises-stress\"` (of the "
               "Cauchy stress, in Pa), `\"energy-density\"` (stored strain energy per volume at rest, in J/m^3)")};
}

Keys training_keys() {
  const auto training = section("training", &Scene::training);
  return {
      training("family", &TrainingSpec::family, words_from<Family>(0, schema::n_families), not_hashed,
               "`\"modal\"` has conservative forces and modes, for any law; `\"rbfn\"` the paper's networks, for any "
               "law; `\"linear\"` three unit responses, for `law = \"linear\"` only: the other keys of this section do "
               "nothing"),
      training("deformation_neurons", &TrainingSpec::deformation_neurons, many, not_hashed,
               "most neurons of a deformation network"),
      training("force_neurons", &TrainingSpec::force_neurons, many, not_hashed, "most neurons of a force network"),
      training("deformation_spread", &TrainingSpec::deformation_spread, spread, not_hashed,
               "width of the Gaussians in scaled inputs"),
      training("force_spread", &TrainingSpec::force_spread, spread, not_hashed, "the same for the force"),
      training("samples", &TrainingSpec::samples, Integer{1, 10'000'000}, not_hashed,
               "training points of a deformation network"),
      training("target_mse", &TrainingSpec::target_mse, Number{{0, 1}}, not_hashed,
               "a network stops growing below this mean squared error of scaled outputs; 0 lets it grow to its largest "
               "number of neurons"),
      training("force_centers", &TrainingSpec::force_centers, many, not_hashed,
               "modal: most centers of a force network"),
      training("amplitude_centers", &TrainingSpec::amplitude_centers, Integer{0, 100'000}, not_hashed,
               "modal: most centers of the amplitudes, the same for all nodes"),
      training("modes", &TrainingSpec::modes, Integer{0, 1024}, not_hashed,
               "modal: modes of each node's deformation; 0: forces only"),
      training("shared_modes", &TrainingSpec::shared_modes, Integer{0, 1024}, not_hashed,
               "modal: modes of the whole body; the modes of each node are combinations of them"),
      training("near_nodes", &TrainingSpec::near_nodes, Integer{0, 1'000'000}, not_hashed,
               "modal: number of output nodes, for each touched node, at which its modes are stored directly; these "
               "are the nodes with the largest error of the shared modes, mostly around the touched node"),
      training("levels", &TrainingSpec::levels, Integer{1, 8}, not_hashed,
               "number of networks of different size that the model holds for each response. Each has half the "
               "neurons, or centers and modes, of the next larger one. A controller chooses between them "
               "(`phn_set_level`). The largest equals the model without levels"),
      training("seed", &TrainingSpec::seed, seed, not_hashed, "seed of all random choices in training")};
}

Keys validation_keys() {
  const auto validation = section("validation", &Scene::validation);
  return {
      validation("probes", &ValidationSpec::probes, Integer{1, 1'000'000}, not_hashed,
                 "number of fresh solves that the model is compared with. Absent: sized to the database, see below"),
      validation("calibration_rays", &ValidationSpec::calibration_rays, Integer{100, 1'000'000}, not_hashed,
                 "random rays for the bounds of the error ([calibrate](../docs/commands.md#calibrate)). Absent: "
                 "sized to the database, see below"),
      validation("seed", &ValidationSpec::seed, seed, not_hashed, "seed of their nodes, directions and depths"),
      validation("check_probes", &ValidationSpec::check_probes, Integer{0, 10'000}, not_hashed,
                 "probes at which `phynness run` compares the finite elements with a finer solution "
                 "([check](../docs/commands.md#check)); 0: none. Absent: at most 12, in the time that "
                 "`run` gives it")};
}

}  // namespace

const std::vector<SceneKey>& key_rows() {
  static const Keys rows = [] {
    Keys all{Section{"", whole_scene}("title", &Scene::title, Text{}, not_hashed, "free text")};
    for (const auto& section : {mesh_keys(), equilibrium_keys(), region_keys(), probe_keys(), database_keys(),
                                training_keys(), validation_keys()})
      all.insert(all.end(), section.begin(), section.end());
    return all;
  }();
  return rows;
}

}  // namespace scene_detail
}  // namespace phynness
