#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <numeric>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/schema/body_grammar.hpp>
#include <phynness/training/reduction.hpp>
#include <utility>
#include <vector>

#include "dense_products.hpp"
#include "dense_solvers.hpp"
#include "reduced/elements.hpp"
#include "reduced/parts.hpp"
#include "sampling.hpp"
#include "threads.hpp"

namespace phynness {
namespace {

using namespace reduced;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double truncation_of_a_node = 1e-6;   ///< share of int |grad u|^2 that the modes of a node leave out
constexpr std::size_t most_candidates = 8'000;  ///< of a part, among which those with a weight are
/// The forces and changes of volume of a state are so many random sums of all of them.
constexpr int sums_of_a_state = 16;
/// With regions a state has fewer, and the works of about so many states of one tool are met, too, so many times as
/// heavy as sums: forces of tools depend on them.
constexpr int sums_with_regions = 8, most_works = 4'000;
constexpr double weight_of_work = 8;
/// Of the smallest increment, for which works at rest are met.
constexpr double part_at_rest = 1e-3;
/// int |grad u|^2 of all fields of several tools over that of all fields of the database. 1, 2 and 4 differ less than
/// choices of cells do: pairs of a liver with K/mu 200 were off by 10 to 13 % (p95) with 300 cells.
constexpr double weight_of_several = 2;
/// Modes are too stiff by what they leave out, of which the last ones are the nearest likeness. From this part of the
/// modes on, they displace the surface more than they strain the cells, at the end by (1 - softest)^-1/2; less where
/// they leave out less than this share of int |grad u|^2 of all fields. Not with regions, where it makes tools at
/// probed nodes too soft (docs/decisions/reduced-body.md).
constexpr double first_softened = 0.25, softest = 0.4, truncation_of_softest = 5e-4;

/// The largest magnitude; 1 if there is none, as of pressures where all chosen points are edges.
double scale_of(const MatrixXd& values) {
  const double largest = values.cwiseAbs().maxCoeff();
  return largest > 0 ? largest : 1;
}

}  // namespace

Scene reducible_scene(const DatabaseHeader& header) {
  require_scene(header);
  Scene scene = stored_scene(header);
  const auto element = scene.solver.element;
  if (!has_bodies(*element))
    throw input_error("only the elements p1-p1 and es-p1-p1 can be reduced", std::string("element ") + name(element),
                      "give one of them in [solver] element, and precompute again");
  const auto& sets = header.sets;
  for (std::int32_t i = 0; i < header.mesh.n_nodes(); ++i)
    if (!std::ranges::binary_search(sets.fixed, i) && !std::ranges::binary_search(sets.output, i))
      throw input_error("the database does not have the displacements of all nodes",
                        "node " + std::to_string(i) + " is neither fixed nor an output node",
                        "give output = \"free\" in [nodes], and precompute again");
  return scene;
}

namespace {

class Reduction {
 public:
  Reduction(const Database& database, MatrixXd several, const ReductionSpec& spec, ReductionReport& report,
            const OnProgress& progress, int threads, const OwnStates& own_states)
      : _database(database),
        _header(database.header()),
        _scene(reducible_scene(_header)),
        _several(std::move(several)),
        _spec(spec),
        _report(report),
        _progress(progress),
        _threads(threads),
        _own_states(own_states),
        _elements(_header.mesh, _scene),
        _rest(derivatives_at_rest(_elements)),
        _first_cells(spec.cells > 0 ? spec.cells : usual_cells(_rest.size() > 1)) {}

  ReducedBody run(const IsEnough& is_enough) {
    draw_states();
    const Index drawn = _states.cols();
    const MatrixXd of_database = modes_of_nodes();
    int modes = _spec.modes, cells = _first_cells;
    for (;;) {
      MatrixXd fields = of_database;
      _states.conservativeResize(Eigen::NoChange, drawn);
      if (_several.cols() > 0) add_several(fields);
      find_modes(fields, modes);
      const MatrixXd inner = transposed_product(_modes, laplace_of(of_database));
      _report.captured = inner.squaredNorm() / _energy;
      auto out = _own_states ? body_of_own_states(modes, cells) : weighted_body(modes, cells);
      if (!_header.sets.linear.empty()) set_lacking(out);
      const bool is_largest = _modes.cols() < modes && cells >= _elements.n_points;
      if (!is_enough || is_enough(out, _report, _several) || is_largest || modes == schema::most_body_modes) return out;
      modes = std::min(static_cast<int>(grown(modes)), static_cast<int>(schema::most_body_modes));
      cells = static_cast<int>(grown(cells));
      _steps += drawn + cells + std::ssize(_header.sets.linear);
    }
  }

