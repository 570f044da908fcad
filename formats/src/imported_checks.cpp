#include "imported_checks.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <phynness/formats/error.hpp>

namespace phynness::imported {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// Sizes of a body that is touched, in m: beyond the first, numbers are in mm; the others are worth a question.
constexpr double largest_body = 10, unusual_body = 1, tiny_body = 1e-3;
/// Forces, energies and displacements at rest may be noise up to this fraction of the largest.
constexpr double most_at_rest = 0.05;
/// Repeated measurements may differ by this fraction of the largest force.
constexpr double most_between_repeated = 0.3;
constexpr std::size_t fewest_displacements = 6;
/// Energy over force . displacement is 1/2 for linear responses and above 1/20 for all stiffening up to |f| ~ |d|^19.
constexpr double least_energy = 0.05, most_energy = 1;
/// Displacements of the tool and of fixed nodes may differ from what they should be by this fraction of the largest.
constexpr double most_misplaced = 0.02;
/// Young's moduli of materials that yield to a hand or a tool [Pa], with a margin.
constexpr double softest = 1, hardest = 1e12;

const char* const remedy_of_rows = "give arrays with one row for each response";

std::string row(std::int64_t i) { return "row " + std::to_string(i); }

double diagonal_of(const Points& points) { return (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm(); }

void require_finite(const char* what, const Points& numbers) {
  for (Index i = 0; i < numbers.rows(); ++i)
    if (!numbers.row(i).allFinite())
      throw input_error(std::string(what) + " are not finite", row(i), "leave this row out, or correct it");
}

void check_nodes(const char* what, const std::vector<std::int32_t>& nodes, Index n_nodes) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (nodes[i] < 0 || nodes[i] >= n_nodes)
      throw input_error(std::string(what) + " must be numbers of points",
                        "entry " + std::to_string(i) + " is " + std::to_string(nodes[i]) + " of " +
                            std::to_string(n_nodes) + " points",
                        "count points from 0, in the order of the array of points");
}

void check_body(GivenResponses& given, ImportReport& report) {
  const Index n = given.points_m.rows();
  if (n == 0 || given.cells.rows() == 0)
    throw input_error("a body needs points and tetrahedra or triangles",
                      std::to_string(n) + " points and " + std::to_string(given.cells.rows()) + " cells",
                      "give the mesh, or of one place without a mesh phynness.ConservativeForce");
  if (given.cells.cols() != 3 && given.cells.cols() != 4)
    throw input_error("a cell must have 3 or 4 corners", std::to_string(given.cells.cols()),
                      "give the corners of tetrahedra or triangles, without nodes on edges");
  require_finite("coordinates of points", given.points_m);
  for (Index i = 0; i < given.cells.rows(); ++i)
    for (Index k = 0; k < given.cells.cols(); ++k)
      if (given.cells(i, k) < 0 || given.cells(i, k) >= n)
        throw input_error("corners of cells must be numbers of points",
                          "cell " + std::to_string(i) + " has " + std::to_string(given.cells(i, k)) + " of " +
                              std::to_string(n) + " points",
                          "count points from 0, in the order of the array of points");
  const double diagonal = diagonal_of(given.points_m);
  if (!(diagonal > 0) || diagonal > largest_body)
    throw input_error("the body has an implausible size", "its diagonal is " + brief(diagonal) + " m",
                      "give coordinates and displacements in metres: multiply millimetres by 0.001");
  if (diagonal > unusual_body || diagonal < tiny_body)
    report.warnings.push_back("the diagonal of the body is " + brief(diagonal) + " m; are its coordinates in metres?");
}

void orient_cells(GivenResponses& given, ImportReport& report) {
  if (given.cells.cols() != 4) return;
  std::int64_t turned = 0;
  for (Index i = 0; i < given.cells.rows(); ++i) {
    const auto at = [&](Index k) -> Vector3d { return given.points_m.row(given.cells(i, k)); };
    const double six_volumes = (at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0));
    if (six_volumes == 0)
      throw input_error("a tetrahedron has no volume", "cell " + std::to_string(i), "leave it out, or mend the mesh");
    if (six_volumes > 0) continue;
    std::swap(given.cells(i, 2), given.cells(i, 3));
    ++turned;
  }
  if (turned > 0)
    report.notes.push_back(std::to_string(turned) + " tetrahedra were turned, so that their volumes are positive");
}

