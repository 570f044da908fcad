#include "gmsh_session.hpp"

#include <gmsh.h>

#include <algorithm>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <unordered_map>

#include "element_types.hpp"

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

}  // namespace

GmshSession::GmshSession() {
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

GmshSession::~GmshSession() {
  try {
    gmsh::logger::stop();
    gmsh::finalize();
  } catch (...) {  // the results were copied before, so that nothing is lost
  }
}

void GmshSession::run(const std::string& what, const std::function<void()>& work) const {
  std::string reason;
  try {
    work();
    reason = last_logged_error();
    if (reason.empty()) return;
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

RawMesh GmshSession::tetrahedra() const { return elements(gmsh_tetrahedron, "tetrahedra"); }
RawMesh GmshSession::triangles() const { return elements(gmsh_triangle, "triangles"); }

RawMesh GmshSession::elements(int type, const char* what) const {
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
  for (std::size_t e = 0; type == gmsh_triangle && e + 2 < element_nodes.size(); e += 3)
    raw.triangles.push_back(
        {position.at(element_nodes[e]), position.at(element_nodes[e + 1]), position.at(element_nodes[e + 2])});
  for (std::size_t e = 0; type == gmsh_tetrahedron && e + 3 < element_nodes.size(); e += 4)
    raw.tetrahedra.push_back({position.at(element_nodes[e]), position.at(element_nodes[e + 1]),
                              position.at(element_nodes[e + 2]), position.at(element_nodes[e + 3])});
  if (raw.tetrahedra.empty() && raw.triangles.empty())
    throw failure(std::string("gmsh did not make ") + what, last_logged_error(), remedy);
  return raw;
}

}  // namespace phynness::meshes