 private:
  void step(std::int64_t cells = 0) {
    const std::lock_guard lock(_mutex);
    if (cells == 0) ++_done;
    if (_progress) _progress(_done + cells, _steps);
  }
  std::int64_t steps_of(int cells) const { return _states.cols() + cells; }
  std::int32_t n_active() const { return static_cast<std::int32_t>(_header.sets.active.size()); }

  /// Numbers, [active][direction][increment] flattened, of the states from which pressures and weights follow.
  void draw_states() {
    std::vector<std::size_t> converged;
    const auto statuses = _database.statuses();
    for (std::size_t i = 0; i < statuses.size(); ++i)
      if (statuses[i] == Status::converged) converged.push_back(i);
    if (converged.empty())
      throw input_error("no active node has a converged increment", _header.scene_name,
                        "see the reasons with `phynness info`, and precompute with a smaller displacement");
    SplitMix64 random(_spec.seed);
    for (const auto i : draw_without_replacement(converged.size(), static_cast<std::size_t>(_spec.states), random))
      _drawn.push_back(converged[static_cast<std::size_t>(i)]);
    std::ranges::sort(_drawn);
    _states.setZero(3 * _elements.n_nodes, static_cast<Index>(_drawn.size()));
    _report.fields = static_cast<std::int64_t>(converged.size());
    _steps = n_active() + steps_of(_first_cells) + std::ssize(_header.sets.linear);
  }

  /// The converged fields of a node, 3 n_nodes x any. Keeps those that are drawn.
  /// @param forces, is_first  outputs, if given: 3 x fields [N]; whether it is of the smallest increment
  MatrixXd fields_of(std::int32_t active, Eigen::Matrix3Xd* forces = nullptr, std::vector<char>* is_first = nullptr) {
    std::vector<Ray> rays;
    {
      const std::lock_guard lock(_mutex);
      rays = _database.rays(active);
    }
    const auto& output = _header.sets.output;
    const std::size_t n = _header.magnitudes_m.size();
    MatrixXd fields = MatrixXd::Zero(3 * _elements.n_nodes, static_cast<Index>(rays.size() * n));
    if (forces) forces->resize(3, fields.cols());
    Index count = 0;
    for (std::size_t r = 0; r < rays.size(); ++r)
      for (std::size_t k = 0; k < n; ++k) {
        if (rays[r].status[k] != Status::converged) continue;
        if (forces) forces->col(count) = Eigen::Vector3d::Map(&rays[r].force[3 * k]);
        if (is_first) is_first->push_back(k == 0);
        auto u = fields.col(count++);
        const double* values = &rays[r].displacement[3 * k * output.size()];
        for (std::size_t o = 0; o < output.size(); ++o)
          for (Index i = 0; i < 3; ++i) u[i * _elements.n_nodes + output[o]] = *values++;
        const auto number = (static_cast<std::size_t>(active) * rays.size() + r) * n + k;
        const auto drawn = std::ranges::lower_bound(_drawn, number);
        if (drawn != _drawn.end() && *drawn == number) _states.col(drawn - _drawn.begin()) = u;
      }
    fields.conservativeResize(Eigen::NoChange, count);
    if (!fields.allFinite())
      throw failure("the database has a displacement that is not finite in a converged increment",
                    "active node " + std::to_string(_header.sets.active[static_cast<std::size_t>(active)]),
                    "precompute this database again");
    return fields;
  }

  MatrixXd laplace_of(const MatrixXd& fields) const { return _elements.laplace_of(fields); }
  /// int |grad u|^2 of each field.
  VectorXd energies_of(const MatrixXd& fields) const {
    return fields.cwiseProduct(laplace_of(fields)).colwise().sum().transpose();
  }

