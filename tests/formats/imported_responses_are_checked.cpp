// Claims: imported responses are stored as they were given, whatever their order; what cannot be the responses of an
// elastic body, or has other units, is refused with the value and a remedy.
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>
#include <phynness/formats/imported.hpp>
#include <random>

#include "database_under_test.hpp"

namespace phynness {
namespace {

namespace fs = std::filesystem;

/// Energy E = k |d|^2 (1 + s |d|^2) / 2 of a stiffening spring at each touched point of a tetrahedron.
constexpr double k = 40, s = 5000;

struct Imports : test::DatabaseTest {
  static GivenResponses springs(int rows_of_each = 40) {
    GivenResponses given;
    given.source = "springs";
    given.points_m.resize(4, 3);
    given.points_m << 0, 0, 0, 0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1;
    given.cells.resize(1, 4);
    given.cells << 0, 1, 2, 3;
    given.fixed = {0};
    const int n = 2 * rows_of_each;
    given.displacements_m.resize(n, 3);
    given.forces_N.resize(n, 3);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> part(-0.01, 0.01);
    for (int i = 0; i < n; ++i) {
      given.touched.push_back(i % 2 == 0 ? 3 : 1);
      // Both points have the same displacements.
      if (i % 2 == 0)
        given.displacements_m.row(i) << part(random), part(random), part(random);
      else
        given.displacements_m.row(i) = given.displacements_m.row(i - 1);
      const Eigen::Vector3d d = given.displacements_m.row(i);
      given.forces_N.row(i) = k * (1 + 2 * s * d.squaredNorm()) * d;
      given.energies_J.push_back(k * d.squaredNorm() * (1 + s * d.squaredNorm()) / 2);
    }
    // Output points in no order; the third moves half as far, and the fixed one not at all.
    given.output = {3, 0, 2, 1};
    const Points d = given.displacements_m;
    const auto touched = given.touched;
    given.output_displacements = [d, touched](std::int64_t row, double* u) {
      const bool is_top = touched[static_cast<std::size_t>(row)] == 3;
      for (int c = 0; c < 3; ++c) {
        u[c] = (is_top ? 1 : 0.25) * d(row, c);
        u[3 + c] = 0;
        u[6 + c] = 0.5 * d(row, c);
        u[9 + c] = (is_top ? 0.25 : 1) * d(row, c);
      }
    };
    return given;
  }

  /// The message of the refusal; nothing is left behind.
  std::string refusal(const std::function<void(GivenResponses&)>& change) {
    auto given = springs();
    change(given);
    std::string said = "it was imported";
    try {
      import_responses(std::move(given), folder() / "refused.h5");
      fs::remove(folder() / "refused.h5");
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), Error::Kind::input);
      said = error.what();
      EXPECT_NE(said.find("\n  remedy: "), std::string::npos) << said;
    }
    EXPECT_FALSE(fs::exists(folder() / "refused.h5") || fs::exists(folder() / "refused.h5.log"));
    return said;
  }
};

