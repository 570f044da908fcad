#include "gmsh_module.hpp"

#include <gmsh.h>

#include <algorithm>
#include <functional>
#include <numbers>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <unordered_map>

namespace phynness::meshes {
namespace {

constexpr const char* remedy =
    "try another mesh.target_size_m or mesh.target_nodes; for a file, check it for triangles that "
    "intersect";

std::string last_logged_error() {
  std::vector<std::string> log;
  gmsh::logger::get(log);
  for (auto line = log.rbegin(); line != log.rend(); ++line)
    if (line->starts_with("Error")) return *line;
  return "";
}

/// gmsh with an empty model and one thread, without console output and without the user's option files. Only one object
/// may exist at a time, because gmsh has global state.
class GmshSession {
 public:
  GmshSession() {
    try {
      gmsh::initialize(0, nullptr, false);  // false: without ~/.gmshrc, so that all users get the same mesh
      gmsh::option::setNumber("General.Terminal", 0);
      gmsh::option::setNumber("General.NumThreads", 1);
      gmsh::option::setNumber("Mesh.RandomSeed", 1);
      gmsh::option::setNumber("Mesh.Algorithm", 6);  // frontal Delaunay triangles
      // Delaunay, the only one of the available algorithms that keeps given triangles.
      gmsh::option::setNumber("Mesh.Algorithm3D", 1);
      gmsh::option::setNumber("Mesh.ElementOrder", 1);
      gmsh::option::setNumber("Mesh.Optimize", 1);
      gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 1);
      gmsh::logger::start();
      gmsh::model::add("phynness");
    } catch (const std::exception& e) {
      throw failure("gmsh does not start", e.what(), "check the installation of libgmsh");
    }
  }
  ~GmshSession() {
    try {
      gmsh::logger::stop();
      gmsh::finalize();
    } catch (...) {  // the results were copied before, so that nothing is lost
    }
  }
  GmshSession(const GmshSession&) = delete;
  GmshSession& operator=(const GmshSession&) = delete;
};

/// The elements of the current model of this type, and their nodes in the order of gmsh's numbers.
RawMesh elements_of(int type, const char* what) {
  std::vector<std::size_t> tags, elements, element_nodes;
  std::vector<double> x, parametric;
  gmsh::model::mesh::getNodes(tags, x, parametric, -1, -1, false, false);
  gmsh::model::mesh::getElementsByType(type, elements, element_nodes);
  std::vector<std::size_t> order(tags.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t p, std::size_t q) { return tags[p] < tags[q]; });

  RawMesh raw;
  std::unordered_map<std::size_t, std::int32_t> position;
  for (const std::size_t i : order)
    if (position.emplace(tags[i], static_cast<std::int32_t>(raw.nodes.size())).second)
      raw.nodes.push_back({x[3 * i], x[3 * i + 1], x[3 * i + 2]});
  const auto node = [&](std::size_t i) { return position.at(element_nodes[i]); };
  for (std::size_t i = 0; type == gmsh_triangle && i + 2 < element_nodes.size(); i += 3)
    raw.triangles.push_back({node(i), node(i + 1), node(i + 2)});
  for (std::size_t i = 0; type == gmsh_tetrahedron && i + 3 < element_nodes.size(); i += 4)
    raw.tetrahedra.push_back({node(i), node(i + 1), node(i + 2), node(i + 3)});
  if (raw.tetrahedra.empty() && raw.triangles.empty())
    throw failure(std::string("gmsh did not make ") + what, last_logged_error(), remedy);
  return raw;
}

/// Calls `make` with an empty model. Any exception that it throws and any error that gmsh logs becomes a
/// phynness::Error.
RawMesh in_gmsh(const std::string& what, const std::function<RawMesh()>& make) {
  const GmshSession session;
  std::string reason;
  try {
    RawMesh raw = make();
    reason = last_logged_error();
    if (reason.empty()) return raw;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    reason = last_logged_error();
    if (reason.empty()) reason = e.what();
  } catch (...) {
    reason = last_logged_error();
  }
  if (reason.empty()) gmsh::logger::getLastError(reason);
  throw failure("gmsh cannot " + what, reason, remedy);
}

/// The given size determines the edges on faces and inside. Otherwise the integer number of pieces of each edge would
/// determine them, and the number of nodes would jump.
void generate_unit_edges(int dimension) {
  gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 0);
  gmsh::option::setNumber("Mesh.MeshSizeMin", 1);
  gmsh::option::setNumber("Mesh.MeshSizeMax", 1);
  gmsh::model::mesh::generate(dimension);
}