  /// Hierarchical: modes of the modes of each node (Himpe, Leibner, Rave 2018, doi 10.1137/16M1085413).
  MatrixXd modes_of_nodes() {
    std::vector<MatrixXd> modes(static_cast<std::size_t>(n_active()));
    std::vector<double> energies(modes.size());
    for_each_index(n_active(), _threads, [&](std::int32_t a) {
      const auto i = static_cast<std::size_t>(a);
      modes[i] = scaled_modes(_metric, fields_of(a), truncation_of_a_node, energies[i]);
      step();
    });
    _energy = std::accumulate(energies.begin(), energies.end(), 0.0);
    return side_by_side(std::move(modes), 3 * _elements.n_nodes);
  }

  /// Adds the fields of several tools, which those of single tools do not span.
  void add_several(MatrixXd& fields) {
    const double energy = _several.cwiseProduct(laplace_of(_several)).sum();
    if (!(energy > 0)) return;
    fields.conservativeResize(Eigen::NoChange, fields.cols() + _several.cols());
    if (_own_states)
      // A tenth of the states of near tools has half of the energy, and would have the modes.
      fields.rightCols(_several.cols()) =
          std::sqrt(weight_of_several * _energy / static_cast<double>(_several.cols())) * _several *
          energies_of(_several).cwiseMax(1e-300).cwiseSqrt().cwiseInverse().asDiagonal();
    else
      fields.rightCols(_several.cols()) = std::sqrt(weight_of_several * _energy / energy) * _several;
    _report.several_fields = _several.cols();
    // The weights fit some of them, too.
    SplitMix64 random(_spec.seed + 7);
    const auto drawn = draw_without_replacement(static_cast<std::size_t>(_several.cols()),
                                                static_cast<std::size_t>(_spec.states), random);
    const Index before = _states.cols();
    _states.conservativeResize(Eigen::NoChange, before + static_cast<Index>(drawn.size()));
    _states.rightCols(static_cast<Index>(drawn.size())) = _several(Eigen::all, drawn);
    _steps += _states.cols() - before;
  }

  void find_modes(const MatrixXd& fields, int modes) {
    double captured = 0;
    _modes = leading_modes(_metric, fields, modes, _spec.seed, _threads, captured);
    const double all = fields.cwiseProduct(laplace_of(fields)).sum();
    _softest =
        _rest.size() == 1 && all > captured ? softest * std::min((1 - captured / all) / truncation_of_softest, 1.0) : 0;
    _report.modes = _modes.cols();
  }

  /// @param modes, cells  at most
  ReducedBody weighted_body(int modes, int cells) {
    const auto before = _done;
    find_pressures(modes / 4);
    find_weights(cells);
    _done = before + steps_of(cells);
    return body(surface_nodes(_header.mesh.surface));
  }

  ReducedBody body_of_own_states(int modes, int cells) {
    const MatrixXd orthonormal_modes = _modes;
    const auto first = weighted_body(modes, cells);
    if (_cubature.residual.size() == 0) return first;  // it has all cells
    auto without_tables = first;
    without_tables.cells_at_rest = without_tables.lack_at_rest = {};
    const MatrixXd shapes = _own_states(without_tables);
    if (shapes.cols() == 0) return first;
    const MatrixXd own = product(_modes, least_squares(first.modes.values(), shapes));
    _modes = orthonormal_modes;
    const Index before = _states.cols();
    _states.conservativeResize(Eigen::NoChange, before + own.cols());
    _states.rightCols(own.cols()) = own;
    _steps += steps_of(cells);
    return weighted_body(modes, cells);
  }

  /// Of the pressures C^-1 b of the drawn states, b = int g(F) N dV.
  void find_pressures(int count) {
    const Eigen::SparseMatrix<double> soft = _elements.compressibility;
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> solver(soft);
    MatrixXd right = MatrixXd::Zero(soft.cols(), _states.cols());
    for_each_index(static_cast<std::int32_t>(_states.cols()), _threads, [&](std::int32_t s) {
      if (const auto here = energy_densities(_elements, _states.col(s)))
        right.col(s) = transposed_applied(_elements.pressure_values, _elements.bulk.cwiseProduct(here->g));
    });
    double captured = 0;
    _pressures = leading_modes([&](const MatrixXd& p) { return MatrixXd(soft * p); }, solver.solve(right),
                               std::max(1, count), _spec.seed, _threads, captured);
    _report.pressures = _pressures.cols();
  }

