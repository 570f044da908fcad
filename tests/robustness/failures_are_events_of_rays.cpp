// Claim: a failure of a library call inside a solve ends at most the ray of this solve. No process ends, the database
// is complete, all rays without failures are identical, and converged increments of the others are the same equilibria.
//
// Failures are caused in the libraries (petsc_faults.hpp): a factorization gets a singular matrix, one with NaN, or
// no memory, and calls of PETSc fail. A ray that continues after a failure uses other steps, so that its forces
// agree to 1e-6 of the largest force of the ray, the effect of a relative residual of 1e-8.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/precompute.hpp>
#include <random>
#include <set>

#include "petsc_faults.hpp"
#include "probe_block.hpp"
#include "solve/discretization.hpp"
#include "solve/equilibrium.hpp"
#include "solver_test_session.hpp"
#include "study/solver_log.hpp"

namespace phynness::test {
namespace {

/// Sets the hook for the life of this object: of all calls a fixed share fails, chosen at random. After every fourth
/// failure of a kind, all further calls of its ray fail.
class RandomFaults {
 public:
  RandomFaults(std::uint64_t seed, double share) : _random(seed), _share(share) {
    fault_hook = [this](FaultSite site) { return next(site); };
  }
  ~RandomFaults() { fault_hook = {}; }
  RandomFaults(const RandomFaults&) = delete;

  /// Contexts of the solver's log in which something failed.
  const std::set<std::string>& where() const { return _where; }
  const std::map<std::pair<FaultSite, Fault>, int>& count() const { return _count; }

 private:
  Fault next(FaultSite site) {
    const auto context = SolverLog::instance().context();
    if (context != _hopeless && std::uniform_real_distribution<double>()(_random) >= _share * weight(site))
      return Fault::none;
    static const std::map<FaultSite, std::vector<Fault>> kinds{
        {FaultSite::factorization,
         {Fault::singular, Fault::out_of_memory, Fault::not_finite, Fault::petsc_error, Fault::bad_alloc}},
        {FaultSite::substitution, {Fault::not_finite, Fault::petsc_error, Fault::bad_alloc}}};
    const auto& of_site = kinds.at(site);
    const auto fault = of_site[std::uniform_int_distribution<std::size_t>(0, of_site.size() - 1)(_random)];
    _where.insert(context);
    if (++_count[{site, fault}] % 4 == 0 && context.find("direction") != std::string::npos) _hopeless = context;
    return fault;
  }
  /// Rare calls fail more often, so that all kinds occur.
  static double weight(FaultSite site) { return site == FaultSite::substitution ? 1 : 5; }

  std::mt19937_64 _random;
  double _share;
  std::set<std::string> _where;
  std::string _hopeless = "none";
  std::map<std::pair<FaultSite, Fault>, int> _count;
};

class Failures : public ::testing::TestWithParam<Element> {
 protected:
  void SetUp() override {
    _block = probe_block({law_named("neo-hookean"), GetParam()}, 50, {6, 4, 4});
    auto& scene = _block.scene;
    scene.probe.directions = Directions::twenty_six;
    scene.probe.increments = 3;
    scene.probe.max_displacement_m = 0.012;
    scene.database.float64 = true;
    scene.database.fields = {Field::von_mises_stress};
    _block.sets.active.clear();
    for (std::int32_t i = 0; i < _block.mesh.n_nodes(); ++i) {
      const auto x = _block.mesh.nodes.row(i);
      const bool inside = x[0] > 0.01 && x[0] < 0.09 && x[1] > 0.01 && x[1] < 0.07;
      if (x[2] == block_size_m[2] && inside && _block.sets.active.size() < 8) _block.sets.active.push_back(i);
    }
    _block.sets.output = _block.sets.active;
    _block.sets.tools = single_nodes(_block.sets.active);
    _folder = std::filesystem::path(::testing::TempDir()) /
              ("failures-" + element_name({GetParam(), 0}) + "-" + std::to_string(::getpid()));
    std::filesystem::remove_all(_folder);
    std::filesystem::create_directories(_folder);
  }
  void TearDown() override { std::filesystem::remove_all(_folder); }

  PrecomputeReport run(const char* file, bool resume = false, const std::function<bool()>& stop = {},
                       const PrecomputeProgress& progress = {}) {
    return precompute(solver_session(), _block.scene, _block.mesh, _block.sets, {_folder / file, resume, {}, {}},
                      progress, stop);
  }
  std::vector<Ray> rays(const char* file) {
    const auto database = Database::open(_folder / file);
    std::vector<Ray> all;
    for (std::size_t a = 0; a < _block.sets.active.size(); ++a)
      for (auto& ray : database.rays(static_cast<std::int32_t>(a))) all.push_back(std::move(ray));
    return all;
  }
  std::string context(const Ray& ray) const {
    return "node " + std::to_string(_block.sets.active[static_cast<std::size_t>(ray.active)]) + ", direction " +
           std::to_string(ray.direction);
  }