TEST_F(Imports, AreStoredAsGiven) {
  auto given = springs();
  std::swap(given.cells(0, 0), given.cells(0, 1));  // turned inside out
  const auto report = import_responses(given, folder() / "d.h5");
  EXPECT_EQ(report.rows, 80);
  EXPECT_EQ(report.displacements, 40);
  EXPECT_EQ(report.notes.size(), 1U);
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_TRUE(report.energy_over_work > 0.25 && report.energy_over_work < 0.5)
      << "it stiffens: 1/2 at rest, 1/4 far away";
  EXPECT_LT(report.path_dependence, 0.1);

  const auto database = Database::open(folder() / "d.h5");
  const auto& header = database.header();
  EXPECT_TRUE(header.is_imported());
  EXPECT_EQ(header.sets.active, (std::vector<std::int32_t>{1, 3}));
  EXPECT_EQ(header.sets.output, (std::vector<std::int32_t>{0, 1, 2, 3}));
  EXPECT_EQ(header.mesh.surface.rows(), 4);
  const Points prescribed = prescribed_displacements(header);
  for (std::int32_t a = 0; a < 2; ++a) {
    std::vector<int> found(40, 0);
    for (const auto& ray : database.rays(a))
      for (std::size_t i = 0; i < ray.status.size(); ++i) {
        if (ray.status[i] != Status::converged) continue;
        const auto n = static_cast<Eigen::Index>(ray.status.size());
        const Eigen::RowVector3d d = prescribed.row(n * ray.direction + static_cast<Eigen::Index>(i));
        const auto nearest =
            std::max_element(header.directions.begin(), header.directions.end(),
                             [&](auto& e, auto& g) { return d.dot(to_eigen(e)) < d.dot(to_eigen(g)); });
        EXPECT_EQ(nearest - header.directions.begin(), ray.direction);
        if (i > 0) {
          EXPECT_GE(d.norm(), prescribed.row(n * ray.direction + static_cast<Eigen::Index>(i) - 1).norm());
        }
        for (Eigen::Index row = 1 - a; row < 80; row += 2) {
          if (given.displacements_m.row(row) != d) continue;
          ++found[static_cast<std::size_t>(row / 2)];
          EXPECT_EQ(Eigen::RowVector3d::Map(&ray.force[3 * i]), given.forces_N.row(row));
          EXPECT_EQ(ray.energy[i], given.energies_J[static_cast<std::size_t>(row)]);
          for (int c = 0; c < 3; ++c) {  // stored as float32
            EXPECT_EQ(ray.displacement[12 * i + static_cast<std::size_t>(c)], 0);
            EXPECT_EQ(ray.displacement[12 * i + 6 + static_cast<std::size_t>(c)], static_cast<float>(0.5 * d[c]));
            EXPECT_EQ(ray.displacement[12 * i + 9 + static_cast<std::size_t>(c)],
                      static_cast<float>((a == 1 ? 1 : 0.25) * d[c]));
          }
        }
      }
    EXPECT_EQ(found, std::vector<int>(40, 1)) << "node " << header.sets.active[static_cast<std::size_t>(a)];
  }
  EXPECT_EQ(summarize_ends(database).share_of_rays(), 0);
  EXPECT_THROW(require_scene(header), Error);
  EXPECT_EQ(stored_scene(header).title, "springs");
}

TEST_F(Imports, OrderAndRepetitionsDoNotMatter) {
  import_responses(springs(), folder() / "once.h5");
  auto given = springs();
  const auto once = springs();
  // Backwards, with every row twice and a row at rest.
  given.displacements_m.resize(161, 3), given.forces_N.resize(161, 3);
  given.energies_J.resize(161), given.touched.resize(161);
  const auto row_of = [](std::int64_t i) { return 79 - i % 80; };
  for (std::int64_t i = 0; i < 160; ++i) {
    const auto from = static_cast<std::size_t>(row_of(i));
    given.displacements_m.row(i) = once.displacements_m.row(row_of(i));
    given.forces_N.row(i) = once.forces_N.row(row_of(i));
    given.energies_J[static_cast<std::size_t>(i)] = once.energies_J[from];
    given.touched[static_cast<std::size_t>(i)] = once.touched[from];
  }
  given.displacements_m.row(160).setZero();
  given.forces_N.row(160) << 0, 0, -1e-3;  // noise
  given.energies_J[160] = 0, given.touched[160] = 3;
  given.output_displacements = [&](std::int64_t i, double* u) {
    i < 160 ? once.output_displacements(row_of(i), u) : static_cast<void>(std::fill_n(u, 12, 0.0));
  };
  const auto report = import_responses(given, folder() / "twice.h5");
  EXPECT_EQ(report.at_rest, 1);
  EXPECT_EQ(report.repeated, 80);
  const auto a = Database::open(folder() / "once.h5"), b = Database::open(folder() / "twice.h5");
  EXPECT_EQ(prescribed_displacements(a.header()), prescribed_displacements(b.header()));
  for (std::int32_t node = 0; node < 2; ++node) {
    const auto one = a.rays(node), other = b.rays(node);
    for (std::size_t r = 0; r < one.size(); ++r) {
      EXPECT_EQ(one[r].status, other[r].status);
      EXPECT_EQ(one[r].force, other[r].force);
      EXPECT_EQ(one[r].displacement, other[r].displacement);
    }
  }
}

