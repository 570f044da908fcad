#include <phynness/formats/database.hpp>

namespace phynness {

Scene stored_scene(const DatabaseHeader& header) {
  const auto parsed = [&](Element solid_element) {
    return parse_scene(header.scene_text, header.scene_name, header.scene_folder, MeshFile::may_be_absent,
                       solid_element);
  };
  // P1 was the default before p1-p1.
  Scene earlier = parsed(element_named("P1"));
  const bool solved_with_p1 = !earlier.solver.element_given && physics_hash(earlier) == header.physics_hash;
  return solved_with_p1 ? std::move(earlier) : parsed(SolverSpec{}.element);
}

}  // namespace phynness