  /// Values at the points of a part of the body; 0 at the others.
  VectorXd restricted_to_part(VectorXd values, std::size_t part) const {
    for (Index p = 0; p < values.size(); ++p)
      if (_elements.part_of[static_cast<std::size_t>(p)] != part) values[p] = 0;
    return values;
  }

  /// Points among which those with a weight are, ascending: of each part of the body at most most_candidates.
  std::vector<std::int32_t> candidates(SplitMix64& random) const {
    std::vector<std::int32_t> all;
    for (std::size_t p = 0; p < _rest.size(); ++p) {
      std::vector<std::int32_t> points;
      for (std::int32_t i = 0; i < _elements.n_points; ++i)
        if (_elements.part_of[static_cast<std::size_t>(i)] == p) points.push_back(i);
      for (const auto i : draw_without_replacement(points.size(), most_candidates, random))
        all.push_back(points[static_cast<std::size_t>(i)]);
    }
    std::ranges::sort(all);
    return all;
  }

  /// The inverse of the lower Cholesky factor of the stiffness at rest, of which it keeps that of the shape.
  MatrixXd inverse_of_rest() {
    const Index n = _elements.n_nodes, m = _modes.cols();
    MatrixXd stiffness = MatrixXd::Zero(m, m), changes = MatrixXd::Zero(_pressures.cols(), m);
    for (std::size_t p = 0; p < _rest.size(); ++p) {
      const VectorXd shear = restricted_to_part(_elements.shear, p);
      for (Index i = 0; i < 3; ++i)
        for (Index k = 0; k < 3; ++k) {
          Sparse part(n, n);
          for (Index j = 0; j < 3; ++j)
            for (Index l = 0; l < 3; ++l)
              part += _rest[p].shape(3 * i + j, 3 * k + l) *
                      Sparse(_elements.derivative[static_cast<std::size_t>(j)].transpose() * shear.asDiagonal() *
                             _elements.derivative[static_cast<std::size_t>(l)]);
          stiffness += transposed_product(_modes.middleRows(i * n, n), product(part, _modes.middleRows(k * n, n)));
        }
    }
    _shape_at_rest = stiffness;
    for (std::size_t p = 0; p < _rest.size(); ++p) {
      const MatrixXd volumes =
          restricted_to_part(_elements.bulk, p).asDiagonal() * product(_elements.pressure_values, _pressures);
      for (Index k = 0; k < 9; ++k)
        changes += scaled_transposed_product(
            _rest[p].g[k], transposed_product(_elements.derivative[static_cast<std::size_t>(k % 3)], volumes),
            _modes.middleRows(k / 3 * n, n));
    }
    stiffness += transposed_product(changes, changes);
    return inverse_cholesky_factor(stiffness);
  }

  /// What is summed over the points of a state: its stress and its changes of volume.
  struct Integrands {
    VectorXd volumes, nodal_volumes, pressures;
    AtPoints stress;
  };
  /// @return nothing where the law is not defined at a point
  std::optional<Integrands> integrands(const VectorXd& amplitudes) const {
    const auto here = energy_densities(_elements, applied(_modes, amplitudes));
    if (!here) return std::nullopt;
    Integrands out;
    out.volumes = _elements.bulk.cwiseProduct(here->g);
    out.nodal_volumes = transposed_applied(_elements.pressure_values, out.volumes);
    out.pressures = transposed_applied(_pressures, out.nodal_volumes);
    const VectorXd pressure = applied(_elements.pressure_values, applied(_pressures, out.pressures));
    out.stress = here->shape_first * _elements.shear.asDiagonal() +
                 here->g_first * _elements.bulk.cwiseProduct(pressure).asDiagonal();
    return out;
  }

