// The keys of a scene that affect a solve, as readable text and as a hash for databases and models; names of the
// choices.
#include <phynness/formats/hash.hpp>
#include <phynness/formats/scene.hpp>

#include "selectors.hpp"

namespace phynness {
using scene_detail::exact_text;
using scene_detail::selection_text;
using scene_detail::shortest;

std::string physics_summary(const Scene& scene) {
  std::string lines;
  const auto add = [&](const std::string& key, const std::string& value) { lines += key + " = " + value + "\n"; };
  const MeshSpec& mesh = scene.mesh;
  if (mesh.shape == Shape::none) {
    // The folder is omitted, because the mesh hash identifies the content.
    add("mesh.file", mesh.file.filename().string());
    add("mesh.scale_to_m", shortest(mesh.scale_to_m));
    add("mesh.repair", mesh.repair ? "true" : "false");
  } else {
    add("mesh.shape", name(mesh.shape));
    add("mesh.size_m", exact_text(mesh.size_m));
    add("mesh.radius_m", shortest(mesh.radius_m));
    add("mesh.inner_radius_m", shortest(mesh.inner_radius_m));
    add("mesh.length_m", shortest(mesh.length_m));
  }
  if (mesh.shape == Shape::drain) {
    add("mesh.slit_length_m", shortest(mesh.slit_length_m));
    add("mesh.slit_width_m", shortest(mesh.slit_width_m));
  }
  if (mesh.thickness_m > 0) add("mesh.thickness_m", shortest(mesh.thickness_m));
  if (mesh.symmetry) {
    const auto& plane = *mesh.symmetry;
    add("mesh.symmetry", std::string("point") + (plane.fraction ? "_fraction" : "_m") + " = " +
                             exact_text(plane.point) + ", normal = " + exact_text(plane.normal) +
                             (plane.tolerance_m > 0 ? ", tolerance_m = " + shortest(plane.tolerance_m) : "") +
                             (plane.half ? ", half" : ""));
  }
  if (mesh.target_nodes) add("mesh.target_nodes", std::to_string(*mesh.target_nodes));
  if (mesh.target_size_m) add("mesh.target_size_m", shortest(*mesh.target_size_m));

  const Material& m = scene.material;
  add("material.law", name(m.law));
  for (std::size_t i = 0; i < m.parameters.size(); ++i)
    add(std::string("material.") + m.law->parameters[i].key, shortest(m.parameters[i]));

  add("solver.element", name(scene.solver.element));
  add("solver.relative_tolerance", shortest(scene.solver.relative_tolerance));
  add("solver.max_iterations", std::to_string(scene.solver.max_iterations));
  add("solver.max_cutbacks", std::to_string(scene.solver.max_cutbacks));

  add("nodes.fixed", selection_text(scene.fixed));
  add("nodes.active", selection_text(scene.active));
  add("nodes.output", selection_text(scene.output));

  add("probe.kind", name(scene.probe.kind));
  if (scene.probe.kind != ProbeKind::node) add("probe.tool_radius_m", shortest(scene.probe.tool_radius_m));
  if (scene.probe.kind == ProbeKind::patch) add("probe.tool", "mean");
  add("probe.directions", name(scene.probe.directions));
  add("probe.increments", std::to_string(scene.probe.increments));
  add("probe.max_displacement_m", shortest(scene.probe.max_displacement_m));
  // Only if they differ from the default, so that scenes keep the hash that they had before these keys existed.
  const ProbeSpec standard;
  if (scene.probe.max_force_N > 0) add("probe.max_force_N", shortest(scene.probe.max_force_N));
  if (scene.probe.min_jacobian != standard.min_jacobian) add("probe.min_jacobian", shortest(scene.probe.min_jacobian));
  if (!scene.probe.stop_at_fold) add("probe.stop_at_fold", "false");
  return lines;
}

std::string physics_hash(const Scene& scene) {
  Fnv1a64 hash;
  hash.add(physics_summary(scene));
  return hash.hex();
}

const char* name(Shape shape) {
  switch (shape) {
    case Shape::none:
      return "none";
    case Shape::liver:
      return "liver";
    case Shape::block:
      return "block";
    case Shape::cylinder:
      return "cylinder";
    case Shape::tube:
      return "tube";
    case Shape::drain:
      return "drain";
  }
  return "?";
}
const char* name(ProbeKind kind) { return kind == ProbeKind::node ? "node" : "patch"; }
const char* name(Directions directions) {
  switch (directions) {
    case Directions::three:
      return "3";
    case Directions::fourteen:
      return "14";
    case Directions::twenty_six:
      return "26";
    case Directions::ninety_eight:
      return "98";
    case Directions::hemisphere:
      return "hemisphere";
  }
  return "?";
}
const char* name(Family family) { return schema::word(family); }

}  // namespace phynness
