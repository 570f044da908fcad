// Force balance of tools in contact: friction, sliding, release. The work that they get back is limited in guard.cpp.
#include "contact/contact.hpp"

#include "body/body.hpp"
#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

constexpr int most_slides = 8, fewest_slides = 2;  ///< of one tool; of many tools, whose slides cost more
constexpr double cone_tolerance = 1e-4;            ///< of the force
/// Longest slide in a step: on a model in displacements of the touched point; on a body in motions of the tool, and in
/// addition a part of the distance at which tools are near.
constexpr double longest_slide = 2, slide_of_near_tools = 0.02;
constexpr double coincidence_distance = 1e-4;  ///< Tools closer than this, in sizes of the body, are at one point.
/// A slide after which the cone is exceeded by more is cut so often, each time by this factor.
constexpr int most_cuts = 3;
constexpr double cut_factor = 0.3;
constexpr double largest_release_ratio = 3;      ///< of a surface that is released, over the displacement of the tool
constexpr int most_friction_iterations = 20;     ///< for the size of the friction along a slide
constexpr int most_projections = 3;              ///< responses in a step after projections of a proxy
constexpr int most_projection_steps = 12;        ///< of a projection
constexpr int most_gauss_seidel_sweeps = 60;     ///< over the tools on a body
constexpr double gauss_seidel_tolerance = 1e-6;  ///< of a force, and of a displacement
/// A step on a body makes one of Newton's steps more for each of these parts of the depth that a tool moves in it.
constexpr double motion_per_step = 0.05, most_motion_steps = 20;
/// It makes fewer if the next one, over the deformation, is smaller than this.
constexpr double balanced = 1e-4;
constexpr double jump = 0.05;  ///< of a force in a step, over the largest, from which on it is not settled