  /// Sums of stresses over the gradients of some displacements, and of changes of volume over pressures.
  struct Sums {
    VectorXd all;            ///< over all points
    MatrixXd of_candidates;  ///< what each candidate adds, a column for each sum
  };
  struct Candidates {
    std::vector<std::int32_t> points;
    std::array<Sparse, 3> slope;
    Sparse pressure_values;
  };
  /// @param tests, test_pressures  amplitudes of modes, a column for each sum
  Sums sums_of(const Integrands& state, const Candidates& candidates, const MatrixXd& tests,
               const MatrixXd& test_pressures) const {
    const MatrixXd displacements = product(_modes, tests), pressures = product(_pressures, test_pressures);
    Sums out{transposed_applied(pressures, state.nodal_volumes),
             state.volumes(candidates.points).asDiagonal() * product(candidates.pressure_values, pressures)};
    const auto gradient = gradients(candidates.slope, displacements);
    for (Index k = 0; k < 9; ++k) {
      const VectorXd component = state.stress.row(k).transpose();
      const auto& d = _elements.derivative[static_cast<std::size_t>(k % 3)];
      out.all += transposed_applied(displacements.middleRows(k / 3 * _elements.n_nodes, _elements.n_nodes),
                                    transposed_applied(d, component));
      out.of_candidates += component(candidates.points).asDiagonal() * gradient[static_cast<std::size_t>(k)];
    }
    return out;
  }

  /// States of one tool, and the work that the tool's force does in each.
  struct Works {
    MatrixXd states;  ///< in the modes
    VectorXd work;    ///< [J]; NaN: that of all points
  };
  /// Those of most_works converged states, and for the smallest increments those at rest.
  Works drawn_works() {
    std::vector<MatrixXd> states(static_cast<std::size_t>(n_active()));
    std::vector<VectorXd> works(states.size());
    const double share = std::min(1.0, most_works / static_cast<double>(_report.fields));
    for_each_index(n_active(), _threads, [&](std::int32_t a) {
      const auto i = static_cast<std::size_t>(a);
      SplitMix64 random(_spec.seed + 100 + i);
      Eigen::Matrix3Xd forces;
      std::vector<char> is_first;
      const MatrixXd all = transposed_product(_modes, laplace_of(fields_of(a, &forces, &is_first)));
      const TouchedNodes& tool = _header.sets.tools[i];
      MatrixXd mean = MatrixXd::Zero(3, _modes.cols());
      for (std::size_t t = 0; t < tool.nodes.size(); ++t)
        for (Index k = 0; k < 3; ++k)
          mean.row(k) += tool.weights[t] * _modes.row(k * _elements.n_nodes + tool.nodes[t]);
      states[i].resize(all.rows(), 2 * all.cols());
      works[i].resize(2 * all.cols());
      Index n = 0;
      for (Index c = 0; c < all.cols(); ++c) {
        const double lot = static_cast<double>(random.next() >> 11) * 0x1p-53;
        if (is_first[static_cast<std::size_t>(c)]) {
          states[i].col(n) = part_at_rest * all.col(c);
          works[i][n++] = std::nan("");
        }
        if (lot >= share) continue;
        states[i].col(n) = all.col(c);
        works[i][n++] = forces.col(c).dot(mean * all.col(c));
      }
      states[i].conservativeResize(Eigen::NoChange, n);
      works[i].conservativeResize(n);
    });
    Works out;
    for (const auto& w : works) {
      const Index before = out.work.size();
      out.work.conservativeResize(before + w.size());
      out.work.tail(w.size()) = w;
    }
    out.states = side_by_side(std::move(states), _modes.cols());
    return out;
  }

