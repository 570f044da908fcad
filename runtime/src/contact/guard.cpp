// The guard of work (docs/decisions/contact.md, Energy).
#include <cmath>

#include "contact/contact.hpp"
#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// Part of the energy that must be covered by the work done. Of 1,930 moments of a sphere on a gallbladder 1,843 had
/// a scale below 0.9 with the whole energy, 787 with a half, 446 with a third, 333 with a fifth, all without a credit.
constexpr double energy_covered = 1.0 / 3;
/// Part of the depth whose energy is a credit: 1e-4 of the energy at full depth.
constexpr double shallow_part = 0.01;

}  // namespace

void guard(phn_contact& contact, const Touched& touched, std::int32_t n_tools, const ToolInput* inputs, double energy) {
  double work = contact.work, grasp_work = 0, press_work = 0, next_return = 0, deepest = 0;
  bool has_contact = false;
  for (std::int32_t t = 0; t < n_tools; ++t) {
    const ToolContact& tool = contact.tool[t];
    const double half_work = dot(tool.force, tool.motion) / 2;
    work += dot(tool.last_force, tool.motion) / 2;
    (inputs[t].mode == PHN_TOOL_PRESS ? press_work : grasp_work) += half_work;
    if (!tool.in_contact) continue;
    has_contact = true;
    next_return += norm(tool.force) * norm(tool.motion);
    deepest = std::fmax(deepest, norm(tool.displacement));
  }
  double& scale = contact.scale;
  if (!has_contact || !touched.has_energy || scale == 0) {
    scale = has_contact ? 1 : 0;
    contact.work = has_contact ? energy : 0;
  } else {
    constexpr double least = 1e-12;  // positive, because 0 means no contact
    const double shallow = shallow_part * touched.max_displacement_m / deepest,
                 credit = energy * std::fmin(1, shallow * shallow), available = work + grasp_work + credit,
                 required = std::fmin(energy, energy_covered * energy + next_return);
    scale = available + press_work >= required ? 1
            : required > press_work            ? std::fmin(1.0, std::fmax(least, available / (required - press_work)))
                                               : least;
    contact.work = std::fmax(-credit, work + grasp_work + scale * press_work);
  }
  for (std::int32_t t = 0; t < n_tools; ++t) {
    ToolContact& tool = contact.tool[t];
    tool.scale = tool.in_contact ? inputs[t].mode == PHN_TOOL_PRESS ? scale : 1 : 0;
    tool.last_force = tool.force *= tool.scale;
  }
}

}  // namespace PHN_RUNTIME