/// Solves M x = b if -M has a positive trace and determinant. @return whether it has
bool solve_2x2(const double m[2][2], const double* b, double* x) {
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
      tool.active = tool.has_proxy;
      tool.unbalanced = 0;
      tool.is_tensile = false;
      tool.force = tool.normal = {};
      tool.first_proxy = tool.proxy;
      start_slides(tool);
    }
    int warned = PHN_OK;
    const int status = _touched.is_body() ? balance_on_body(coupled) : balance_on_model(coupled, warned);
    if (status < 0) return status;
    for (std::int32_t t = 0; t < _n; ++t) _contact.tool[t].in_contact = false;
    for (std::int32_t i = 0; i < _n_active; ++i) clip_to_cone(i);
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      if (tool.has_proxy && !tool.in_contact) release(tool);
      tool.was_separated = tool.has_proxy && !tool.in_contact;
    }
    guard(_contact, _touched, _n, _inputs, coupled.energy);
    return status | warned;
  }

 private:
  /// Balance with the responses of a model. Each response is computed after slides by the forces of the one before.
  int balance_on_model(phn_coupled& coupled, int& warned) {
    for (int step = 0, n_slides = 0;; ++step) {
      warned |= remove_duplicates();
      const int status = solve_response(coupled);
      if (status < 0) return status;
      if (step == 0) n_slides = _n_active > 1 ? most_slides / _n_active : most_slides;
      if (n_slides < fewest_slides) n_slides = fewest_slides;
      bool again = false;
      for (std::int32_t i = 0; i < _n_active; ++i)
        again |= step <= n_slides && update_contact(_active[i], step < n_slides);
      if (!again) return status;
      if (!deactivate_shallowest()) continue;
      step = -1;
      // The others slid by forces that the released tool changed.
      for (std::int32_t t = 0; t < _n; ++t) {
        ToolContact& tool = _contact.tool[t];
        if (tool.active) tool.proxy = tool.first_proxy;
        start_slides(tool);
      }
    }
  }

  /// Deactivates one of the tools with a tensile force: the shallowest, because the deepest pushes without it.
  /// @return whether there was one
  bool deactivate_shallowest() {
    ToolContact* shallowest = nullptr;
    double least_depth = 0;
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      const double depth = -dot(tool.displacement, tool.normal);
      if (tool.active && tool.is_tensile && (shallowest == nullptr || depth < least_depth)) {
        shallowest = &tool;
        least_depth = depth;
      }
      tool.is_tensile = false;
    }
    if (shallowest != nullptr) shallowest->active = false;
    return shallowest != nullptr;
  }

  /// Balance with a body. A response costs steps of Newton's method, so that proxies slide by forces that are predicted
  /// from the last response: in each step the body moves and the tools slide by one and the same linearization. A tool
  /// that was in no response yet waits for the next one.
  int balance_on_body(phn_coupled& coupled) {
    double farthest = 0;
    for (std::int32_t t = 0; t < _n; ++t) {
      const ToolContact& tool = _contact.tool[t];
      if (!tool.active) continue;
      set_displacement(t);
      farthest = std::fmax(farthest, std::fmin(norm(tool.motion), norm(tool.displacement)));
    }
    _touched.steps += static_cast<std::int32_t>(
        std::fmin(farthest / (motion_per_step * _touched.max_displacement_m), most_motion_steps));
    for (int pass = 0;; ++pass) {
      const std::int32_t steps = _touched.steps;
      predict_forces();
      const int status = solve_response(coupled);
      if (status < 0) return status;
      _contact.has_response = _touched.unbalanced <= far_from_balance;
      bool again = _touched.unbalanced > balanced;
      for (std::int32_t i = 0; i < _n_active; ++i) {
        _contact.response_force[i] = _contact.tool[_active[i]].force;
        _contact.response_displacement[i] = _contact.tool[_active[i]].displacement;
      }
      for (std::int32_t t = 0; t < _n; ++t) {
        const ToolContact& tool = _contact.tool[t];
        const std::int32_t i = index_of(t);
        if (i < _n_active) continue;
        _contact.response_force[i] = {};
        _contact.response_displacement[i] = _touched.displacement(i);
        again |= tool.has_proxy && tool.is_new;
      }
      if (again && _touched.steps >= 1 && (pass == 0 || _touched.steps < steps)) continue;
      return status | (predict_forces() ? apply_prediction() : PHN_OK);
    }
  }

  /// Gives the tools the predicted forces, which the body has in the next step. The forces of the response may be far
  /// outside of the friction cone, because between near tools a slide of a micrometre changes them much.
  /// @return PHN_WARNING_UNSETTLED where a force jumps thereby, or PHN_OK
  int apply_prediction() {
    double largest = 0;
    int status = PHN_OK;
    for (std::int32_t i = 0; i < _contact.n_response; ++i) largest = std::fmax(largest, length(_predicted[i].x));
    _n_active = 0;
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      if (!is_in_response(t)) continue;
      const Vector force = _predicted[index_of(t)];
      tool.unbalanced = length((tool.force - force).x);
      if (std::fmin(tool.unbalanced, length((force - tool.last_force).x)) > jump * largest)
        status = PHN_WARNING_UNSETTLED;
      tool.force = force;
      if (tool.active) _active[_n_active++] = t;
    }
    return status;
  }

  /// Predicts forces and proxies of the tools of the last response by its linearization: projected Gauss-Seidel
  /// iterations over the tools (Jourdan, Alart and Jean 1998, doi 10.1016/S0045-7825(97)00137-0), after which proxies
  /// slide by the gaps that the forces do not close. Tools that do not push are not held in the next response.
  /// @return whether the forces are known; they are then in _predicted
  bool predict_forces() {
    Matrix blocks[most_touching * most_touching];
    Vector(&force)[most_touching] = _predicted, open_gap[most_touching];
    for (Vector& f : force) f = {};
    const MatrixView<Matrix> compliance{blocks, _contact.n_response};
    for (std::int32_t t = 0; t < _n; ++t)
      if (is_in_response(t)) force[index_of(t)] = _contact.response_force[index_of(t)];
    // The forces of a body that is far from equilibrium do not predict those of the next step.
    const bool is_known = _contact.has_response && _contact.n_response > 0 && _touched.compliance(compliance);
    bool slides = is_known;
    for (int pass = 0; pass < most_slides && slides; ++pass) {
      bool changes = true;
      for (int sweep = 0; sweep < most_gauss_seidel_sweeps && changes; ++sweep) {
        changes = false;
        for (std::int32_t t = 0; t < _n; ++t) {
          if (!is_in_response(t)) continue;
          const std::int32_t i = index_of(t);
          const Vector before = force[i];
          open_gap[i] = project_on_cone(t, compliance(i, i), gap(t, compliance, force), force[i]);
          changes |= length((force[i] - before).x) > gauss_seidel_tolerance * length(force[i].x);
        }
      }
      slides = false;
      for (std::int32_t t = 0; t < _n; ++t) {
        _contact.tool[t].is_at_edge = false;
        if (is_in_response(t) && _inputs[t].mode == PHN_TOOL_PRESS) slides |= slide_proxy(t, open_gap[index_of(t)]);
      }
    }
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      if (!tool.has_proxy) continue;
      const std::int32_t i = index_of(t);
      // A tool beyond an edge is released where only a tensile force could move the surface there.
      if (is_known && i >= 0 && tool.is_at_edge &&
          dot(force[i] + inverse_of(compliance(i, i)) * open_gap[i], tool.normal) >= 0)
        force[i] = {};
      const bool pushes = is_known ? i >= 0 && length(force[i].x) > 0 : i < _contact.n_held;
      tool.active = _inputs[t].mode == PHN_TOOL_GRASP || (i >= 0 && pushes);
    }
    return is_known;
  }

  bool is_in_response(std::int32_t t) const { return _contact.tool[t].has_proxy && index_of(t) >= 0; }
  /// Index of a tool in the last response; -1: it is not there.
  std::int32_t index_of(std::int32_t t) const { return _contact.tool[t].response_index - 1; }

  /// Vector from the proxy that the forces displace to its tool [m].
  Vector gap(std::int32_t t, const MatrixView<Matrix>& compliance, const Vector* force) const {
    const std::int32_t i = index_of(t);
    Vector gap = _contact.tool[t].displacement - _contact.response_displacement[i];
    for (std::int32_t s = 0; s < compliance.n_columns; ++s)
      gap -= compliance(i, s) * (force[s] - _contact.response_force[s]);
    return gap;
  }

  /// The force inside the friction cone that closes a gap as far as it can. On the surface of the cone, friction has
  /// the direction of the whole slide of this step (Coulomb's law). @return the rest of the gap
  Vector project_on_cone(std::int32_t t, const Matrix& compliance, const Vector& gap, Vector& force) const {
    const ToolContact& tool = _contact.tool[t];
    const Vector before = force, normal = tool.normal, free_gap = gap + compliance * before,
                 normal_response = compliance * normal;
    const double normal_compliance = dot(normal_response, normal),
                 frictionless_push = -dot(free_gap, normal) / normal_compliance, friction = _inputs[t].friction;
    force = {};
    if (_inputs[t].mode != PHN_TOOL_PRESS) {
      force = before + inverse_of(compliance) * gap;
    } else if (length((compliance * before).x) >
               largest_release_ratio * std::fmax(norm(tool.displacement), _touched.max_displacement_m)) {
      // The body is nearly unstable, so that forces without the tool are not known.
      const Vector stuck = before + inverse_of(compliance) * gap;
      const double push = std::fmax(-dot(stuck, normal), 0);
      const Vector along = stuck - dot(stuck, normal) * normal;
      force = std::fmin(1, friction * push / std::fmax(length(along.x), 1e-300)) * along - push * normal;
    } else if (normal_compliance > 0 && frictionless_push > 0) {
      // The friction f_t lets the point slide by s, where (S + s / |f_t|) f_t is the slide without friction, and S is
      // the compliance along the surface with a closed normal gap. The push is p_0 + c . f_t / c_nn, where p_0 is that
      // without friction, c is the response to the normal, and c_nn is its normal component.
      Vector slide = free_gap + frictionless_push * normal_response + _inputs[t].center - tool.displacement -
                     point_at(_surface, _surface.rest, tool.first_proxy, _inputs[t].radius);
      slide -= dot(slide, normal) * normal;
      const Matrix along = compliance - (1 / normal_compliance) * outer(normal_response, normal_response) +
                           normal_compliance * outer(normal, normal);
      double push = frictionless_push;
      const auto excess = [&](double part) {
        force = inverse_of(along + diagonal(normal_compliance * part / (1 - part))) * slide;
        push = frictionless_push + dot(normal_response, force) / normal_compliance;
        return length(force.x) - friction * push;
      };
      double low = 0, high = 1, at_low = friction > 0 ? excess(0) : 0, at_high = -friction * frictionless_push;
      bool was_outside = false;
      for (int i = 0; i < most_friction_iterations && at_low > 0; ++i) {
        const double middle = (low * at_high - high * at_low) / (at_high - at_low), here = excess(middle);
        if (std::fabs(here) <= gauss_seidel_tolerance * friction * frictionless_push) break;
        (here > 0 ? low : high) = middle;
        (here > 0 ? at_low : at_high) = here;
        if ((here > 0) == was_outside) (here > 0 ? at_high : at_low) /= 2;
        was_outside = here > 0;
      }
      force -= push * normal;
    }
    return gap - compliance * (force - before);
  }

  /// Slides the proxy along the surface so that the gap to its tool decreases by `gap`. @return whether it moved
  bool slide_proxy(std::int32_t t, const Vector& gap) {
    ToolContact& tool = _contact.tool[t];
    const Vector sideways = gap - dot(gap, tool.normal) * tool.normal;
    if (!(length(sideways.x) > gauss_seidel_tolerance * norm(tool.displacement))) return false;
    const SurfaceGradients gradients = gradients_at(_surface, tool.proxy);
    const Vector(&axes)[2] = gradients.axes;
    double m[2][2], right[2], x[2];
    for (int j = 0; j < 2; ++j) {
      const Vector response = -1 * axes[j] - _inputs[t].radius * (gradients.offset * axes[j]);
      for (int l = 0; l < 2; ++l) m[l][j] = dot(axes[l], response);
      right[j] = -dot(axes[j], sideways);
    }
    if (!solve_2x2(m, right, x))
      for (int j = 0; j < 2; ++j) x[j] = -right[j];
    // In one step a proxy slides little farther than its tool moves.
    const Vector here = point_at(_surface, _surface.rest, tool.proxy, 0),
                 earlier = here - point_at(_surface, _surface.rest, tool.first_proxy, 0);
    Vector total = earlier + (x[0] * axes[0] + x[1] * axes[1]);
    const double farthest = longest_slide * norm(tool.motion) + slide_of_near_tools * _touched.near_m;
    if (length(total.x) > farthest) total *= farthest / length(total.x);
    const Vector slide = total - earlier;
    walk(_surface, tool.proxy, slide);
    const Vector done = point_at(_surface, _surface.rest, tool.proxy, 0) - here;
    tool.is_at_edge = norm(slide) > gauss_seidel_tolerance * norm(tool.displacement) &&
                      length(done.x) < gauss_seidel_tolerance * norm(slide);
    set_displacement(t);
    return !tool.is_at_edge;
  }

  /// Sets the displacement that the tool prescribes at its point.
  void set_displacement(std::int32_t t) {
    ToolContact& tool = _contact.tool[t];
    const ToolInput& input = _inputs[t];
    const bool grasps = input.mode == PHN_TOOL_GRASP;
    tool.displacement = input.center - point_at(_surface, _surface.rest, tool.proxy, grasps ? 0 : input.radius);
    if (grasps) tool.displacement -= tool.grasp_offset;
    tool.normal = normal_at(_surface, tool.proxy);
  }

  /// Moves the proxy to the nearest local point of the offset surface to the tool's centre.
  /// @param moved  displacement of the surface there [m]
  void project_proxy(std::int32_t t, const Vector& moved) {
    ToolContact& tool = _contact.tool[t];
    if (_inputs[t].mode != PHN_TOOL_PRESS) return;
    double part = 1;
    for (int attempt = 0; attempt < most_projection_steps; ++attempt) {
      set_displacement(t);
      const Vector difference = tool.displacement - moved;
      const Vector step = difference - dot(difference, tool.normal) * tool.normal;
      if (norm(step) <= cone_tolerance * norm(difference)) return;
      const SurfacePoint before = tool.proxy;
      walk(_surface, tool.proxy, part * step);
      set_displacement(t);
      part = std::fmin(1, part / cut_factor);
      if (norm(tool.displacement - moved) < norm(difference)) continue;
      tool.proxy = before;
      part *= cut_factor * cut_factor;
    }
    set_displacement(t);
  }

  /// The only active node that moves the point; -1: there are several.
  std::int32_t only_node(const SurfacePoint& point) const {
    std::int32_t only = -1;
    for (int c = 0; c < 3; ++c) {
      const std::int32_t active = _surface.active[_surface.triangle[3 * point.triangle + c]];
      if (active < 0 || point.weight[c] == 0) continue;
      if (active == several || (only >= 0 && only != active)) return -1;
      only = active;
    }
    return only;
  }

  /// Keeps one of several tools at the same point, because a field has one displacement there. @return a warning
  int remove_duplicates() {
    int warned = PHN_OK;
    for (std::int32_t t = 0; t < _n; ++t)
      if (_contact.tool[t].active) set_displacement(t);
    for (std::int32_t t = 0; t < _n; ++t)
      for (std::int32_t s = 0; s < t; ++s) {
        ToolContact &a = _contact.tool[s], &b = _contact.tool[t];
        if (!a.active || !b.active) continue;
        const Vector difference =
            point_at(_surface, _surface.rest, a.proxy, 0) - point_at(_surface, _surface.rest, b.proxy, 0);
        const std::int32_t node = only_node(a.proxy);
        if (norm(difference) > coincidence_distance * _surface.size && (node < 0 || node != only_node(b.proxy)))
          continue;
        const bool a_grasps = _inputs[s].mode == PHN_TOOL_GRASP, b_grasps = _inputs[t].mode == PHN_TOOL_GRASP;
        const bool a_stays = a_grasps != b_grasps
                                 ? a_grasps
                                 : a_grasps || dot(a.displacement, a.normal) <= dot(b.displacement, b.normal);
        (a_stays ? b : a).active = false;
        if (a_grasps && b_grasps) warned = PHN_WARNING_UNSETTLED;
      }
    return warned;
  }

  int solve_response(phn_coupled& coupled) {
    phn_tool tools[most_touching] = {};
    double forces[3 * most_touching] = {}, heights[most_touching] = {};
    _n_active = 0;
    for (std::int32_t t = 0; t < _n; ++t) {
      const ToolContact& tool = _contact.tool[t];
      if (!tool.active) continue;
      tools[_n_active] = constraint_of(_contact, tool);
      _active[_n_active++] = t;
    }
    const std::int32_t n = _touched.is_body() ? append_other_tools(tools, heights) : _n_active;
    const int status = _touched.hold(_n_active, n, tools, heights, forces, coupled);
    for (std::int32_t i = 0; i < _n_active && status >= 0; ++i)
      _contact.tool[_active[i]].force = vector_at(forces + 3 * i);
    return status;
  }

  /// Appends the tools on a body that are not held, but have a proxy or are near to others. @return number of all tools
  std::int32_t append_other_tools(phn_tool* tools, double* heights) {
    std::int32_t n = _n_active;
    for (std::int32_t t = 0; t < _n; ++t) {
      ToolContact& tool = _contact.tool[t];
      tool.is_new = tool.response_index == 0;
      tool.response_index = 0;
      if (tool.active || _inputs[t].mode == PHN_TOOL_OFF) continue;
      if (tool.has_proxy) {
        tools[n] = constraint_of(_contact, tool);
      } else {
        ToolContact beside = {};
        const double height = nearest(_surface, _contact.volumes, tool.radius, tool.position.x, beside.proxy);
        if (_n_active == 0 || !(height < _touched.near_m) ||
            movable_weight(_surface, beside.proxy) < smallest_movable_weight<double>)
          continue;
        tools[n] = constraint_of(_contact, beside);
        heights[n] = height;
      }
      tool.response_index = ++n;
    }
    for (std::int32_t i = 0; i < _n_active; ++i) _contact.tool[_active[i]].response_index = i + 1;
    _contact.n_response = n;
    _contact.n_held = _n_active;
    return n;
  }

  /// Splits the force into its normal and its tangential part. @return the component into the body
  static double split_force(const ToolContact& tool, Vector& tangential) {
    const double push = -dot(tool.force, tool.normal);
    tangential = tool.force + push * tool.normal;
    return push;
  }

  static void start_slides(ToolContact& tool) {
    tool.cone_excess = -1;
    tool.n_cuts = tool.n_projections = 0;
  }

  /// Part of the tangential force outside of the friction cone [N].
  double cone_excess(std::int32_t t, double push, const Vector& tangential) const {
    return norm(tangential) - (push > 0 ? _inputs[t].friction * push : 0);
  }

  /// Displacement of the surface at the tool's proxy by the other tools alone, at most that of the deepest tool [m].
  Vector displacement_without(std::int32_t t) const {
    const ToolContact& tool = _contact.tool[t];
    double deepest = 0;
    for (std::int32_t s = 0; s < _n; ++s)
      if (s != t && _contact.tool[s].active) deepest = std::fmax(deepest, norm(_contact.tool[s].displacement));
    const Vector moved = tool.displacement - inverse_of(stiffness_of(t)) * tool.force;
    const double size = norm(moved);
    return size > deepest ? deepest / size * moved : moved;
  }

  /// Lets a tool slide, projects its proxy, or marks it as tensile. @return whether the balance changes thereby
  bool update_contact(std::int32_t t, bool may_slide) {
    ToolContact& tool = _contact.tool[t];
    if (_inputs[t].mode != PHN_TOOL_PRESS) return false;
    Vector tangential;
    const double push = split_force(tool, tangential), friction = _inputs[t].friction,
                 excess = cone_excess(t, push, tangential);
    if (push <= 0) {
      const bool may_project = may_slide && norm(tangential) > cone_tolerance * norm(tool.force);
      if (may_project && tool.n_projections < most_projections) project_proxy(t, displacement_without(t));
      tool.is_tensile = (tool.was_separated && _n_active > 1) || !may_project || tool.n_projections >= most_projections;
      tool.cone_excess = -1;
      tool.n_cuts = 0;
      ++tool.n_projections;
      return true;
    }
    if (!may_slide || excess <= cone_tolerance * norm(tool.force)) return false;
    if (tool.cone_excess >= 0 && excess > tool.cone_excess && tool.n_cuts < most_cuts) {
      ++tool.n_cuts;
      tool.slide *= cut_factor;
      tool.proxy = tool.last_proxy;
    } else {
      if (!find_slide(t, push, tangential, friction)) return false;
      tool.n_cuts = 0;
      tool.cone_excess = excess;
      tool.last_proxy = tool.proxy;
    }
    walk(_surface, tool.proxy, tool.slide);
    return true;
  }

  /// Sets the slide of Newton's step to the friction cone. The stiffness of a single tool on a model is that at rest,
  /// scaled to the present one along the displacement. @return whether there is a slide
  bool find_slide(std::int32_t t, double push, const Vector& tangential, double friction) {
    ToolContact& tool = _contact.tool[t];
    const Vector& p = tool.displacement;
    Matrix stiffness = stiffness_of(t);
    if (_n_active == 1) {
      const double linear = dot(stiffness * p, p), scale = linear > 0 ? dot(tool.force, p) / linear : 1;
      stiffness *= std::fmin(8.0, std::fmax(0.25, scale));
    }

    const SurfaceGradients gradients = gradients_at(_surface, tool.proxy);
    const Vector(&axes)[2] = gradients.axes;
    const double sideways = norm(tangential);
    // The second attempt uses a flat surface without friction. It is needed where the full matrix is not definite, for
    // example where a tool slips off.
    for (int attempt = 0; attempt < 2; ++attempt) {
      const bool curved = attempt == 0;
      const double mu = curved ? friction : 0;
      double m[2][2], right[2], x[2];
      for (int j = 0; j < 2; ++j) {
        const Vector dp = -1 * axes[j] - _inputs[t].radius * (gradients.offset * axes[j]);
        const Vector dn = curved ? gradients.normal * axes[j] : Vector{};
        const Vector df = stiffness * dp;
        const double dpush = -dot(df, tool.normal) - dot(tool.force, dn);
        Vector change = df + dpush * tool.normal + push * dn;
        if (sideways > 0) change -= mu * dpush * tangential / sideways;
        for (int l = 0; l < 2; ++l) m[l][j] = dot(axes[l], change);
        right[j] = -dot(axes[j], tangential) * (sideways > 0 ? 1 - friction * push / sideways : 0);
      }
      if (!solve_2x2(m, right, x)) continue;
      const Vector slide = x[0] * axes[0] + x[1] * axes[1];
      const double size = norm(slide);
      if (!(size > 0)) return false;
      tool.slide = std::fmin(1.0, longest_slide * norm(p) / size) * slide;
      return true;
    }
    return false;
  }

  /// Stiffness of a model at rest under a tool, where the other tools are held.
  Matrix stiffness_of(std::int32_t t) const {
    std::int32_t i = 0;
    while (_active[i] != t) ++i;
    return _touched.stiffness(i);
  }

  /// Reduces the tangential force to the friction cone where slides have not reached it.
  void clip_to_cone(std::int32_t i) {
    const std::int32_t t = _active[i];
    ToolContact& tool = _contact.tool[t];
    tool.in_contact = true;
    if (_inputs[t].mode != PHN_TOOL_PRESS) return;
    Vector tangential;
    const double push = split_force(tool, tangential), sideways = norm(tangential),
                 allowed = _inputs[t].friction * push;
    tool.in_contact = push > 0;
    if (!tool.in_contact) {
      tool.force = {};
      return;
    }
    const Vector force = (sideways <= allowed ? 1 : allowed / sideways) * tangential - push * tool.normal;
    tool.unbalanced += norm(tool.force - force);
    tool.force = force;
  }

  /// Ends the contact of a tool without a pushing force. It becomes free if it is outside; otherwise it is inside of a
  /// surface that other tools have pushed away.
  void release(ToolContact& tool) {
    SurfacePoint point;
    const Vector from = point_at(_surface, _surface.placed, tool.proxy, tool.radius);
    tool.force = {};
    tool.has_proxy = sweep(_surface, _contact.volumes, tool.radius, from.x, tool.position.x,
                           sweep_slack * _surface.size, point) >= 0;
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

phn_tool constraint_of(const phn_contact& contact, const ToolContact& tool) {
  phn_tool constraint;
  for (int c = 0; c < 3; ++c) {
    constraint.nodes[c] = contact.surface.node[contact.surface.triangle[3 * tool.proxy.triangle + c]];
    constraint.weights[c] = tool.proxy.weight[c];
    constraint.displacement[c] = tool.displacement[c];
  }
  return constraint;
}

int balance(phn_contact& contact, Touched& touched, std::int32_t n_tools, const ToolInput* inputs,
            phn_coupled& result) {
  return Balance(contact, touched, n_tools, inputs).find(result);
}

}  // namespace PHN_RUNTIME
