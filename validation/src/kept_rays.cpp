#include "kept_rays.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/validation/calibrate.hpp>
#include <sstream>

namespace phynness {
namespace {

namespace fs = std::filesystem;

/// A line is a ray, this, its forces, and a point; without the point a kill has cut it off.
constexpr const char* separator = " :";

template <class Numbers>
void put(std::string& text, const Numbers& numbers) {
  for (const auto number : numbers) text += fmt::format(" {}", number);  // the shortest text that gives the same bits
}

/// Where tools touch.
std::string places_of(const ToolRay& ray) {
  std::string text = fmt::format("{}", ray.tools.size());
  for (const auto& tool : ray.tools) {
    put(text, tool.nodes);
    put(text, tool.weights);
  }
  return text;
}

std::string text_of(const ToolRay& ray) {
  std::string text = places_of(ray);
  for (const auto& tool : ray.tools) put(text, tool.displacement);
  put(text, ray.parts);
  return text;
}

/// Hash of what forces of tools depend on: not of the nodes, directions and depths that a database has.
std::string hash_of_body(const VariantBody& body, Variant variant) {
  Fnv1a64 hash;
  if (variant != Variant::scene) hash.add(name(variant));
  std::istringstream lines(physics_summary(body.scene));
  for (std::string line; std::getline(lines, line);) {
    const auto is_of = [&](const char* begin) { return line.starts_with(begin); };
    if (!is_of("nodes.") && !is_of("probe.directions") && !is_of("probe.increments") &&
        !is_of("probe.max_displacement_m"))
      hash.add(line);
  }
  for (const auto node : body.sets.fixed) hash.add(fmt::format(" {}", node));
  return hash.hex();
}

std::string first_line(std::istream& file) {
  std::string line;
  std::getline(file, line);
  return line;
}

VariantBody body_of(const DatabaseHeader& header, Variant reference) {
  return variant_body(reference, {stored_scene(header), header.mesh, header.sets});
}

/// The first line of a file of this body.
std::string begin_of(const DatabaseHeader& header, const VariantBody& body, Variant reference) {
  return fmt::format("{}mesh {} body {}", begin_of_calibration, header.mesh_hash, hash_of_body(body, reference));
}

/// The complete lines of a file of this body; none of another file.
void read_rays(const fs::path& file, const std::string& begin, std::map<std::string, std::string>& rays) {
  std::ifstream in(file);
  if (first_line(in) != begin) return;
  std::string line;
  while (std::getline(in, line))
    if (const auto at = line.find(separator); at != std::string::npos && line.ends_with(" ."))
      rays.insert_or_assign(line.substr(0, at), line.substr(at, line.size() - at));
}

/// Empty unless these are finite forces of whole states of the ray.
std::optional<std::vector<Vec3>> forces_of(const std::string& text, const ToolRay& ray) {
  std::istringstream words(text.substr(std::string(separator).size()));
  std::vector<double> values;
  for (std::string word; words >> word && word != ".";) {
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), values.emplace_back());
    if (code != std::errc{} || end != word.data() + word.size() || !std::isfinite(values.back())) return {};
  }
  const auto n = 3 * ray.tools.size();
  if (values.size() % n != 0 || values.size() > n * (ray.parts.empty() ? 3 : ray.parts.size())) return {};
  std::vector<Vec3> forces(values.size() / 3);
  for (std::size_t i = 0; i < values.size(); ++i) forces[i / 3][i % 3] = values[i];
  return forces;
}

std::vector<fs::path> parts_of(const fs::path& file) {
  std::vector<fs::path> parts;
  const auto folder = fs::absolute(file).parent_path();
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().filename().string().starts_with(file.filename().string() + ".rank-"))
      parts.push_back(entry.path());
  return parts;
}

}  // namespace

fs::path calibration_file(const fs::path& database, Variant reference) {
  return database.string() + ".calibration" + (reference == Variant::scene ? "" : fmt::format("-{}", name(reference)));
}

bool is_of_another_body(const fs::path& file, const DatabaseHeader& header, Variant reference) {
  std::ifstream in(file);
  const auto first = first_line(in);
  return first.starts_with(begin_of_calibration) && first != begin_of(header, body_of(header, reference), reference);
}