  ProbeBlock _block;
  std::filesystem::path _folder;
};

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

/// What a ray that met failures still says must be true.
void expect_true_as_far_as_it_goes(const Ray& expected, const Ray& got) {
  double scale = 0;
  for (const double f : expected.force) scale = std::max(scale, std::abs(f));
  bool ended = false;
  for (std::size_t i = 0; i < got.status.size(); ++i) {
    if (got.status[i] != Status::converged) {
      EXPECT_LT(static_cast<int>(got.status[i]), 0);
      ended = true;
      continue;
    }
    EXPECT_FALSE(ended) << "converged after a failure";
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) EXPECT_NEAR(got.force[k], expected.force[k], 1e-6 * scale);
  }
}

TEST_P(Failures, OfLibrariesEndOnlyTheRaysThatMeetThem) {
  run("clean.h5");
  const auto clean = rays("clean.h5");
  ASSERT_EQ(clean.size(), 208u);

  std::set<std::string> faulty;
  PrecomputeReport report;
  {
    RandomFaults faults(7, 1e-2);
    report = run("faulty.h5");
    faulty = faults.where();
    std::set<Fault> kinds;
    for (const auto& [what, n] : faults.count()) kinds.insert(what.second);
    EXPECT_EQ(kinds.size(), 5u) << "not every kind of failure occurred";
  }
  ASSERT_TRUE(Database::is_complete(_folder / "faulty.h5"));
  const auto got = rays("faulty.h5");
  ASSERT_EQ(got.size(), clean.size());
  int untouched = 0, recovered = 0, failed = 0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    SCOPED_TRACE(context(clean[i]));
    if (faulty.contains(context(clean[i]))) {
      expect_true_as_far_as_it_goes(clean[i], got[i]);
      const bool whole = got[i].status == clean[i].status;
      ++(whole ? recovered : failed);
    } else {
      ++untouched;
      EXPECT_EQ(got[i].status, clean[i].status);
      EXPECT_TRUE(same_bits(got[i].force, clean[i].force));
      EXPECT_TRUE(same_bits(got[i].energy, clean[i].energy));
      EXPECT_TRUE(same_bits(got[i].displacement, clean[i].displacement));
    }
  }
  std::printf("%d rays untouched, %d recovered, %d failed, %lld with library errors\n", untouched, recovered, failed,
              static_cast<long long>(report.library_errors));
  EXPECT_GT(untouched, 50);
  EXPECT_GT(recovered, 20);
  EXPECT_GT(failed, 2);
  EXPECT_GT(report.library_errors, 0);
  std::ifstream log(_folder / "faulty.h5.solver.log");
  const std::string text((std::istreambuf_iterator<char>(log)), {});
  EXPECT_NE(text.find("injected by a test"), std::string::npos) << "PETSc's message is not in the log";
}

TEST_P(Failures, OfFactorizationsAreTheirOwnAndLeaveNoTrace) {
  // The two kinds of failure that a factorization itself reports, each followed by one that must not know of it.
  _block = probe_block({law_named("neo-hookean"), GetParam()}, 50, {10, 8, 6});
  Discretization body(_block.mesh, form_set(unit_material(law_named("neo-hookean"), 50), GetParam(), 1));
  std::vector<std::int32_t> fixed;
  for (const auto node : _block.sets.fixed)
    for (const auto dof : body.dofs(node)) fixed.push_back(dof);
  const std::vector<double> rest(body.n_dofs(), 0.0);
  Equilibrium equilibrium(body, fixed, SolverSpec{});
  const auto linearize = [&] { return equilibrium.linearize(rest, Eigen::MatrixXd(0, 0)); };
  ASSERT_EQ(linearize().status, Status::converged);
  for (const auto fault : {Fault::singular, Fault::out_of_memory}) {
    SCOPED_TRACE(fault == Fault::singular ? "singular" : "out of memory");
    fault_hook = [&](FaultSite site) { return site == FaultSite::factorization ? fault : Fault::none; };
    for (int twice = 0; twice < 2; ++twice) {
      if (fault == Fault::singular)
        EXPECT_EQ(linearize().status, Status::factorization);
      else
        EXPECT_THROW(linearize(), Error);
    }
    fault_hook = {};
    EXPECT_EQ(linearize().status, Status::converged);
    EXPECT_EQ(linearize().negative_pivots, 0);
  }
}

TEST_P(Failures, OfEveryFactorizationEndTheRunAndUseUpNoRay) {
  // A rank that can begin no ray must not record all rays as failed before others get to them.
  fault_hook = [](FaultSite site) { return site == FaultSite::factorization ? Fault::petsc_error : Fault::none; };
  EXPECT_THROW(run("none.h5"), Error);
  fault_hook = {};
  const auto report = run("none.h5", true);
  EXPECT_EQ(report.rays_resumed, 0);
  EXPECT_EQ(report.rays, 208);
  EXPECT_EQ(report.library_errors, 0);
  EXPECT_TRUE(Database::is_complete(_folder / "none.h5"));
}

TEST_P(Failures, DoNotComeBackWithResume) {
  std::int64_t finished = 0;
  {
    // The 60th ray is under way when the end is wanted, and is finished.
    RandomFaults faults(8, 4e-3);
    EXPECT_TRUE(run(
                    "resumed.h5", false, [&] { return finished >= 59; },
                    [&](std::int64_t done, std::int64_t) { finished = done; })
                    .interrupted);
  }
  const auto report = run("resumed.h5", true);
  EXPECT_EQ(report.rays_resumed, 60);
  EXPECT_EQ(report.library_errors, 0);
  EXPECT_TRUE(Database::is_complete(_folder / "resumed.h5"));
}

INSTANTIATE_TEST_SUITE_P(Elements, Failures, ::testing::Values(element_named("P1"), element_named("p1-p1")),
                         element_name);

}  // namespace
}  // namespace phynness::test