void check_rows(GivenResponses& given) {
  const auto n = given.displacements_m.rows();
  if (n == 0) throw input_error("there are no responses", "0 rows", remedy_of_rows);
  if (n > most_imported_rows)
    throw input_error("there are too many responses",
                      std::to_string(n) + " rows, of which " + std::to_string(most_imported_rows) + " are possible",
                      "give every n-th row: of each node at most 600 are fitted");
  if (given.touched.size() == 1) given.touched.assign(static_cast<std::size_t>(n), given.touched.front());
  const std::pair<const char*, Index> counts[] = {
      {"forces", given.forces_N.rows()},
      {"touched nodes", std::ssize(given.touched)},
      {"energies", given.energies_J.empty() ? n : std::ssize(given.energies_J)}};
  for (const auto& [what, count] : counts)
    if (count != n)
      throw input_error(std::string("every displacement needs its row of ") + what,
                        std::to_string(n) + " displacements and " + std::to_string(count) + " " + what, remedy_of_rows);
  require_finite("displacements", given.displacements_m);
  require_finite("forces", given.forces_N);
  for (std::size_t i = 0; i < given.energies_J.size(); ++i)
    if (!std::isfinite(given.energies_J[i]))
      throw input_error("an energy is not finite", row(static_cast<std::int64_t>(i)),
                        "leave this row out, or give no energies");
}

void check_sets(const GivenResponses& given) {
  const Index n = given.points_m.rows();
  check_nodes("fixed nodes", given.fixed, n);
  check_nodes("touched nodes", given.touched, n);
  check_nodes("output nodes", given.output, n);
  auto output = given.output;
  std::sort(output.begin(), output.end());
  if (const auto twice = std::adjacent_find(output.begin(), output.end()); twice != output.end())
    throw input_error("an output node is given twice", std::to_string(*twice), "give each output node once");
  for (std::size_t i = 0; i < given.touched.size(); ++i)
    if (std::find(given.fixed.begin(), given.fixed.end(), given.touched[i]) != given.fixed.end())
      throw input_error("a fixed node is touched",
                        row(static_cast<std::int64_t>(i)) + ", node " + std::to_string(given.touched[i]),
                        "correct fixed nodes or touched nodes");
  if (given.output.empty() != !given.output_displacements)
    throw input_error("displacements of output nodes need the numbers of these nodes, and these need displacements",
                      std::to_string(given.output.size()) + " output nodes", "give both or none");
  if (!(given.tool_radius_m >= 0) || given.tool_radius_m > diagonal_of(given.points_m))
    throw input_error("the radius of the tool is impossible", brief(given.tool_radius_m) + " m",
                      "give metres, or 0 for single nodes");
}

void check_displacements(const GivenResponses& given, ImportReport& report) {
  const double diagonal = diagonal_of(given.points_m);
  report.rows = given.displacements_m.rows();
  report.largest_displacement_m = std::sqrt(given.displacements_m.rowwise().squaredNorm().maxCoeff());
  report.largest_force_N = std::sqrt(given.forces_N.rowwise().squaredNorm().maxCoeff());
  const double largest = report.largest_displacement_m;
  if (largest == 0)
    throw input_error("all displacements are zero", std::to_string(report.rows) + " rows", remedy_of_rows);
  if (report.largest_force_N == 0)
    throw input_error("all forces are zero", std::to_string(report.rows) + " rows",
                      "give the forces that hold the displacements");
  if (largest > diagonal)
    throw input_error("a displacement is longer than the body",
                      brief(largest) + " m, the body's diagonal is " + brief(diagonal) + " m",
                      "give coordinates and displacements in metres: multiply millimetres by 0.001");
  if (largest < 1e-4 * diagonal)
    report.warnings.push_back("the longest displacement, " + brief(largest) +
                              " m, is less than 1/10000 of the body's "
                              "diagonal; are both in metres?");
  const double modulus = report.largest_force_N / (largest * diagonal);
  if (modulus < softest || modulus > hardest)
    report.warnings.push_back("the forces are those of a material with a modulus near " + brief(modulus) +
                              " Pa; are they in newtons?");
}