std::vector<phn_tool> tools_at(const ToolRay& ray, double part) {
  auto tools = ray.tools;
  for (auto& tool : tools)
    for (double& x : tool.displacement) x *= part;
  return tools;
}

KeptRays::KeptRays(const SolverSession& session, const DatabaseHeader& header, Variant reference, const fs::path& file,
                   ShouldStop stop)
    : _session(session),
      _header(header),
      _body(body_of(header, reference)),
      _file(file),
      _begin(begin_of(header, _body, reference)),
      _solver(_body.scene, _body.mesh, _body.sets) {
  _solver.set_stop(std::move(stop));
  if (_file.empty()) return;
  session.together([&] {
    if (session.rank() == 0) join();
  });
  session.together([&] {
    read_rays(_file, _begin, _known);
    const auto part = fmt::format("{}.rank-{}", _file.string(), session.rank());
    _out.open(part, std::ios::binary | std::ios::trunc);
    _out << _begin << std::endl;
    if (!_out)
      throw failure("cannot write what is solved", part, "free space, or make the folder of the database writable");
  });
}

void KeptRays::join() const {
  std::map<std::string, std::string> rays;
  const auto parts = parts_of(_file);
  read_rays(_file, _begin, rays);
  for (const auto& part : parts) read_rays(part, _begin, rays);
  std::string text = _begin + "\n";
  for (const auto& [ray, forces] : rays) text += ray + forces + "\n";
  write_text_file(_file, text);
  for (const auto& part : parts) fs::remove(part);
}

void KeptRays::close() {
  if (_file.empty()) return;
  _session.together([&] { _out.close(); });
  _session.together([&] {
    if (_session.rank() == 0) join();
  });
}

std::vector<Vec3> KeptRays::forces(const ToolRay& ray) {
  const auto key = text_of(ray);
  if (const auto found = _known.find(key); found != _known.end())
    if (const auto forces = forces_of(found->second, ray)) {
      ++_taken;
      return *forces;
    }
  const auto forces = solve(ray);
  if (_file.empty()) return forces;
  std::string text = key + separator;
  for (const auto& force : forces) put(text, force);
  _out << text + " .\n" << std::flush;
  if (!_out) throw failure("cannot write what is solved", _file.string(), "free space, then run it again");
  return forces;
}

/// On a finer mesh the triangle of a point between nodes is another one.
SurfacePoint KeptRays::point_of(const phn_tool& tool) const {
  SurfacePoint point;
  Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    point.nodes[k] = tool.nodes[k] < 0 ? tool.nodes[0] : tool.nodes[k];
    point.weights[k] = tool.weights[k];
    x += point.weights[k] * _body.mesh.nodes.row(point.nodes[k]);
  }
  if (_body.mesh.n_nodes() == _header.mesh.n_nodes() || std::ranges::max(point.weights) == 1) return point;
  return nearest_on_surface(_body.mesh.nodes, _body.mesh.surface, {x[0], x[1], x[2]});
}

std::vector<Vec3> KeptRays::solve(const ToolRay& ray) {
  std::vector<Vec3> forces, d;
  std::vector<SurfacePoint> points;
  for (const auto& tool : ray.tools) {
    points.push_back(point_of(tool));
    d.push_back({tool.displacement[0], tool.displacement[1], tool.displacement[2]});
  }
  try {
    if (const auto places = places_of(ray); places != _touched) {
      _touched.clear();
      _solver.touch_points(points);
      _touched = places;
    }
    if (ray.parts.empty())
      for (const auto& column : _solver.rest().stiffness_N_per_m.colwise())
        forces.push_back({column[0], column[1], column[2]});
    _solver.follow(d, ray.parts, false, [&](std::size_t, const Response& response) {
      if (response.status != Status::converged) return false;
      forces.insert(forces.end(), response.force_N.begin(), response.force_N.end());
      return true;
    });
  } catch (const Error&) {  // also of tools at one place, or if a tangent is not factorized
    _solver.recover();
    _touched.clear();
  }
  return forces;
}

}  // namespace phynness
