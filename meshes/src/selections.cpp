#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/formats/tool.hpp>
#include <phynness/meshes/meshes.hpp>
#include <sstream>

#include "mirror.hpp"

namespace phynness {
namespace {

using Nodes = std::vector<std::int32_t>;
using Vector = Eigen::RowVector3d;

// Relative to the bounding box's diagonal: a node that lies on a box's face up to rounding is in the box.
constexpr double on_the_border = 1e-9;

std::string at(const SourceLocation& where) { return where.file.empty() ? "" : where.str() + ": "; }

std::string text(const Vec3& v) {
  std::ostringstream out;
  out << '(' << v[0] << ", " << v[1] << ", " << v[2] << ')';
  return out.str();
}

void sort_unique(Nodes& nodes) {
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

std::string first_of(const Nodes& nodes) {
  std::string list;
  for (std::size_t i = 0; i < std::min<std::size_t>(nodes.size(), 5); ++i)
    list += (i ? ", " : "") + std::to_string(nodes[i]);
  return list + (nodes.size() > 5 ? ", ..." : "");
}

class Resolver {
 public:
  explicit Resolver(const Mesh& mesh)
      : _mesh(mesh),
        _surface(surface_nodes(mesh.surface)),
        _low(mesh.nodes.colwise().minCoeff()),
        _high(mesh.nodes.colwise().maxCoeff()),
        _slack(on_the_border * (_high - _low).norm()) {}

  /// Call before any selection that speaks of free nodes.
  void set_fixed(Nodes fixed) { _fixed = std::move(fixed); }

  Nodes resolve(const Selection& selection, const char* what, const SourceLocation& where) const {
    Nodes all;
    for (const Selector& selector : selection) {
      const Nodes nodes = selected(selector, what);
      if (nodes.empty())
        throw input_error(at(selector.where.file.empty() ? where : selector.where) + "a selector of the " +
                              what + " nodes selects no node",
                          describe(selector),
                          "the mesh reaches from " + text({_low(0), _low(1), _low(2)}) + " to " +
                              text({_high(0), _high(1), _high(2)}) + " m: widen the selector");
      all.insert(all.end(), nodes.begin(), nodes.end());
    }
    if (all.empty())
      throw input_error(at(where) + "there are no " + what + " nodes", "the selection is empty",
                        std::string("add a selector to ") + what);
    sort_unique(all);
    return all;
  }

 private:
  Vector position(const Vec3& p, const Selector& selector) const {
    const Vector x(p[0], p[1], p[2]);
    return selector.fraction ? Vector(_low + x.cwiseProduct(_high - _low)) : x;
  }

  template <class Inside>
  Nodes where(Inside inside) const {
    Nodes nodes;
    for (std::int32_t i = 0; i < _mesh.n_nodes(); ++i)
      if (inside(Vector(_mesh.nodes.row(i)))) nodes.push_back(i);
    return nodes;
  }

  Nodes without_fixed(const Nodes& nodes) const {
    Nodes free;
    std::set_difference(nodes.begin(), nodes.end(), _fixed.begin(), _fixed.end(), std::back_inserter(free));
    return free;
  }

  Nodes nearest(const Vector& x, bool surface_only) const {
    double best = std::numeric_limits<double>::infinity();
    Nodes nodes;
    const auto offer = [&](std::int32_t i) {
      if (const double d = (Vector(_mesh.nodes.row(i)) - x).squaredNorm(); d < best) best = d, nodes = {i};
    };
    if (surface_only)
      for (const std::int32_t i : _surface) offer(i);
    else
      for (std::int32_t i = 0; i < _mesh.n_nodes(); ++i) offer(i);
    return nodes;
  }

  Nodes group(const Selector& selector, const char* what) const {
    if (const auto found = _mesh.groups.find(selector.group); found != _mesh.groups.end())
      return found->second;
    std::string names;
    for (const auto& [name, nodes] : _mesh.groups) names += (names.empty() ? "'" : ", '") + name + "'";
    throw input_error(at(selector.where) + "the mesh has no physical group for the " + what + " nodes",
                      selector.group,
                      names.empty() ? "the mesh has no groups at all: select by box, sphere or plane"
                                    : "groups of the mesh: " + names);
  }

  Nodes listed(const Selector& selector, const char* what) const {
    for (const std::int32_t node : selector.nodes)
      if (node < 0 || node >= _mesh.n_nodes())
        throw input_error(at(selector.where) + "a node number of the " + what + " nodes is out of range",
                          std::to_string(node),
                          "the mesh has nodes 0 to " + std::to_string(_mesh.n_nodes() - 1));
    return selector.nodes;
  }

  Vector unit_normal(const Selector& selector) const {
    const Vector n(selector.b[0], selector.b[1], selector.b[2]);
    if (!(n.norm() > 0))
      throw input_error(at(selector.where) + "a plane's normal is zero", text(selector.b),
                        "give a direction");
    return n.normalized();
  }

  Nodes selected(const Selector& selector, const char* what) const {
    using Kind = Selector::Kind;
    const Vector a = position(selector.a, selector);
    Nodes nodes;
    switch (selector.kind) {
      case Kind::box: {
        const Vector b = position(selector.b, selector), low = a.cwiseMin(b), high = a.cwiseMax(b);
        nodes = where([&](const Vector& x) {
          return ((x - low).array() >= -_slack).all() && ((high - x).array() >= -_slack).all();
        });
        break;
      }
      case Kind::sphere:
        nodes = where([&](const Vector& x) { return (x - a).norm() <= selector.radius_m + _slack; });
        break;
      case Kind::plane: {
        const Vector n = unit_normal(selector);
        nodes =
            where([&](const Vector& x) { return std::abs((x - a).dot(n)) <= selector.radius_m + _slack; });
        break;
      }
      case Kind::half_space: {
        const Vector n = unit_normal(selector);
        nodes = where([&](const Vector& x) { return (x - a).dot(n) <= _slack; });
        break;
      }
      case Kind::group:
        nodes = group(selector, what);
        break;
      case Kind::nodes:
        nodes = listed(selector, what);
        break;
      case Kind::nearest:
        nodes = nearest(a, selector.surface_only);
        break;
      case Kind::surface:
        nodes = _surface;
        break;
      case Kind::free_surface:
        nodes = without_fixed(_surface);
        break;
      case Kind::free_nodes:
        nodes = without_fixed(where([](const Vector&) { return true; }));
        break;
      case Kind::all:
        nodes = where([](const Vector&) { return true; });
        break;
    }
    sort_unique(nodes);
    if (!selector.surface_only) return nodes;
    Nodes on_surface;
    std::set_intersection(nodes.begin(), nodes.end(), _surface.begin(), _surface.end(),
                          std::back_inserter(on_surface));
    return on_surface;
  }

  std::string describe(const Selector& selector) const {
    using Kind = Selector::Kind;
    const std::string units = selector.fraction ? " (fractions of the bounding box)" : " m";
    const std::string radius = std::to_string(selector.radius_m) + " m";
    std::string what;
    switch (selector.kind) {
      case Kind::box:
        what = "box " + text(selector.a) + " to " + text(selector.b) + units;
        break;
      case Kind::sphere:
        what = "sphere at " + text(selector.a) + units + ", radius " + radius;
        break;
      case Kind::plane:
        what = "plane through " + text(selector.a) + units + ", normal " + text(selector.b) + ", tolerance " +
               radius;
        break;
      case Kind::half_space:
        what = "half space below " + text(selector.a) + units + ", normal " + text(selector.b);
        break;
      case Kind::group:
        what = "group '" + selector.group + "'";
        break;
      case Kind::nodes:
        what = "a list of " + std::to_string(selector.nodes.size()) + " nodes";
        break;
      case Kind::nearest:
        what = "node nearest to " + text(selector.a) + units;
        break;
      case Kind::surface:
        what = "surface";
        break;
      case Kind::free_surface:
        what = "\"free-surface\"";
        break;
      case Kind::free_nodes:
        what = "\"free\"";
        break;
      case Kind::all:
        what = "all";
        break;
    }
    return what + (selector.surface_only ? ", surface nodes only" : "");
  }

  const Mesh& _mesh;
  Nodes _surface, _fixed;
  Vector _low, _high;
  double _slack;
};

}  // namespace

NodeSets resolve_selections(const Scene& scene, const Mesh& mesh) {
  if (mesh.nodes.rows() == 0)
    throw input_error("cannot select nodes: the mesh is empty", "", "give a mesh with cells");
  for (const Selector& selector : scene.fixed)
    if (selector.kind == Selector::Kind::free_surface || selector.kind == Selector::Kind::free_nodes)
      throw input_error(at(selector.where) + "the fixed nodes are selected by what is not fixed",
                        "\"free-surface\" or \"free\"", "use \"surface\" or a box");
  Resolver resolver(mesh);
  NodeSets sets;
  sets.fixed = resolver.resolve(scene.fixed, "fixed", scene.fixed_where);
  resolver.set_fixed(sets.fixed);
  if (!hold_the_body(mesh, sets.fixed))
    throw input_error(at(scene.fixed_where) + "the fixed nodes do not hold the body: it can still turn",
                      std::to_string(sets.fixed.size()) + " nodes: " + first_of(sets.fixed),
                      "fix at least three nodes that are not on one line");
  sets.active = resolver.resolve(scene.active, "active", scene.active_where);
  sets.output = resolver.resolve(scene.output, "output", scene.output_where);
  Nodes both;
  std::set_intersection(sets.fixed.begin(), sets.fixed.end(), sets.active.begin(), sets.active.end(),
                        std::back_inserter(both));
  if (!both.empty())
    throw input_error(at(scene.active_where) + "active nodes that are also fixed cannot be displaced",
                      std::to_string(both.size()) + " nodes: " + first_of(both),
                      "use \"free-surface\", or move the selections apart");
  const auto surface = surface_nodes(mesh.surface);
  Nodes inside;
  std::set_difference(sets.active.begin(), sets.active.end(), surface.begin(), surface.end(),
                      std::back_inserter(inside));
  if (!inside.empty())
    throw input_error(at(scene.active_where) + "active nodes inside the body cannot be touched",
                      std::to_string(inside.size()) + " nodes: " + first_of(inside),
                      "add surface_only = true to the selector, or use \"free-surface\"");
  if (scene.mesh.symmetry) sets.mirror = meshes::find_mirror(scene, mesh, sets);
  return sets;
}

}  // namespace phynness
