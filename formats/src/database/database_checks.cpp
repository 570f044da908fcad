// Checks of the header of a database: of its numbers, when it is read and when it is written, because other code uses
// them as indices, counts and divisors; and whether the present run can continue it.

#include <algorithm>
#include <cmath>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/formats/printable.hpp>

#include "database_layout.hpp"
#include "database_log.hpp"

namespace phynness {
namespace {

namespace path = database_layout::path;

const char* const remedy = "the file is damaged, or was written by a defective program: compute the database again";

// Much larger than in any scene (formats/scene.md). Within these limits products of counts do not overflow, and a few
// damaged bytes of a file cannot cause an allocation of all memory.
constexpr std::size_t most_directions = 10000, most_increments = 10000, most_rays = 100'000'000;
// Limits of the diagonal of the body's bounding box [m].
constexpr double smallest_diagonal = 1e-9, largest_diagonal = 1e9;
// Tolerances of the squared lengths of directions, and of sums of weights.
constexpr double direction_rounding = 1e-9, weight_rounding = 1e-9;

class HeaderChecks {
 public:
  HeaderChecks(const DatabaseHeader& header, const std::string& where) : _header(header), _where(where) {}

  void run() {
    require(_header.mesh.n_nodes() > 0 && _header.mesh.n_cells() > 0, "a mesh");
    require(!_header.sets.active.empty(), "an active node");
    require(_header.imported || !_header.sets.output.empty(), "an output node");
    require(!_header.directions.empty(), "a direction");
    require(!_header.magnitudes_m.empty(), "an increment");
    check_hash(_header.mesh_hash, "mesh_hash");
    check_hash(_header.physics_hash, "physics_hash");
    check_mesh();
    check_sets();
    check_probes();
    check_sizes();
  }

 private:
  void require(bool good, const char* what) const {
    if (!good)
      throw input_error(_where + " must have at least " + what, "it has none",
                        "check the selections and the probe of the scene");
  }
  [[noreturn]] void refuse(const std::string& dataset, const std::string& what, const std::string& value) const {
    throw input_error(_where + ": " + dataset + " " + what, value, remedy);
  }
  [[noreturn]] void refuse_entry(const std::string& dataset, const std::string& what, const std::string& entry,
                                 const std::string& value) const {
    refuse(dataset, what, "entry [" + entry + "] is " + value);
  }

  /// The writer computes empty hashes before this check.
  void check_hash(const std::string& hash, const char* name) const {
    const bool good = hash.size() == 16 && hash.find_first_not_of("0123456789abcdef") == std::string::npos;
    if (!good) refuse(std::string("attribute ") + name, "is not 16 hexadecimal digits", "'" + hash + "'");
  }

  template <class Matrix>
  void check_corners(const Matrix& corners, const char* dataset) const {
    for (Eigen::Index i = 0; i < corners.rows(); ++i)
      for (Eigen::Index k = 0; k < corners.cols(); ++k)
        if (corners(i, k) < 0 || corners(i, k) >= _header.mesh.n_nodes())
          refuse_entry(dataset, "contains a node that is not in the mesh", std::to_string(i) + ", " + std::to_string(k),
                       std::to_string(corners(i, k)) + " of " + std::to_string(_header.mesh.n_nodes()) + " nodes");
  }

  void check_mesh() const {
    const Mesh& mesh = _header.mesh;
    for (Eigen::Index i = 0; i < mesh.nodes.rows(); ++i)
      for (int k = 0; k < 3; ++k)
        if (!std::isfinite(mesh.nodes(i, k)))
          refuse_entry(path::nodes, "contains a coordinate that is not finite",
                       std::to_string(i) + ", " + std::to_string(k), number_text(mesh.nodes(i, k)));
    const double diagonal = (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).norm();
    if (!(diagonal >= smallest_diagonal && diagonal <= largest_diagonal))
      refuse(path::nodes, "define a body of impossible size", "a diagonal of " + number_text(diagonal) + " m");
    if (mesh.cells.cols() != 3 && mesh.cells.cols() != 4)
      refuse(path::cells, "must have 3 or 4 nodes per cell", std::to_string(mesh.cells.cols()));
    check_corners(mesh.cells, path::cells);
    check_corners(mesh.surface, path::surface);
    int number = 0;
    for (const auto& [name, nodes] : mesh.groups) {
      (void)name;
      check_nodes(nodes, (std::string(path::groups) + "/" + std::to_string(number++)).c_str());
    }
  }

