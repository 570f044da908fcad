#include <phynness/training/families.hpp>
#include <phynness/tuning/tuning.hpp>

namespace phynness {

std::vector<Candidate> tuning_candidates(const Scene& scene) {
  std::vector<Candidate> candidates;
  for (const auto* family : every_family()) {
    if (schema::traits(family->family).proportional && !scene.material.law->linear) continue;
    for (const auto& spec : family->candidates(scene.training)) candidates.push_back({family->model_name(spec), spec});
  }
  return candidates;
}

}  // namespace phynness