/// Adds a closed surface and its loop, both numbered `tag`. @param n_nodes, n_triangles  of those added before
void add_surface(const Surface& surface, int tag, std::size_t& n_nodes, std::size_t& n_triangles) {
  gmsh::model::addDiscreteEntity(2, tag);
  std::vector<std::size_t> tags(static_cast<std::size_t>(surface.nodes.rows()));
  std::iota(tags.begin(), tags.end(), n_nodes + 1);
  const std::vector<double> x(surface.nodes.data(), surface.nodes.data() + surface.nodes.size());
  gmsh::model::mesh::addNodes(2, tag, tags, x);
  std::vector<std::size_t> elements(static_cast<std::size_t>(surface.triangles.rows())), nodes;
  std::iota(elements.begin(), elements.end(), n_triangles + 1);
  for (Eigen::Index i = 0; i < surface.triangles.size(); ++i)
    nodes.push_back(n_nodes + static_cast<std::size_t>(surface.triangles.data()[i]) + 1);
  gmsh::model::mesh::addElementsByType(tag, 2, elements, nodes);
  gmsh::model::geo::addSurfaceLoop({tag}, tag);
  n_nodes += tags.size(), n_triangles += elements.size();
}

RawMesh fill_surface(const Surface& surface, const std::vector<Inclusion>& inclusions) {
  return in_gmsh("fill the surface with tetrahedra", [&] {
    std::size_t n_nodes = 0, n_triangles = 0;
    int tag = 1;
    std::vector<int> loops{tag};
    add_surface(surface, tag, n_nodes, n_triangles);
    for (const Inclusion& inclusion : inclusions) {
      loops.push_back(++tag);
      add_surface(inclusion.surface, tag, n_nodes, n_triangles);
    }
    gmsh::model::geo::addVolume(loops, 1);
    for (int inner = 2; inner <= tag; ++inner) gmsh::model::geo::addVolume({inner}, inner);
    gmsh::model::geo::synchronize();
    gmsh::model::mesh::generate(3);
    return elements_of(gmsh_tetrahedron, "tetrahedra");
  });
}

RawMesh solid(Shape shape, const Vec3& size, double inner_radius) {
  namespace occ = gmsh::model::occ;
  return in_gmsh("mesh the built-in shape", [&] {
    if (shape == Shape::block) {
      occ::addBox(0, 0, 0, size[0], size[1], size[2]);
    } else {
      const int outer = occ::addCylinder(0, 0, 0, 0, 0, size[2], size[0]);
      if (shape == Shape::tube) {
        const int hole = occ::addCylinder(0, 0, 0, 0, 0, size[2], inner_radius);
        gmsh::vectorpair result;
        std::vector<gmsh::vectorpair> map;
        occ::cut({{3, outer}}, {{3, hole}}, result, map);
      }
    }
    occ::synchronize();
    generate_unit_edges(3);
    return elements_of(gmsh_tetrahedron, "tetrahedra");
  });
}

RawMesh drain(const Drain& drain) {
  const double radius = drain.radius, length = drain.length;
  constexpr double quarter_turn = std::numbers::pi / 2;
  return in_gmsh("mesh the drain", [&] {
    namespace occ = gmsh::model::occ;
    const int circle = occ::addCircle(0, 0, 0, radius);
    gmsh::vectorpair walls;
    occ::extrude({{1, circle}}, 0, 0, length, walls);
    gmsh::vectorpair tube;
    for (const auto& entity : walls)
      if (entity.first == 2) tube.push_back(entity);
    // An ellipse with its long axis along the tube, extruded through the upper wall only.
    const gmsh::vectorpair disk{{2, occ::addDisk(0, 0, 0, drain.slit_length / 2, drain.slit_width / 2)}};
    occ::rotate(disk, 0, 0, 0, 0, 1, 0, quarter_turn);
    occ::rotate(disk, 0, 0, 0, 0, 0, 1, quarter_turn);
    occ::translate(disk, 0, 0, length / 2);
    gmsh::vectorpair cutter, bodies, left;
    occ::extrude(disk, 0, 2 * radius, 0, cutter);
    for (const auto& entity : cutter)
      if (entity.first == 3) bodies.push_back(entity);
    std::vector<gmsh::vectorpair> map;
    occ::cut(tube, bodies, left, map);
    occ::synchronize();
    generate_unit_edges(2);
    return elements_of(gmsh_triangle, "triangles");
  });
}

}  // namespace

const GmshModule phynness_gmsh{fill_surface, solid, drain};

}  // namespace phynness::meshes