  /// Weights for the forces and changes of volume of the drawn states in the modes, of which random sums are taken.
  void find_weights(int cells) {
    const Index n_points = _elements.n_points;
    _report.points = n_points;
    if (cells >= n_points) {
      _cubature.points.resize(static_cast<std::size_t>(n_points));
      std::iota(_cubature.points.begin(), _cubature.points.end(), 0);
      _cubature.weights = VectorXd::Ones(n_points);
      _cubature.residual.resize(0);
      _shape_at_rest.resize(0, 0);  // of a smaller body
      return;
    }
    const bool has_regions = _rest.size() > 1;
    const int n_sums = has_regions ? sums_with_regions : sums_of_a_state;
    SplitMix64 random(_spec.seed + 1);
    const auto signs = [&](Index rows) {
      MatrixXd out(rows, n_sums);
      for (Index i = 0; i < out.size(); ++i) out.data()[i] = (random.next() >> 63 ? 1 : -1) / std::sqrt(n_sums);
      return out;
    };
    Candidates candidates{this->candidates(random), {}, {}};
    candidates.slope = _elements.derivative_at(candidates.points);
    candidates.pressure_values = _elements.pressure_values_at(candidates.points);
    const auto n = std::ssize(candidates.points);
    const MatrixXd inverse = inverse_of_rest();
    const MatrixXd states = transposed_product(_modes, laplace_of(_states));
    std::vector<std::pair<MatrixXd, MatrixXd>> tests;
    for (Index s = 0; s < states.cols(); ++s) tests.emplace_back(signs(_modes.cols()), signs(_pressures.cols()));
    const Works works = has_regions ? drawn_works() : Works{};
    const Index n_works = works.work.size();

    const Index n_random = n_sums * states.cols(), n_totals = 2 * std::ssize(_rest);
    Eigen::MatrixXf contributions = Eigen::MatrixXf::Zero(n_random + n_works + n_totals, n);
    VectorXd wanted = VectorXd::Zero(contributions.rows());
    std::atomic<std::int64_t> fitted = 0;
    for_each_index(static_cast<std::int32_t>(states.cols()), _threads, [&](std::int32_t s) {
      step();
      const auto state = integrands(states.col(s));
      if (!state) return;
      ++fitted;
      const auto& [of_forces, of_volumes] = tests[static_cast<std::size_t>(s)];
      const double size = solve_lower_transposed(inverse, states.col(s)).norm();
      auto [all, of_candidates] =
          sums_of(*state, candidates, transposed_product(inverse, of_forces) / size, of_volumes / size);
      if (_own_states) {
        // Where parts turn, the energy at rest in `size` is large, so that these states would count too little.
        const double norm = all.norm();
        all /= norm;
        of_candidates /= norm;
      }
      contributions.middleRows(n_sums * s, n_sums) = of_candidates.transpose().cast<float>();
      wanted.segment(n_sums * s, n_sums) = all;
    });
    const double random_scale = wanted.norm();
    for_each_index(static_cast<std::int32_t>(n_works), _threads, [&](std::int32_t w) {
      const VectorXd direction = works.states.col(w);
      const auto state = integrands(direction);
      if (!state) return;
      const double factor = weight_of_work / solve_lower_transposed(inverse, direction).squaredNorm();
      // Changes of volume are in the pressures, too, so that errors of their weights count twice.
      auto [all, of_candidates] = sums_of(*state, candidates, factor * direction, factor * state->pressures);
      if (std::isfinite(works.work[w])) all[0] = factor * (works.work[w] + state->pressures.squaredNorm());
      contributions.row(n_random + w) = of_candidates.transpose().cast<float>();
      wanted[n_random + w] = all[0];
    });
    // As heavy as all others together, the two totals of each part of the body are met.
    const double scale = wanted.norm();
    for (Index row = contributions.rows() - n_totals, p = 0; p < std::ssize(_rest); ++p)
      for (const VectorXd* all : {&_elements.shear, &_elements.bulk}) {
        const VectorXd size = restricted_to_part(*all, static_cast<std::size_t>(p));
        contributions.row(row) = (size(candidates.points) * (scale / size.sum())).cast<float>();
        wanted[row++] = scale;
      }
    _cubature = nonnegative_weights(contributions, wanted, cells, _threads, [this](Index n) { step(n); });
    _report.residual = _cubature.residual.head(n_random).norm() / random_scale;
    // Errors of shape and of volume cancel in the works, which a correction of the shape alone would undo.
    if (has_regions) _shape_at_rest.resize(0, 0);
    for (auto& point : _cubature.points) point = candidates.points[static_cast<std::size_t>(point)];
    _report.states = fitted;
  }