TEST_F(Imports, AreRefusedInWords) {
  using Given = GivenResponses;
  const auto says = [&](const std::string& words, const std::function<void(Given&)>& change) {
    const auto said = refusal(change);
    EXPECT_NE(said.find(words), std::string::npos) << said;
  };
  const double nan = std::nan("");
  says("no responses: 0 rows",
       [](Given& g) { g.displacements_m.resize(0, 3), g.forces_N.resize(0, 3), g.touched = {}; });
  says("too many responses: 1000001 rows",
       [](Given& g) { g.displacements_m = Points::Ones(most_imported_rows + 1, 3); });
  says("80 displacements and 79 forces", [](Given& g) { g.forces_N = Points(g.forces_N.topRows(79)); });
  says("80 displacements and 79 touched nodes", [](Given& g) { g.touched.pop_back(); });
  says("80 displacements and 81 energies", [](Given& g) { g.energies_J.push_back(1); });
  says("forces are not finite: row 7", [&](Given& g) { g.forces_N(7, 1) = nan; });
  says("displacements are not finite: row 8", [&](Given& g) { g.displacements_m(8, 2) = INFINITY; });
  says("an energy is not finite: row 9", [&](Given& g) { g.energies_J[9] = nan; });
  says("coordinates of points are not finite: row 2", [&](Given& g) { g.points_m(2, 0) = nan; });
  says("a body needs points", [](Given& g) { g.cells.resize(0, 4); });
  says("3 or 4 corners: 2", [](Given& g) { g.cells = Cells::Zero(1, 2); });
  says("cell 0 has 4 of 4 points", [](Given& g) { g.cells(0, 3) = 4; });
  says("a tetrahedron has no volume: cell 0", [](Given& g) { g.cells(0, 3) = 2; });
  says("touched nodes must be numbers of points: entry 5 is -1", [](Given& g) { g.touched[5] = -1; });
  says("an output node is given twice: 3", [](Given& g) { g.output[1] = 3; });
  says("a fixed node is touched: row 1, node 1", [](Given& g) { g.fixed = {1}; });
  says("need displacements", [](Given& g) { g.output_displacements = nullptr; });
  says("implausible size: its diagonal is 173.2 m", [](Given& g) { g.points_m *= 1000; });
  says("longer than the body: ", [](Given& g) { g.displacements_m *= 1000; });
  says("radius of the tool is impossible: 30 m", [](Given& g) { g.tool_radius_m = 30; });
  says("all displacements are zero", [](Given& g) { g.displacements_m.setZero(); });
  says("all forces are zero", [](Given& g) { g.forces_N.setZero(); });
  says("point against the displacements: mean cosine -1", [](Given& g) { g.forces_N *= -1; });
  says("energies are not those of the forces: the median of energy / (force . displacement) is -0.", [](Given& g) {
    for (auto& e : g.energies_J) e *= -1;
  });
  says("energies are not those of the forces", [](Given& g) {
    for (auto& e : g.energies_J) e *= 1000;
  });
  says("force at rest is not zero: row 4", [](Given& g) { g.displacements_m.row(4).setZero(); });
  says("two different forces: rows 0 and 2", [](Given& g) {
    g.displacements_m.row(2) = g.displacements_m.row(0);
    g.forces_N.row(0) << 3, 0, 0;
    g.forces_N.row(2) << 0, 3, 0;
  });
  says("too few displacements of node 1: 5", [](Given& g) {
    for (std::size_t i = 11; i < 80; i += 2) g.touched[i] = 3;
    for (int i = 0; i < 80; ++i) g.displacements_m(i, 0) += 1e-6 * i;  // none twice
    g.output = {}, g.output_displacements = nullptr;
  });
  says("depends on the path", [](Given& g) {
    // Half of the spring, and a force across the displacement.
    for (int i = 0; i < 80; ++i) {
      const Eigen::Vector3d d = g.displacements_m.row(i);
      g.forces_N.row(i) = (4 * d + 40 * Eigen::Vector3d(0, 0, 1).cross(d)).transpose();
    }
    g.energies_J = {};
  });
  const auto moved = [](Given& g, int output, double by) {
    g.output_displacements = [old = g.output_displacements, output, by](std::int64_t row, double* u) {
      old(row, u);
      if (row == 6) u[3 * output] += by;
    };
  };
  says("touched node does not follow the tool: row 6, node 3", [&](Given& g) { moved(g, 0, 1e-3); });
  says("a fixed node moves: row 6, node 0", [&](Given& g) { moved(g, 1, 1e-3); });
  says("ten times as far as the tool: row 6, node 2", [&](Given& g) { moved(g, 2, 0.5); });
  says("not finite: row 6, node 2", [&](Given& g) { moved(g, 2, nan); });
  EXPECT_EQ(refusal([](Given&) {}), "it was imported");

  std::ofstream(folder() / "there.h5") << "kept";
  EXPECT_THROW(import_responses(springs(), folder() / "there.h5"), Error);
  EXPECT_EQ(fs::file_size(folder() / "there.h5"), 4U);
}

