// Force balance of tools in contact: friction, sliding, release.
#include "contact/contact.hpp"
#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

constexpr int most_slides = 8, fewest_slides = 2;  // with one tool; with many tools or a body, whose slides cost more
constexpr double cone_tolerance = 1e-4;            ///< of the force
constexpr double longest_slide = 2;                ///< in displacements of the touched point
constexpr double same_place = 1e-4;                ///< tools closer than this, in sizes of the body, are at one point
constexpr int most_shortened = 3, most_pulling = 3;

/// Solves M x = b if -M has a positive trace and determinant. @return whether it has
bool solve_two(const double m[2][2], const double* b, double* x) {
  const double trace = m[0][0] + m[1][1], determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
  if (!(trace < 0 && determinant > 1e-3 * trace * trace / 4)) return false;
  x[0] = (b[0] * m[1][1] - b[1] * m[0][1]) / determinant;
  x[1] = (b[1] * m[0][0] - b[0] * m[1][0]) / determinant;
  return std::isfinite(x[0]) && std::isfinite(x[1]);
}

class Balance {
 public:
  Balance(phn_contact& contact, phn_data& data, std::int32_t n_tools, const ToolInput* inputs)
      : _contact(contact), _surface(contact.surface), _data(data), _n(n_tools), _inputs(inputs) {}

  int run(phn_coupled* result) {
    phn_coupled coupled = {0, 0};
    const int status = find(coupled);
    if (result != nullptr) *result = coupled;
    return status;
  }

