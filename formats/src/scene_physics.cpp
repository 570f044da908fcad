// The values of a scene's keys as text: those that affect a solve, which are hashed for databases and models, and the
// others.
#include <phynness/formats/hash.hpp>

#include "scene_keys.hpp"

namespace phynness {
namespace {

std::string line(const Scene& scene, const scene_detail::SceneKey& key) {
  return std::string(key.section).append(".").append(key.name).append(" = ").append(key.text(scene)).append("\n");
}

}  // namespace

std::string physics_summary(const Scene& scene) {
  std::string lines;
  for (const auto& key : scene_detail::key_rows()) {
    if (key.is_hashed && key.is_hashed(scene, key)) lines += line(scene, key);
    // The patches of older databases are rigid; their hash does not have this line.
    if (key.name == "tool_radius_m" && scene.probe.kind == ProbeKind::patch) lines += "probe.tool = mean\n";
  }
  return lines;
}

std::string other_settings(const Scene& scene) {
  std::string lines;
  for (const auto& key : scene_detail::key_rows())
    if (!key.is_hashed && !key.section.empty()) lines += line(scene, key);
  return lines;
}

std::string physics_hash(const Scene& scene) {
  Fnv1a64 hash;
  hash.add(physics_summary(scene));
  return hash.hex();
}

}  // namespace phynness
