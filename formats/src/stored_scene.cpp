#include <phynness/formats/database.hpp>

namespace phynness {

Scene stored_scene(const DatabaseHeader& header) {
  const auto parsed = [&](Element solid_element) {
    return parse_scene(header.scene_text, header.scene_name, header.scene_folder, MeshFile::may_be_absent,
                       solid_element);
  };
  // P1 was the default before p1-p1, and a patch was rigid before it was a mean.
  for (const auto element : {element_named("P1"), SolverSpec{}.element}) {
    Scene earlier = parsed(element);
    const bool patch = earlier.probe.kind == ProbeKind::patch;
    if (!earlier.solver.element_given && physics_hash(earlier) == header.physics_hash) return earlier;
    if (patch) earlier.probe.kind = ProbeKind::rigid_patch;
    if (patch && physics_hash(earlier) == header.physics_hash) return earlier;
  }
  return parsed(SolverSpec{}.element);
}

}  // namespace phynness