/// The mean of rows with one displacement. @throws Error (input) if they contradict each other
State mean_state(const GivenResponses& given, std::vector<std::int64_t> rows, double largest_force) {
  State state;
  state.displacement_m = given.displacements_m.row(rows.front());
  state.force_N.setZero();
  const auto share = 1.0 / static_cast<double>(rows.size());
  for (const auto i : rows) {
    state.force_N += share * given.forces_N.row(i).transpose();
    if (!given.energies_J.empty()) state.energy_J += share * given.energies_J[static_cast<std::size_t>(i)];
    if ((given.forces_N.row(i) - given.forces_N.row(rows.front())).norm() > most_between_repeated * largest_force)
      throw input_error(
          "the same displacement has two different forces",
          "rows " + std::to_string(rows.front()) + " and " + std::to_string(i) + ", node " +
              std::to_string(given.touched[static_cast<std::size_t>(i)]),
          "a model has one force for each displacement: leave one of them out; a body that snaps has two");
  }
  state.rows = std::move(rows);
  return state;
}

void check_rest(const GivenResponses& given, std::int64_t i, double largest_force, double largest_energy) {
  if (given.forces_N.row(i).norm() > most_at_rest * largest_force)
    throw input_error("the force at rest is not zero", row(i) + ": " + brief(given.forces_N.row(i).norm()) + " N",
                      "measure displacements from where the force vanishes, or subtract this force from all");
  if (!given.energies_J.empty() &&
      std::abs(given.energies_J[static_cast<std::size_t>(i)]) > most_at_rest * largest_energy)
    throw input_error("the energy at rest is not zero",
                      row(i) + ": " + brief(given.energies_J[static_cast<std::size_t>(i)]) + " J",
                      "subtract this energy from all");
}

NodeStates states_of_node(const GivenResponses& given, std::int32_t node, const std::vector<std::int64_t>& rows,
                          ImportReport& report) {
  NodeStates all;
  all.node = node;
  double largest_force = 0, largest_energy = 0;
  for (const auto i : rows) {
    largest_force = std::max(largest_force, given.forces_N.row(i).norm());
    if (!given.energies_J.empty())
      largest_energy = std::max(largest_energy, std::abs(given.energies_J[static_cast<std::size_t>(i)]));
  }
  std::map<std::array<double, 3>, std::vector<std::int64_t>> by_displacement;
  for (const auto i : rows) {
    const auto d = given.displacements_m.row(i);
    // Adding 0 makes zeros of both signs equal.
    if (!d.isZero(0))
      by_displacement[{d[0] + 0.0, d[1] + 0.0, d[2] + 0.0}].push_back(i);
    else
      check_rest(given, i, largest_force, largest_energy), ++report.at_rest;
  }
  for (auto& [d, same] : by_displacement) {
    report.repeated += std::ssize(same) - 1;
    all.states.push_back(mean_state(given, std::move(same), largest_force));
  }
  if (all.states.size() < fewest_displacements)
    throw input_error("there are too few displacements of node " + std::to_string(node),
                      std::to_string(all.states.size()),
                      "give at least " + std::to_string(fewest_displacements) + " different ones that are not zero");
  return all;
}