  /// @param nodes  ascending, with those of the surface
  ReducedBody body(const std::vector<std::int32_t>& nodes) {
    ReducedBody out;
    out.mesh_hash = _header.mesh_hash;
    out.physics_hash = _header.physics_hash;
    out.law = name(_elements.law);
    out.parameters = _elements.parts[0].parameters;
    out.bulk_in_shape_Pa = _elements.parts[0].bulk_in_shape_Pa;
    out.tool_radius_m = _scene.probe.tool_radius_m;
    out.depth_m = _header.magnitudes_m.back();
    out.relaxation = carried_relaxation(_scene);
    set_cells(out);
    out.nodes = nodes;
    set_surface(out);
    _report.cells = static_cast<std::int64_t>(_cubature.points.size());
    return out;
  }

  /// Scales modes so that their largest gradient is 1, and pressures so that the largest is 1.
  void set_cells(ReducedBody& out) {
    const auto& [points, weights, residual] = _cubature;
    const auto n = static_cast<Index>(points.size());
    const auto gradient = gradients(_elements.derivative_at(points), _modes);
    MatrixXd rows(9 * n, _modes.cols());
    for (Index k = 0; k < 9; ++k) rows(Eigen::seqN(k, n, 9), Eigen::all) = gradient[static_cast<std::size_t>(k)];
    VectorXd largest_of(_modes.cols());
    for (Index m = 0; m < _modes.cols(); ++m) {
      const double largest = largest_of[m] = scale_of(rows.col(m));
      rows.col(m) /= largest;
      _modes.col(m) /= largest;
    }
    out.gradients = scaled_table(rows);
    if (_shape_at_rest.size() > 0) {
      const MatrixXd scaled =
          largest_of.cwiseInverse().asDiagonal() * _shape_at_rest * largest_of.cwiseInverse().asDiagonal();
      MatrixXd of_cells = MatrixXd::Zero(_modes.cols(), _modes.cols());
      for (Index c = 0; c < n; ++c) {
        const MatrixXd cell = rows.middleRows(9 * c, 9);
        const auto point = static_cast<std::size_t>(points[static_cast<std::size_t>(c)]);
        of_cells += scaled_transposed_product(weights[c] * _elements.shear[static_cast<Index>(point)], cell,
                                              product(_rest[_elements.part_of[point]].shape, cell));
      }
      out.cells_at_rest = scaled_table(of_cells);
      out.lack_at_rest = scaled_table(scaled - of_cells);
    }
    MatrixXd pressures = product(_elements.pressure_values_at(points), _pressures);
    const double largest = scale_of(pressures);
    out.pressures = scaled_table(pressures / largest);
    for (Index c = 0; c < n; ++c) {
      out.shear_m3.push_back(weights[c] * _elements.shear[points[static_cast<std::size_t>(c)]]);
      out.bulk_rJ.push_back(weights[c] * _elements.bulk[points[static_cast<std::size_t>(c)]] * largest);
    }
    set_regions(out);
  }

  void set_regions(ReducedBody& out) const {
    const auto n = std::ssize(_elements.parts) - 1, n_parameters = std::ssize(out.parameters);
    if (n == 0) return;
    out.regions.resize(n, n_parameters + 1);
    for (Index r = 0; r < n; ++r) {
      const auto& [parameters, bulk_Pa] = _elements.parts[static_cast<std::size_t>(r) + 1];
      out.regions.row(r) << Eigen::Map<const Eigen::RowVectorXd>(parameters.data(), n_parameters), bulk_Pa;
    }
    for (const auto point : _cubature.points)
      out.region_of_cell.push_back(_elements.part_of[static_cast<std::size_t>(point)]);
  }

  void set_surface(ReducedBody& out) const {
    const NodeList touchable = touchable_nodes(_header.mesh, _header.sets, out.tool_radius_m);
    const auto n = static_cast<Index>(out.nodes.size());
    out.points = _header.mesh.nodes(out.nodes, Eigen::all);
    MatrixXd modes(3 * n, _modes.cols());
    for (Index i = 0; i < n; ++i) {
      const std::int32_t node = out.nodes[static_cast<std::size_t>(i)];
      out.kinds.push_back(std::ranges::binary_search(_header.sets.fixed, node) ? schema::body_node_fixed
                          : std::ranges::binary_search(touchable, node)        ? schema::body_node_touchable
                                                                               : schema::body_node_moves);
      for (Index k = 0; k < 3; ++k) modes.row(3 * i + k) = _modes.row(k * _elements.n_nodes + node);
    }
    for (Index m = 0; m < modes.cols(); ++m) {
      const double at = (static_cast<double>(m) + 0.5) / static_cast<double>(modes.cols());
      modes.col(m) /= std::sqrt(1 - _softest * std::max(0.0, (at - first_softened) / (1 - first_softened)));
    }
    out.modes = scaled_table(modes);
    out.surface = _header.mesh.surface.unaryExpr([&](std::int32_t node) {
      return static_cast<std::int32_t>(std::ranges::lower_bound(out.nodes, node) - out.nodes.begin());
    });
  }