 private:
  int find(phn_coupled& coupled) {
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      tool.active = tool.anchored;
      tool.excess = -1;
      tool.n_shortened = tool.n_pulling = 0;
      tool.unbalanced = 0;
      for (int k = 0; k < 3; ++k) tool.force[k] = tool.normal[k] = 0;
    }
    int warned = PHN_OK, status = PHN_OK, n_slides = most_slides;
    for (int step = 0;; ++step) {
      warned |= separate();
      status = couple(coupled);
      if (status < 0) return status;
      if (step == 0 && _n_active > 1) n_slides = most_slides / _n_active;
      if (n_slides < fewest_slides || has_body()) n_slides = fewest_slides;
      bool again = false;
      for (std::int32_t i = 0; i < _n_active; ++i) {
        if (_inputs[_active[i]].mode == PHN_TOOL_PRESS && step <= n_slides) again |= judge(i, step < n_slides);
      }
      if (!again) break;
    }
    for (std::int32_t t = 0; t < _n; ++t) _contact.tool[t].felt = false;
    for (std::int32_t i = 0; i < _n_active; ++i) finish(i);
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      if (tool.anchored && !tool.felt) let_go(tool);
      guard(tool, _inputs[t], coupled.energy);
      for (int k = 0; k < 3; ++k) tool.given[k] = tool.force[k];
    }
    return status | warned;
  }

  /// Scales the force so that the returned work does not exceed the work done. Work is the mean of two successive
  /// forces times the motion between them.
  void guard(ToolContact& tool, const ToolInput& input, double energy) {
    const bool guarded =
                   input.mode == PHN_TOOL_PRESS && _contact.guarded && (has_body() || has_energy(*_contact.model)),
               was_alone = tool.alone;
    const double so_far = tool.taken + dot(tool.given, tool.moved) / 2, now = dot(tool.force, tool.moved) / 2;
    tool.alone = guarded && _n_active == 1;
    if (!tool.felt) {
      tool.scale = 0;
      return;
    }
    if (!guarded || tool.scale == 0) {
      tool.scale = 1;
      tool.taken = energy;
    } else if (!tool.alone || !was_alone) {
      tool.taken = tool.scale * energy;
    } else {
      constexpr double least = 1e-12;  // positive, because 0 means no contact
      const bool covered = so_far + now >= energy;
      tool.scale = covered ? 1 : energy > now ? std::fmin(1.0, std::fmax(least, so_far / (energy - now))) : least;
      tool.taken = std::fmax(0.0, so_far + tool.scale * now);
    }
    for (double& f : tool.force) f *= tool.scale;
  }

  /// Sets the displacement that the tool prescribes at its point.
  void find_displacement(std::int32_t t) {
    ToolContact& tool = _contact.tool[t];
    const ToolInput& input = _inputs[t];
    double x[3];
    const bool grasps = input.mode == PHN_TOOL_GRASP;
    point_at(_surface, _surface.rest, tool.at, grasps ? 0 : input.radius, x);
    for (int k = 0; k < 3; ++k) tool.displacement[k] = input.center[k] - x[k] - (grasps ? tool.grip[k] : 0);
    normal_at(_surface, tool.at, tool.normal);
  }

  /// The only active node that moves the point; -1: there are several.
  std::int32_t only_node(const SurfacePoint& at) const {
    std::int32_t only = -1;
    for (int c = 0; c < 3; ++c) {
      const std::int32_t active = _surface.active[_surface.triangle[3 * at.triangle + c]];
      if (active < 0 || at.weight[c] == 0) continue;
      if (active == _contact.model->n_active || (only >= 0 && only != active)) return -1;
      only = active;
    }
    return only;
  }

  /// Of several tools at one point only one remains in the balance, because a field has one displacement there.
  int separate() {
    int warned = PHN_OK;
    for (std::int32_t t = 0; t < _n; ++t) {
      if (_contact.tool[t].active) find_displacement(t);
    }
    for (std::int32_t t = 0; t < _n; ++t) {
      for (std::int32_t s = 0; s < t; ++s) {
        ToolContact &a = _contact.tool[s], &b = _contact.tool[t];
        if (!a.active || !b.active) continue;
        double x[3], y[3], apart[3];
        point_at(_surface, _surface.rest, a.at, 0, x);
        point_at(_surface, _surface.rest, b.at, 0, y);
        subtract(x, y, apart);
        const std::int32_t node = only_node(a.at);
        if (norm(apart) > same_place * _surface.size && (node < 0 || node != only_node(b.at))) continue;
        const bool a_grasps = _inputs[s].mode == PHN_TOOL_GRASP, b_grasps = _inputs[t].mode == PHN_TOOL_GRASP;
        const bool a_stays = a_grasps != b_grasps
                                 ? a_grasps
                                 : a_grasps || dot(a.displacement, a.normal) <= dot(b.displacement, b.normal);
        (a_stays ? b : a).active = false;
        if (a_grasps && b_grasps) warned = PHN_WARNING_UNSETTLED;
      }
    }
    return warned;
  }

  int couple(phn_coupled& coupled) {
    phn_tool tools[most_coupled] = {};
    double forces[3 * most_coupled];
    _n_active = 0;
    for (std::int32_t t = 0; t < _n; ++t) {
      const ToolContact& tool = _contact.tool[t];
      if (!tool.active) continue;
      tools[_n_active] = held_by(_contact, tool);
      _active[_n_active++] = t;
    }
    const int status = phn_couple(_contact.model, &_data, _n_active, tools, forces, &coupled);
    for (std::int32_t i = 0; i < _n_active && status >= 0; ++i) {
      for (int k = 0; k < 3; ++k) _contact.tool[_active[i]].force[k] = forces[3 * i + k];
    }
    return status;
  }

  /// Splits the force into its normal component and the tangential rest. @return the component into the body
  static double split(const ToolContact& tool, double* tangential) {
    const double push = -dot(tool.force, tool.normal);
    for (int k = 0; k < 3; ++k) tangential[k] = tool.force[k] + push * tool.normal[k];
    return push;
  }

  /// @return whether the balance changes because the tool slides or is released
  bool judge(std::int32_t i, bool may_slide) {
    const std::int32_t t = _active[i];
    ToolContact& tool = _contact.tool[t];
    double tangential[3];
    const double push = split(tool, tangential), friction = _inputs[t].friction;
    const double sideways = norm(tangential), excess = sideways - (push > 0 ? friction * push : 0),
                 tolerance = cone_tolerance * norm(tool.force);
    if (push > 0 && excess <= tolerance) return false;
    if (push <= 0 && (sideways <= tolerance || tool.n_pulling >= most_pulling || !may_slide)) {
      tool.active = false;
      return true;
    }
    if (!may_slide) return false;
    tool.n_pulling += push <= 0;
    if (tool.excess >= 0 && excess > tool.excess && tool.n_shortened < most_shortened) {
      ++tool.n_shortened;
      for (double& s : tool.slide) s *= 0.3;
      tool.at = tool.before;
    } else {
      if (!find_slide(i, push, tangential, push > 0 ? friction : 0)) return false;
      tool.n_shortened = 0;
      tool.excess = excess;
      tool.before = tool.at;
    }
    walk(_surface, tool.at, tool.slide);
    return true;
  }

  /// Newton's step to the friction cone, with the stiffness of the point at rest, scaled to the present stiffness along
  /// the displacement.
  bool find_slide(std::int32_t i, double push, const double* tangential, double friction) {
    const std::int32_t t = _active[i];
    ToolContact& tool = _contact.tool[t];
    Matrix stiffness = stiffness_of(i);
    const Vector p = vector_at(tool.displacement);
    const double linear = dot(stiffness * p, p), scale = linear > 0 ? dot(tool.force, p.x) / linear : 1;
    stiffness *= std::fmin(8.0, std::fmax(0.25, scale));

    double axes[6], offset_gradient[9], normal_gradient[9];
    gradients_at(_surface, tool.at, axes, offset_gradient, normal_gradient);
    const double sideways = norm(tangential);
    // The second attempt uses a flat surface without friction. It is needed where the full matrix is not definite, as
    // where a tool slips off, and where no force pushes into the body.
    for (int attempt = push > 0 ? 0 : 1; attempt < 2; ++attempt) {
      const bool curved = attempt == 0;
      const double mu = curved ? friction : 0;
      double m[2][2], right[2], x[2];
      for (int j = 0; j < 2; ++j) {
        const double* axis = axes + 3 * j;
        Vector dp;
        double dn[3];
        for (int k = 0; k < 3; ++k) {
          dp[k] = -axis[k] - _inputs[t].radius * dot(offset_gradient + 3 * k, axis);
          dn[k] = curved ? dot(normal_gradient + 3 * k, axis) : 0;
        }
        const Vector df = stiffness * dp;
        const double dpush = -dot(df.x, tool.normal) - dot(tool.force, dn);
        for (int l = 0; l < 2; ++l) {
          m[l][j] = 0;
          for (int k = 0; k < 3; ++k) {
            const double change = df[k] + dpush * tool.normal[k] + push * dn[k];
            m[l][j] += axes[3 * l + k] * (change - (sideways > 0 ? mu * dpush * tangential[k] / sideways : 0));
          }
        }
        right[j] = -dot(axis, tangential) * (sideways > 0 ? 1 - friction * push / sideways : 0);
      }
      if (!solve_two(m, right, x)) continue;
      double slide[3];
      for (int k = 0; k < 3; ++k) slide[k] = x[0] * axes[k] + x[1] * axes[3 + k];
      const double size = norm(slide), longest = longest_slide * norm(p.x);
      if (!(size > 0)) return false;
      for (int k = 0; k < 3; ++k) tool.slide[k] = slide[k] * std::fmin(1.0, longest / size);
      return true;
    }
    return false;
  }

  bool has_body() const { return _data.coupling->attached.body != nullptr; }

  Matrix stiffness_of(std::int32_t i) const {
    const AttachedBody& attached = _data.coupling->attached;
    if (has_body()) return attached.stiffness(attached, i);
    const HeldPoint& point = _data.coupling->point[i];
    const phn_model& model = *_contact.model;
    if (_n_active > 1 || !answers_alone(model, point)) return point.stiffness;
    // phn_couple computes no coupling stiffness for a tool that it answers alone.
    const Mean mean = mean_at(model, {}, point);
    Matrix sum = {};
    for (std::int32_t n = 0; n < mean.n; ++n) {
      const Matrix stiffness = stiffness_at_rest(model, model.active[mean.active[n]]);
      for (int k = 0; k < 9; ++k) sum.a[k] += mean.weight[n] * stiffness.a[k] / (mean.lever * mean.lever);
    }
    return sum;
  }

  /// Projects the force onto the friction cone where sliding has not reached it.
  void finish(std::int32_t i) {
    const std::int32_t t = _active[i];
    ToolContact& tool = _contact.tool[t];
    tool.felt = true;
    if (_inputs[t].mode != PHN_TOOL_PRESS) return;
    double tangential[3], cut_off[3];
    const double push = split(tool, tangential), sideways = norm(tangential), allowed = _inputs[t].friction * push;
    tool.felt = push > 0;
    const double kept = !(push > 0) ? 0 : sideways <= allowed ? 1 : allowed / sideways;
    for (int k = 0; k < 3; ++k) {
      const double f = tool.felt ? kept * tangential[k] - push * tool.normal[k] : 0;
      cut_off[k] = tool.felt ? tool.force[k] - f : 0;
      tool.force[k] = f;
    }
    tool.unbalanced = norm(cut_off);
  }

  /// Ends the contact of a tool without a pushing force: it becomes free if it is outside; otherwise it is inside a
  /// surface that other tools have pushed away.
  void let_go(ToolContact& tool) {
    for (int k = 0; k < 3; ++k) tool.force[k] = 0;
    double from[3];
    SurfacePoint at;
    point_at(_surface, _surface.placed, tool.at, tool.radius, from);
    tool.anchored =
        sweep(_surface, _contact.volumes, tool.radius, from, tool.place, sweep_slack * _surface.size, at) >= 0;
  }

  phn_contact& _contact;
  const ContactSurface& _surface;
  phn_data& _data;
  std::int32_t _n, _n_active = 0;
  std::int32_t _active[most_coupled];
  const ToolInput* _inputs;
};

}  // namespace

phn_tool held_by(const phn_contact& contact, const ToolContact& tool) {
  phn_tool held;
  for (int c = 0; c < 3; ++c) {
    held.nodes[c] = contact.surface.node[contact.surface.triangle[3 * tool.at.triangle + c]];
    held.weights[c] = tool.at.weight[c];
    held.displacement[c] = tool.displacement[c];
  }
  return held;
}

int balance(phn_contact& contact, phn_data& data, std::int32_t n_tools, const ToolInput* inputs, phn_coupled* result) {
  return Balance(contact, data, n_tools, inputs).run(result);
}

}  // namespace PHN_RUNTIME