/// The forces are those that hold the body, and the energies, if known, are theirs.
void check_signs(const std::vector<NodeStates>& nodes, bool has_energies, ImportReport& report) {
  std::vector<double> shares;
  for (const auto& node : nodes) {
    double work = 0, size = 0;
    for (const auto& state : node.states) {
      work += state.force_N.dot(state.displacement_m);
      size += state.force_N.norm() * state.displacement_m.norm();
      if (state.force_N.dot(state.displacement_m) != 0)
        shares.push_back(state.energy_J / state.force_N.dot(state.displacement_m));
    }
    if (work < 0)
      throw input_error("the forces of node " + std::to_string(node.node) + " point against the displacements",
                        "mean cosine " + brief(work / size),
                        "give the forces that hold the displacements, which are the negative of reactions");
  }
  if (!has_energies || shares.empty()) return;
  const auto middle = shares.begin() + std::ssize(shares) / 2;
  std::nth_element(shares.begin(), middle, shares.end());
  report.energy_over_work = *middle;
  if (!(*middle >= least_energy && *middle <= most_energy))
    throw input_error("the energies are not those of the forces",
                      "the median of energy / (force . displacement) is " + brief(*middle) + ", of a spring it is 0.5",
                      "check signs and units (J, N, m); an energy is 0 at rest, and that of the whole body");
}

void check_path(const std::vector<NodeStates>& nodes, ImportReport& report) {
  constexpr double refused = 0.5, warned = 0.1;
  report.path_dependence = path_dependence(nodes);
  if (report.path_dependence > refused)
    throw input_error("the work of the forces depends on the path",
                      "their curl is " + brief(report.path_dependence) + " of that of a pure rotation",
                      "an elastic body has an energy: check the order of rows and components; friction and plastic "
                      "bodies cannot be modelled");
  if (report.path_dependence > warned)
    report.warnings.push_back("the work of the forces depends on the path (curl " + brief(report.path_dependence) +
                              " of that of a pure rotation); family modal fits the part that has an energy");
}

}  // namespace

void check_shapes(GivenResponses& given, ImportReport& report) {
  check_rows(given);
  check_body(given, report);
  check_sets(given);
  check_displacements(given, report);
  orient_cells(given, report);
}

std::vector<NodeStates> checked_states(const GivenResponses& given, ImportReport& report) {
  std::map<std::int32_t, std::vector<std::int64_t>> rows;
  for (std::size_t i = 0; i < given.touched.size(); ++i) rows[given.touched[i]].push_back(static_cast<std::int64_t>(i));
  std::vector<NodeStates> nodes;
  for (const auto& [node, some] : rows) nodes.push_back(states_of_node(given, node, some, report));
  check_signs(nodes, !given.energies_J.empty(), report);
  check_path(nodes, report);
  if (report.at_rest > 0) report.notes.push_back(std::to_string(report.at_rest) + " rows at rest are left out");
  if (report.repeated > 0)
    report.notes.push_back(std::to_string(report.repeated) +
                           " rows repeat a displacement of their node; the means are stored");
  return nodes;
}

void check_output(const GivenResponses& given, const std::function<void(const std::vector<double>&)>& see) {
  const std::size_t n = given.output.size();
  std::vector<double> u(3 * n);
  const double largest_d = std::sqrt(given.displacements_m.rowwise().squaredNorm().maxCoeff());
  const double farthest = largest_d * 10;
  for (Index i = 0; n > 0 && i < given.displacements_m.rows(); ++i) {
    given.output_displacements(i, u.data());
    see(u);
    for (std::size_t o = 0; o < n; ++o) {
      const auto moved = Vector3d::Map(&u[3 * o]);
      const auto where = row(i) + ", node " + std::to_string(given.output[o]);
      if (!moved.allFinite())
        throw input_error("a displacement of an output node is not finite", where, "leave this row out");
      if (moved.norm() > farthest)
        throw input_error("an output node moves ten times as far as the tool",
                          where + ": " + brief(moved.norm()) + " m", "give displacements, not positions, in metres");
      const bool is_touched = given.tool_radius_m == 0 && given.output[o] == given.touched[static_cast<std::size_t>(i)];
      if (is_touched && (moved - given.displacements_m.row(i).transpose()).norm() > most_misplaced * largest_d)
        throw input_error("the touched node does not follow the tool",
                          where + ": it moves by " + brief(moved.norm()) + " m, the tool by " +
                              brief(given.displacements_m.row(i).norm()) + " m",
                          "check the order of rows and output nodes; of a round tool give its radius");
      if (moved.norm() > most_misplaced * largest_d &&
          std::find(given.fixed.begin(), given.fixed.end(), given.output[o]) != given.fixed.end())
        throw input_error("a fixed node moves", where + ": " + brief(moved.norm()) + " m",
                          "correct fixed nodes or the order of output nodes");
      if (given.displacements_m.row(i).isZero(0) && moved.norm() > most_at_rest * largest_d)
        throw input_error("an output node is displaced at rest", where + ": " + brief(moved.norm()) + " m",
                          "give displacements from the position at rest");
    }
  }
}