  /// At the points whose response at rest is known, what the body lacks of it; none at probed nodes, and between all of
  /// them by the coordinates of the nodes. Roots of matrices are interpolated, so that the sum is semidefinite.
  void set_lacking(ReducedBody& out) {
    const auto& [mesh, sets] = std::tie(_header.mesh, _header.sets);
    const auto stiffness = stiffnesses_at_rest(out, sets.linear, _threads, [this] { step(); });
    Eigen::MatrixXd root_of = Eigen::MatrixXd::Zero(mesh.n_nodes(), schema::n_of_root);
    for (std::size_t i = 0; i < sets.linear.size(); ++i) {
      const auto rest = _database.at_rest(static_cast<std::int32_t>(i));
      const Eigen::Matrix3d whole = Eigen::Matrix3d::Map(rest.stiffness_N_per_m.data()).inverse();
      const auto eigen = symmetric_eigen3(whole - stiffness[i].inverse());
      const Eigen::Matrix3d root = eigen.with_values(eigen.values.cwiseMax(0).cwiseSqrt());
      root_of.row(sets.linear[i]) << root(0, 0), root(0, 1), root(0, 2), root(1, 1), root(1, 2), root(2, 2);
    }
    const auto places =
        probe_coordinates(mesh.nodes, mesh.surface, sets.active, sets.fixed, out.tool_radius_m, sets.linear);
    Eigen::MatrixXd lacking = Eigen::MatrixXd::Zero(std::ssize(out.nodes), schema::n_of_root);
    for (std::size_t i = 0; i < places.covered.size(); ++i) {
      const auto row = std::ranges::lower_bound(out.nodes, places.covered[i]) - out.nodes.begin();
      for (Index k = 0; k < 3; ++k)
        lacking.row(row) +=
            places.weights(static_cast<Index>(i), k) * root_of.row(places.triangles(places.triangle[i], k));
    }
    out.lacking = scaled_table(lacking);
  }

  const Database& _database;
  const DatabaseHeader& _header;
  const Scene _scene;
  MatrixXd _several;
  const ReductionSpec& _spec;
  ReductionReport& _report;
  const OnProgress& _progress;
  const int _threads;
  const OwnStates& _own_states;
  const Elements _elements;
  const std::vector<RestDerivatives> _rest;  ///< of the parts of the body
  const int _first_cells;                    ///< with weights, of the first body
  std::mutex _mutex;
  const Metric _metric = [this](const MatrixXd& u) { return laplace_of(u); };
  std::int64_t _done = 0, _steps = 0;
  double _energy = 0;  ///< int |grad u|^2 of all fields
  std::vector<std::size_t> _drawn;
  MatrixXd _states;             ///< 3 n_nodes x states that are drawn
  MatrixXd _shape_at_rest;      ///< stiffness of the shape in the modes
  double _softest = 0;          ///< of the last mode
  MatrixXd _modes, _pressures;  ///< orthonormal in laplace and in compressibility
  Cubature _cubature;
};

}  // namespace

ReducedBody reduce(const Database& database, MatrixXd several, const ReductionSpec& spec, ReductionReport& report,
                   const OnProgress& progress, int threads, const IsEnough& is_enough, const OwnStates& own_states) {
  const auto start = std::chrono::steady_clock::now();
  report = {};
  if (threads <= 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  ReducedBody body =
      Reduction(database, std::move(several), spec, report, progress, threads, own_states).run(is_enough);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return body;
}

}  // namespace phynness
