// Force balance of tools in contact: friction, sliding, release. The work that they get back is limited in guard.cpp.
#include "contact/contact.hpp"

#include "body/body.hpp"
#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

constexpr int most_slides = 8, fewest_slides = 2;  // with one tool; with many tools, whose slides cost more
constexpr double cone_tolerance = 1e-4;            ///< of the force
constexpr double longest_slide = 2;                ///< in displacements of the touched point; on a body in motions of
                                                   ///< the tool, and by itself in distances at which tools are near:
constexpr double slid_alone = 0.02;
constexpr double same_place = 1e-4;       ///< tools closer than this, in sizes of the body, are at one point
constexpr int most_shortened = 3;         ///< tries of a slide that worsens the excess
constexpr double shortening = 0.3;        ///< of each
constexpr double most_returned = 3;       ///< of the displacement, by the surface that is let go
constexpr int most_turns = 20;            ///< of the direction of friction, to the slide
constexpr int most_fallen = 3;            ///< responses in a step to the falls of a tool
constexpr int most_falls = 12;            ///< steps of a fall
constexpr int most_sweeps = 60;           ///< over the tools on a body, and when they end:
constexpr double sweep_tolerance = 1e-6;  ///< of a force, and of a displacement
/// A step on a body makes one more of Newton's steps for each of these parts of the depth that a tool goes in it, at
/// most:
constexpr double motion_of_step = 0.05, most_more = 20;
/// Or fewer, if the next one, over the deformation, is smaller than this.
constexpr double balanced = 1e-4;
constexpr double jump = 0.05;  ///< of a force in a step, over the largest, that is not settled

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
  Balance(phn_contact& contact, Touched& touched, std::int32_t n_tools, const ToolInput* inputs)
      : _contact(contact), _surface(contact.surface), _touched(touched), _n(n_tools), _inputs(inputs) {}

  int find(phn_coupled& coupled) {
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      tool.active = tool.anchored;
      tool.unbalanced = 0;
      tool.pulls = false;
      for (int k = 0; k < 3; ++k) tool.force[k] = tool.normal[k] = 0;
      tool.first = tool.at;
      start_slides(tool);
    }
    int warned = PHN_OK;
    const int status = _touched.is_body() ? press(coupled) : respond(coupled, warned);
    if (status < 0) return status;
    for (std::int32_t t = 0; t < _n; ++t) _contact.tool[t].felt = false;
    for (std::int32_t i = 0; i < _n_active; ++i) finish(i);
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      if (tool.anchored && !tool.felt) let_go(tool);
      tool.loose = tool.anchored && !tool.felt;
    }
    guard(_contact, _touched, _n, _inputs, coupled.energy);
    return status | warned;
  }

 private:
  /// Balance with the responses of a model, each of which is computed for proxies that slide by the one before.
  int respond(phn_coupled& coupled, int& warned) {
    for (int step = 0, n_slides = 0;; ++step) {
      warned |= separate();
      const int status = couple(coupled);
      if (status < 0) return status;
      if (step == 0) n_slides = _n_active > 1 ? most_slides / _n_active : most_slides;
      if (n_slides < fewest_slides) n_slides = fewest_slides;
      bool again = false;
      for (std::int32_t i = 0; i < _n_active; ++i) again |= step <= n_slides && judge(_active[i], step < n_slides);
      if (!again) return status;
      if (!release()) continue;
      step = -1;
      // The others slid by forces that the released tool changed.
      for (std::int32_t t = 0; t < _n; ++t) {
        ToolContact& tool = _contact.tool[t];
        if (tool.active) tool.at = tool.first;
        start_slides(tool);
      }
    }
  }

  /// Leaves out one of the tools that pull: the shallowest, as the deepest pushes without it. @return whether there was
  /// one
  bool release() {
    ToolContact* shallowest = nullptr;
    double depth = 0;
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      const double here = -dot(tool.displacement, tool.normal);
      if (tool.active && tool.pulls && (shallowest == nullptr || here < depth)) {
        shallowest = &tool;
        depth = here;
      }
      tool.pulls = false;
    }
    if (shallowest != nullptr) shallowest->active = false;
    return shallowest != nullptr;
  }

  /// Balance with a body. A response costs steps of Newton's method, so proxies slide by forces that are predicted from
  /// the last response: in each step the body moves and the tools slide by one and the same linearization. A tool that
  /// was not part of it yet waits for the next one.
  int press(phn_coupled& coupled) {
    double farthest = 0;
    for (std::int32_t t = 0; t < _n; ++t) {
      const ToolContact& tool = _contact.tool[t];
      if (!tool.active) continue;
      find_displacement(t);
      farthest = std::fmax(farthest, std::fmin(norm(tool.moved), norm(tool.displacement)));
    }
    _touched.steps +=
        static_cast<std::int32_t>(std::fmin(farthest / (motion_of_step * _touched.max_displacement_m), most_more));
    for (int pass = 0;; ++pass) {
      const std::int32_t steps = _touched.steps;
      predict();
      const int status = couple(coupled);
      if (status < 0) return status;
      _contact.is_known = _touched.unbalanced <= far_from_balance;
      bool again = _touched.unbalanced > balanced;
      for (std::int32_t i = 0; i < _n_active; ++i) {
        _contact.held_by[i] = vector_at(_contact.tool[_active[i]].force);
        _contact.held_at[i] = vector_at(_contact.tool[_active[i]].displacement);
      }
      for (std::int32_t t = 0; t < _n; ++t) {
        const ToolContact& tool = _contact.tool[t];
        if (tool.order <= _n_active) continue;
        _contact.held_by[tool.order - 1] = {};
        _contact.held_at[tool.order - 1] = _touched.displacement(tool.order - 1);
        again |= tool.anchored && tool.is_new;
      }
      if (again && _touched.steps >= 1 && (pass == 0 || _touched.steps < steps)) continue;
      return status | (predict() ? relieve() : PHN_OK);
    }
  }

  /// Gives the tools the forces of the last prediction, to which the body comes in the next step. Those of the response
  /// may be far outside of the cone: between near tools a slide of a micrometre is much force.
  /// @return PHN_WARNING_UNSETTLED where a force jumps by this, or PHN_OK
  int relieve() {
    double largest = 0;
    int status = PHN_OK;
    for (std::int32_t i = 0; i < _contact.n_before; ++i) largest = std::fmax(largest, length(_predicted[i].x));
    _n_active = 0;
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      if (!takes_part(t)) continue;
      const Vector given = _predicted[order(t)];
      tool.unbalanced = length((vector_at(tool.force) - given).x);
      if (std::fmin(tool.unbalanced, length((given - vector_at(tool.given)).x)) > jump * largest)
        status = PHN_WARNING_UNSETTLED;
      for (int k = 0; k < 3; ++k) tool.force[k] = given[k];
      if (tool.active) _active[_n_active++] = t;
    }
    return status;
  }

  /// Forces and places of the tools of the last response, by its linearization: projected Gauss-Seidel iterations over
  /// the tools (Jourdan, Alart and Jean 1998, doi 10.1016/S0045-7825(97)00137-0), after which proxies slide by what the
  /// forces leave of the distances to their tools. Tools that do not push are not held in the next response.
  /// @return whether the last response says something of the forces, which then are in _predicted
  bool predict() {
    Matrix compliance[most_touching * most_touching];
    Vector(&force)[most_touching] = _predicted, left[most_touching];
    for (Vector& f : force) f = {};
    const std::int32_t n = _contact.n_before;
    for (std::int32_t t = 0; t < _n; ++t) {
      if (takes_part(t)) force[order(t)] = _contact.held_by[order(t)];
    }
    // Forces of a body that is far from its equilibrium say nothing of those in the next step.
    const bool is_known = _contact.is_known && n > 0 && _touched.compliance(n, compliance);
    bool slides = is_known;
    for (int pass = 0; pass < most_slides && slides; ++pass) {
      bool changes = true;
      for (int sweep = 0; sweep < most_sweeps && changes; ++sweep) {
        changes = false;
        for (std::int32_t t = 0; t < _n; ++t) {
          if (!takes_part(t)) continue;
          const Vector before = force[order(t)];
          left[order(t)] = follow(t, compliance[n * order(t) + order(t)], gap(t, compliance, force), force[order(t)]);
          changes |= length((force[order(t)] - before).x) > sweep_tolerance * length(force[order(t)].x);
        }
      }
      slides = false;
      for (std::int32_t t = 0; t < _n; ++t) {
        _contact.tool[t].stopped = false;
        if (takes_part(t) && _inputs[t].mode == PHN_TOOL_PRESS) slides |= slide_by(t, left[order(t)]);
      }
    }
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      if (!tool.anchored) continue;
      // A tool beyond an edge is let go where the surface could follow it only if it pulled.
      if (is_known && takes_part(t) && tool.stopped &&
          dot(force[order(t)] + inverse_of(compliance[n * order(t) + order(t)]) * left[order(t)],
              vector_at(tool.normal)) >= 0)
        force[order(t)] = {};
      const bool pushes = is_known ? takes_part(t) && length(force[order(t)].x) > 0 : tool.order <= _contact.n_held;
      tool.active = _inputs[t].mode == PHN_TOOL_GRASP || (tool.order > 0 && pushes);
    }
    return is_known;
  }

  bool takes_part(std::int32_t t) const { return _contact.tool[t].anchored && _contact.tool[t].order > 0; }
  std::int32_t order(std::int32_t t) const { return _contact.tool[t].order - 1; }

  /// Distance of a tool from where forces put its proxy [m].
  Vector gap(std::int32_t t, const Matrix* compliance, const Vector* force) const {
    const std::int32_t n = _contact.n_before;
    Vector gap = vector_at(_contact.tool[t].displacement) - _contact.held_at[order(t)];
    for (std::int32_t s = 0; s < n; ++s) gap -= compliance[n * order(t) + s] * (force[s] - _contact.held_by[s]);
    return gap;
  }

  /// The force that closes a gap, inside the friction cone. Where it is on the cone, friction has the direction of the
  /// whole slide of this step (Coulomb's law). @return what it leaves of the gap
  Vector follow(std::int32_t t, const Matrix& compliance, const Vector& gap, Vector& force) const {
    const ToolContact& tool = _contact.tool[t];
    const Vector before = force, normal = vector_at(tool.normal), open = gap + compliance * before,
                 moved = compliance * normal;
    const double soft = dot(moved, normal), pushed = -dot(open, normal) / soft, friction = _inputs[t].friction;
    force = {};
    if (_inputs[t].mode != PHN_TOOL_PRESS) {
      force = before + inverse_of(compliance) * gap;
    } else if (length((compliance * before).x) >
               most_returned * std::fmax(norm(tool.displacement), _touched.max_displacement_m)) {
      // The body is nearly unstable, and its forces cannot be followed to zero.
      const Vector stuck = before + inverse_of(compliance) * gap;
      const double push = std::fmax(-dot(stuck, normal), 0);
      const Vector along = stuck - dot(stuck, normal) * normal;
      force = std::fmin(1, friction * push / std::fmax(length(along.x), 1e-300)) * along - push * normal;
    } else if (soft > 0 && pushed > 0) {
      // Friction f_t slides the point by s, and (S + s / f_t) f_t = what it slides without friction, where S is the
      // compliance along the surface with the normal gap closed. The push is pushed + moved . f_t / soft.
      double first[3];
      point_at(_surface, _surface.rest, tool.first, _inputs[t].radius, first);
      Vector slide =
          open + pushed * moved + vector_at(_inputs[t].center) - vector_at(tool.displacement) - vector_at(first);
      slide -= dot(slide, normal) * normal;
      const Matrix along = compliance - (1 / soft) * outer(moved, moved) + soft * outer(normal, normal);
      double push = pushed;
      const auto excess = [&](double part) {
        force = inverse_of(along + diagonal(soft * part / (1 - part))) * slide;
        push = pushed + dot(moved, force) / soft;
        return length(force.x) - friction * push;
      };
      double low = 0, high = 1, at_low = friction > 0 ? excess(0) : 0, at_high = -friction * pushed;
      bool was_over = false;
      for (int i = 0; i < most_turns && at_low > 0; ++i) {
        const double middle = (low * at_high - high * at_low) / (at_high - at_low), here = excess(middle);
        if (std::fabs(here) <= sweep_tolerance * friction * pushed) break;
        (here > 0 ? low : high) = middle;
        (here > 0 ? at_low : at_high) = here;
        if ((here > 0) == was_over) (here > 0 ? at_high : at_low) /= 2;
        was_over = here > 0;
      }
      force -= push * normal;
    }
    return gap - compliance * (force - before);
  }

  /// Moves the proxy so that it is `gap` nearer to its tool, along the surface. @return whether it went
  bool slide_by(std::int32_t t, const Vector& gap) {
    ToolContact& tool = _contact.tool[t];
    const Vector sideways = gap - dot(gap.x, tool.normal) * vector_at(tool.normal);
    if (!(length(sideways.x) > sweep_tolerance * norm(tool.displacement))) return false;
    double axes[6], offset_gradient[9], normal_gradient[9], m[2][2], right[2], x[2];
    gradients_at(_surface, tool.at, axes, offset_gradient, normal_gradient);
    for (int j = 0; j < 2; ++j) {
      Vector moved;
      for (int k = 0; k < 3; ++k)
        moved[k] = -axes[3 * j + k] - _inputs[t].radius * dot(offset_gradient + 3 * k, axes + 3 * j);
      for (int l = 0; l < 2; ++l) m[l][j] = dot(axes + 3 * l, moved.x);
      right[j] = -dot(axes + 3 * j, sideways.x);
    }
    if (!solve_two(m, right, x)) {
      for (int j = 0; j < 2; ++j) x[j] = -right[j];
    }
    // In one step a proxy goes no farther than its tool and a little.
    double from[3], here[3], slide[3];
    point_at(_surface, _surface.rest, tool.first, 0, from);
    point_at(_surface, _surface.rest, tool.at, 0, here);
    Vector gone = vector_at(here) - vector_at(from);
    const Vector so_far = gone;
    for (int k = 0; k < 3; ++k) gone[k] += x[0] * axes[k] + x[1] * axes[3 + k];
    const double farthest = longest_slide * norm(tool.moved) + slid_alone * _touched.near_m;
    if (length(gone.x) > farthest) gone *= farthest / length(gone.x);
    for (int k = 0; k < 3; ++k) slide[k] = gone[k] - so_far[k];
    walk(_surface, tool.at, slide);
    point_at(_surface, _surface.rest, tool.at, 0, from);
    tool.stopped = norm(slide) > sweep_tolerance * norm(tool.displacement) &&
                   length((vector_at(from) - vector_at(here)).x) < sweep_tolerance * norm(slide);
    find_displacement(t);
    return !tool.stopped;
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

  /// Moves the proxy downhill to the nearest point of the offset surface to the tool's centre. @param moved
  /// displacement that the surface has there [m]
  void fall(std::int32_t t, const double* moved) {
    ToolContact& tool = _contact.tool[t];
    if (_inputs[t].mode != PHN_TOOL_PRESS) return;
    double part = 1;
    for (int attempt = 0; attempt < most_falls; ++attempt) {
      double apart[3], step[3], closer[3];
      find_displacement(t);
      subtract(tool.displacement, moved, apart);
      const double out = dot(apart, tool.normal);
      for (int k = 0; k < 3; ++k) step[k] = apart[k] - out * tool.normal[k];
      if (norm(step) <= cone_tolerance * norm(apart)) return;
      const SurfacePoint before = tool.at;
      for (double& s : step) s *= part;
      walk(_surface, tool.at, step);
      find_displacement(t);
      subtract(tool.displacement, moved, closer);
      part = std::fmin(1, part / shortening);
      if (norm(closer) < norm(apart)) continue;
      tool.at = before;
      part *= shortening * shortening;
    }
    find_displacement(t);
  }

  /// The only active node that moves the point; -1: there are several.
  std::int32_t only_node(const SurfacePoint& at) const {
    std::int32_t only = -1;
    for (int c = 0; c < 3; ++c) {
      const std::int32_t active = _surface.active[_surface.triangle[3 * at.triangle + c]];
      if (active < 0 || at.weight[c] == 0) continue;
      if (active == several || (only >= 0 && only != active)) return -1;
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
    phn_tool tools[most_touching] = {};
    double forces[3 * most_touching] = {}, heights[most_touching] = {};
    _n_active = 0;
    for (std::int32_t t = 0; t < _n; ++t) {
      const ToolContact& tool = _contact.tool[t];
      if (!tool.active) continue;
      tools[_n_active] = held_by(_contact, tool);
      _active[_n_active++] = t;
    }
    const std::int32_t n = _touched.is_body() ? add_others(tools, heights) : _n_active;
    const int status = _touched.hold(_n_active, n, tools, heights, forces, coupled);
    for (std::int32_t i = 0; i < _n_active && status >= 0; ++i) {
      for (int k = 0; k < 3; ++k) _contact.tool[_active[i]].force[k] = forces[3 * i + k];
    }
    return status;
  }

  /// Tools on a body that are not held, but wait for a force or are near to others. @return number of tools with them
  std::int32_t add_others(phn_tool* tools, double* heights) {
    std::int32_t n = _n_active;
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      tool.is_new = tool.order == 0;
      tool.order = 0;
      if (tool.active || _inputs[t].mode == PHN_TOOL_OFF) continue;
      if (tool.anchored) {
        tools[n] = held_by(_contact, tool);
      } else {
        ToolContact beside = {};
        const double height = nearest(_surface, _contact.volumes, tool.radius, tool.place, beside.at);
        if (_n_active == 0 || !(height < _touched.near_m) || movable(_surface, beside.at) < least_movable<double>)
          continue;
        tools[n] = held_by(_contact, beside);
        heights[n] = height;
      }
      tool.order = ++n;
    }
    for (std::int32_t i = 0; i < _n_active; ++i) _contact.tool[_active[i]].order = i + 1;
    _contact.n_before = n;
    _contact.n_held = _n_active;
    return n;
  }

  /// Splits the force into its normal component and the tangential rest. @return the component into the body
  static double split(const ToolContact& tool, double* tangential) {
    const double push = -dot(tool.force, tool.normal);
    for (int k = 0; k < 3; ++k) tangential[k] = tool.force[k] + push * tool.normal[k];
    return push;
  }

  static void start_slides(ToolContact& tool) {
    tool.excess = -1;
    tool.n_shortened = tool.n_fallen = 0;
  }

  /// Force in excess of the friction cone [N].
  double excess_of(std::int32_t t, double push, const double* tangential) const {
    return norm(tangential) - (push > 0 ? _inputs[t].friction * push : 0);
  }

  /// Of the surface at the tool's point, by the other tools alone: at most that of the deepest of them [m].
  Vector displacement_without(std::int32_t t) const {
    const ToolContact& tool = _contact.tool[t];
    double deepest = 0;
    for (std::int32_t s = 0; s < _n; ++s) {
      if (s != t && _contact.tool[s].active) deepest = std::fmax(deepest, norm(_contact.tool[s].displacement));
    }
    const Vector moved = vector_at(tool.displacement) - inverse_of(stiffness_of(t)) * vector_at(tool.force);
    const double size = norm(moved.x);
    return size > deepest ? deepest / size * moved : moved;
  }

  /// @return whether the balance changes because the tool slides or is released
  bool judge(std::int32_t t, bool may_slide) {
    ToolContact& tool = _contact.tool[t];
    if (_inputs[t].mode != PHN_TOOL_PRESS) return false;
    double tangential[3];
    const double push = split(tool, tangential), friction = _inputs[t].friction,
                 excess = excess_of(t, push, tangential);
    if (push <= 0) {
      const bool may_fall = may_slide && norm(tangential) > cone_tolerance * norm(tool.force);
      if (may_fall && tool.n_fallen < most_fallen) fall(t, displacement_without(t).x);
      tool.pulls = (tool.loose && _n_active > 1) || !may_fall || tool.n_fallen >= most_fallen;
      tool.excess = -1;
      tool.n_shortened = 0;
      ++tool.n_fallen;
      return true;
    }
    if (!may_slide || excess <= cone_tolerance * norm(tool.force)) return false;
    if (tool.excess >= 0 && excess > tool.excess && tool.n_shortened < most_shortened) {
      ++tool.n_shortened;
      for (double& s : tool.slide) s *= shortening;
      tool.at = tool.before;
    } else {
      if (!find_slide(t, push, tangential, friction)) return false;
      tool.n_shortened = 0;
      tool.excess = excess;
      tool.before = tool.at;
    }
    walk(_surface, tool.at, tool.slide);
    return true;
  }

  /// Newton's step to the friction cone. The stiffness of the only tool on a model is that at rest, scaled to the
  /// present one along the displacement.
  bool find_slide(std::int32_t t, double push, const double* tangential, double friction) {
    ToolContact& tool = _contact.tool[t];
    const Vector p = vector_at(tool.displacement);
    Matrix stiffness = stiffness_of(t);
    if (_n_active == 1) {
      const double linear = dot(stiffness * p, p), scale = linear > 0 ? dot(tool.force, p.x) / linear : 1;
      stiffness *= std::fmin(8.0, std::fmax(0.25, scale));
    }

    double axes[6], offset_gradient[9], normal_gradient[9];
    gradients_at(_surface, tool.at, axes, offset_gradient, normal_gradient);
    const double sideways = norm(tangential);
    // The second attempt uses a flat surface without friction. It is needed where the full matrix is not definite, as
    // where a tool slips off.
    for (int attempt = 0; attempt < 2; ++attempt) {
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

  /// Of a model at rest, with the other tools held.
  Matrix stiffness_of(std::int32_t t) const {
    std::int32_t i = 0;
    while (_active[i] != t) ++i;
    return _touched.stiffness(i);
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
    tool.unbalanced += norm(cut_off);
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
  Touched& _touched;
  std::int32_t _n, _n_active = 0;
  std::int32_t _active[most_touching];
  Vector _predicted[most_touching];  ///< forces, of a body
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

int balance(phn_contact& contact, Touched& touched, std::int32_t n_tools, const ToolInput* inputs,
            phn_coupled& result) {
  return Balance(contact, touched, n_tools, inputs).find(result);
}

}  // namespace PHN_RUNTIME