  void check_nodes(const std::vector<std::int32_t>& nodes, const char* dataset) const {
    const auto n = _header.mesh.n_nodes();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i] < 0 || nodes[i] >= n)
        refuse_entry(dataset, "contains a node that is not in the mesh", std::to_string(i),
                     std::to_string(nodes[i]) + " of " + std::to_string(n) + " nodes");
      if (i > 0 && nodes[i] <= nodes[i - 1])
        refuse_entry(dataset, "must be ascending node numbers", std::to_string(i),
                     std::to_string(nodes[i]) + " after " + std::to_string(nodes[i - 1]));
    }
  }

  void check_sets() const {
    check_nodes(_header.sets.fixed, path::fixed);
    check_nodes(_header.sets.active, path::active);
    check_nodes(_header.sets.output, path::output);
    check_tools();
  }

  void check_tools() const {
    const auto& tools = _header.sets.tools;
    if (tools.size() != _header.sets.active.size())
      refuse(path::tool_ends, "must have an entry for each active node",
             std::to_string(tools.size()) + " of " + std::to_string(_header.sets.active.size()) + " active nodes");
    for (const auto& tool : tools) {
      check_nodes(tool.nodes, path::tool_nodes);
      double sum = 0;
      for (const double weight : tool.weights) {
        if (!(weight > 0)) refuse(path::tool_weights, "must be positive", number_text(weight));
        sum += weight;
      }
      if (!(std::abs(sum - 1) < weight_rounding))
        refuse(path::tool_weights, "of a tool must have the sum 1", number_text(sum));
      if (!tool.mean && tool.nodes.size() != 1)
        refuse(path::tool_nodes, "must have one node for each active node where tools are not round",
               std::to_string(tool.nodes.size()));
    }
  }

  void check_probes() const {
    for (std::size_t d = 0; d < _header.directions.size(); ++d) {
      const double length = Eigen::Vector3d::Map(_header.directions[d].data()).norm();
      if (!(std::abs(length - 1) < direction_rounding))
        refuse(path::directions, "must hold vectors of length 1",
               "that of entry [" + std::to_string(d) + "] is " + number_text(length));
    }
    double before = 0;
    const double most = largest_displacement(_header.mesh);
    for (std::size_t i = 0; i < _header.magnitudes_m.size(); ++i) {
      const double magnitude = _header.magnitudes_m[i];
      if (!(magnitude > before) || !(magnitude <= most))
        refuse_entry(path::magnitudes,
                     "must be positive, ascending, and at most 100 diagonals of the body, " + number_text(most) + " m",
                     std::to_string(i), number_text(magnitude));
      before = magnitude;
    }
  }

  void check_sizes() const {
    if (_header.directions.size() > most_directions)
      refuse(path::directions, "are too many", std::to_string(_header.directions.size()));
    if (_header.magnitudes_m.size() > most_increments)
      refuse(path::magnitudes, "are too many", std::to_string(_header.magnitudes_m.size()));
    if (_header.sets.active.size() > most_rays / _header.directions.size())
      refuse(path::active, "gives too many rays with the directions",
             std::to_string(_header.sets.active.size()) + " x " + std::to_string(_header.directions.size()));
    const auto bytes = database_log::Layout(_header).payload_bytes;
    if (bytes > std::numeric_limits<std::uint32_t>::max())
      refuse(path::output, "gives rays that are too large for a log", std::to_string(bytes) + " bytes");
  }

  const DatabaseHeader& _header;
  const std::string& _where;
};

}  // namespace

void check_header(const DatabaseHeader& header, const std::string& where) { HeaderChecks(header, where).run(); }

double largest_displacement(const Mesh& mesh) {
  constexpr double diagonals = 100;
  return diagonals * (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).norm();
}

}  // namespace phynness