TEST_F(Imports, AnInterruptionWritesNothing) {
  std::int64_t written = 0;
  EXPECT_THROW(import_responses(
                   springs(), folder() / "d.h5", [&](std::int64_t done, std::int64_t) { written = done; },
                   [&] { return written == 20; }),
               Error);
  EXPECT_EQ(written, 20);
  EXPECT_TRUE(fs::is_empty(folder()));
  import_responses(springs(), folder() / "d.h5", [&](std::int64_t done, std::int64_t all) { written = all - done; });
  EXPECT_EQ(written, 0);
}

// The noise of 3 % makes a curl that is larger than its error by chance only, and no more than one part in ten.
TEST_F(Imports, NoiseIsNoPath) {
  auto given = springs(100);
  std::mt19937_64 random(2);
  std::normal_distribution<double> noise(0, 0.03 * given.forces_N.rowwise().norm().maxCoeff());
  for (auto& f : given.forces_N.reshaped()) f += noise(random);
  const auto report = import_responses(given, folder() / "noise.h5");
  EXPECT_LT(report.path_dependence, 0.1);
}

TEST_F(Imports, DoubtsAreWarnings) {
  auto given = springs();
  given.points_m *= 15;
  EXPECT_EQ(import_responses(given, folder() / "large.h5").warnings.size(), 1U);
  given = springs();
  given.forces_N *= 1e-5;
  given.energies_J = {};
  const auto report = import_responses(given, folder() / "soft.h5");
  ASSERT_EQ(report.warnings.size(), 1U);
  EXPECT_NE(report.warnings[0].find("newtons"), std::string::npos);
  EXPECT_EQ(report.energy_over_work, 0);
}

// Another scene's responses are not those of imported ones, in both directions.
TEST_F(Imports, AreNotResumed) {
  import_responses(springs(), folder() / "d.h5");
  const auto header = test::small_header(false);
  EXPECT_THROW(DatabaseWriter::create(folder() / "d.h5", header, true), Error);
  EXPECT_THROW(Database::open(folder() / "d.h5", header), Error);
  EXPECT_EQ(coverage(read_database_header(folder() / "d.h5"), header), Coverage::other);
}

}  // namespace
}  // namespace phynness