double path_dependence(const std::vector<NodeStates>& nodes) {
  constexpr std::size_t most_nodes = 50, most_states = 200;
  // The work round triangles of neighbouring states is curl . area, exactly if the force is linear between them.
  Eigen::Matrix4d sums = Eigen::Matrix4d::Zero();  // of (area, work) (area, work)^T, of unit areas
  std::vector<double> stiffnesses;
  double n_triangles = 0;
  for (std::size_t k = 0; k < nodes.size(); k += (nodes.size() + most_nodes - 1) / most_nodes) {
    const auto& all = nodes[k].states;
    std::vector<std::pair<Vector3d, Vector3d>> states{{Vector3d::Zero(), Vector3d::Zero()}};
    for (std::size_t i = 0; i < all.size(); i += (all.size() + most_states - 1) / most_states)
      states.emplace_back(all[i].displacement_m, all[i].force_N);
    for (const auto& state : states) {
      auto near = states;
      const auto n_near = std::min<std::ptrdiff_t>(5, std::ssize(near));
      std::partial_sort(near.begin(), near.begin() + n_near, near.end(), [&](const auto& a, const auto& b) {
        return (a.first - state.first).squaredNorm() < (b.first - state.first).squaredNorm();
      });
      for (std::ptrdiff_t i = 1; i < n_near; ++i) {
        const auto& [di, fi] = near[static_cast<std::size_t>(i)];
        stiffnesses.push_back((fi - state.second).norm() / (di - state.first).norm());
        for (std::ptrdiff_t j = i + 1; j < n_near; ++j) {
          const auto& [dj, fj] = near[static_cast<std::size_t>(j)];
          const Vector3d a = di - state.first, b = dj - state.first;
          Eigen::Vector4d terms;
          terms.head<3>() = a.cross(b) / 2;
          terms[3] = ((state.second + fi).dot(a) + (fi + fj).dot(b - a) - (fj + state.second).dot(b)) / 2;
          const double area = terms.head<3>().norm();
          if (!(area > 1e-3 * a.norm() * b.norm())) continue;
          sums += terms * terms.transpose() / (area * area);
          n_triangles += 1;
        }
      }
    }
  }
  if (n_triangles < 12) return 0;
  std::nth_element(stiffnesses.begin(), stiffnesses.begin() + std::ssize(stiffnesses) / 2, stiffnesses.end());
  const double stiffness = stiffnesses[stiffnesses.size() / 2];
  const Eigen::FullPivLU<Eigen::Matrix3d> areas(sums.topLeftCorner<3, 3>());
  if (!areas.isInvertible() || !(stiffness > 0)) return 0;
  const Vector3d curl = areas.solve(sums.topRightCorner<3, 1>());
  // A curl within four standard errors, such as that of noise, is none.
  const double rest = std::max(0.0, sums(3, 3) - curl.dot(sums.topRightCorner<3, 1>()));
  const double error = std::sqrt(rest / n_triangles * areas.inverse().trace());
  return curl.norm() > 4 * error ? curl.norm() / (2 * stiffness) : 0;
}

}  // namespace phynness::imported
