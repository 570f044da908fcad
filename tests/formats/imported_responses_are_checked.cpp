// Claims: imported responses are stored as they were given; what cannot be the responses of an elastic body, or has
// other units, is refused with the value and a remedy, and leaves no database.
#include <functional>
#include <phynness/formats/imported.hpp>
#include <phynness/meshes/tool_weights.hpp>

#include "database/hdf5_file.hpp"
#include "database_under_test.hpp"
#include "file_size_limit.hpp"

namespace phynness::test {
namespace {

/// Energy E = k |d|^2 (1 + s |d|^2) / 2 of a stiffening spring at two points of a tetrahedron.
constexpr double k = 40, s = 5000;

struct Given {
  std::vector<double> points{0, 0, 0, 0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1}, directions{1, 0, 0, 0, 2, 0, 0, 0, -1, 3, 0, 4},
      magnitudes{0.002, 0.005, 0.01}, forces, energies, displacements;
  std::vector<std::int64_t> cells{0, 2, 1, 3}, touched{1, 3}, output{0, 1, 3};
  std::vector<double> radius;  // of a round tool; none for single nodes
  std::string unit = "N";

  Given() {
    for (const auto node : touched)
      for (int d = 0; d < 4; ++d)
        for (const double m : magnitudes) {
          const Eigen::Vector3d x = m * Eigen::Vector3d::Map(&directions[3 * static_cast<std::size_t>(d)]).normalized();
          for (const double f : Eigen::Vector3d(k * (1 + 2 * s * m * m) * x)) forces.push_back(f);
          energies.push_back(k * m * m * (1 + s * m * m) / 2);
          for (const auto o : output)
            for (const double u : x) displacements.push_back(o == 0 ? 0 : o == node ? u : 0.25 * u);
        }
  }
};

struct Imports : DatabaseTest {
  fs::path given_file() const { return folder() / "given.h5"; }
  void write(const Given& g) const {
    fs::remove(given_file());
    auto out = hdf5::File::create(given_file(), 0);
    const auto put = [&](const char* name, const hdf5::Shape& shape, const auto& values,
                         const std::string& unit = "1") {
      if (values.empty()) return;
      using T = typename std::decay_t<decltype(values)>::value_type;
      out.create_dataset(name, hdf5::type_of(T{}).stored, shape, {}, unit, "");
      out.write_slab(name, 0, shape[0], values.data());
    };
    const hsize_t a = g.touched.size();
    put("/points", {g.points.size() / 3, 3}, g.points, "m");
    put("/tetrahedra", {g.cells.size() / 4, 4}, g.cells);
    put("/touched", {a}, g.touched);
    put("/output", {g.output.size()}, g.output);
    put("/tool_radius", {1}, g.radius, "m");
    put("/directions", {4, 3}, g.directions);
    put("/magnitudes", {3}, g.magnitudes, "m");
    put("/forces", {g.forces.size() / 36, 4, 3, 3}, g.forces, g.unit);
    put("/energies", {a, 4, 3}, g.energies, "J");
    put("/output_displacements", {a, 4, 3, g.output.size(), 3}, g.displacements, "m");
    out.close();
  }
  /// The message of the refusal; nothing is left behind.
  std::string refused(const std::function<void(Given&)>& change) {
    Given given;
    change(given);
    write(given);
    const auto said = refusal([&] { import_responses(given_file(), file, tools_of); });
    expect_names(said, {"remedy: "});
    EXPECT_FALSE(fs::exists(file) || fs::exists(log));
    return said;
  }
};

TEST_F(Imports, are_stored_as_given) {
  Given given;
  for (std::size_t i = 9; i < 18; ++i) given.forces[i] = std::nan("");  // node 1, direction 1 is left out
  write(given);
  const auto report = import_responses(given_file(), file, tools_of);
  EXPECT_EQ(report.rays, 7);
  EXPECT_EQ(report.missing_rays, 1);
  EXPECT_TRUE(report.against.empty());
  EXPECT_TRUE(report.energy_over_work > 0.25 && report.energy_over_work < 0.5) << "it stiffens";
  const auto database = Database::open(file);
  const auto& header = database.header();
  EXPECT_TRUE(header.imported);
  EXPECT_EQ(header.sets.active, (std::vector<std::int32_t>{1, 3}));
  EXPECT_EQ(header.directions[3], (Vec3{0.6, 0, 0.8}));
  EXPECT_EQ(header.mesh.surface.rows(), 4);
  for (std::int32_t a = 0; a < 2; ++a)
    for (const auto& ray : database.rays(a)) {
      const auto at = 12 * static_cast<std::size_t>(a) + 3 * static_cast<std::size_t>(ray.direction);
      if (at == 3) {
        EXPECT_EQ(ray.status, std::vector<Status>(3, Status::not_requested));
        continue;
      }
      EXPECT_EQ(ray.status, std::vector<Status>(3, Status::converged));
      for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(ray.force[i], given.forces[3 * at + i]);
      for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(ray.energy[i], given.energies[at + i]);
      for (std::size_t i = 0; i < 27; ++i)
        EXPECT_EQ(ray.displacement[i], static_cast<float>(given.displacements[9 * at + i]));
    }
  EXPECT_THROW(require_scene(header), Error);
  EXPECT_EQ(stored_scene(header).title, "given.h5");
  // Another scene's responses are not those of imported ones.
  EXPECT_EQ(coverage(header, small_header(false)), Coverage::other);
  expect_names(refusal([&] { import_responses(given_file(), file, tools_of); }), {"exists", "choose another name"});
}

TEST_F(Imports, leave_nothing_on_a_full_disk) {
  write(Given());
  for (const rlim_t bytes : {100, 4000, 12000}) {
    const FileSizeLimit full(bytes);
    const auto said = refusal([&] { import_responses(given_file(), file, tools_of); }, Error::Kind::failure);
    expect_names(said, {"cannot write", "import again"});
    EXPECT_EQ(std::distance(fs::directory_iterator(folder()), fs::directory_iterator()), 1) << bytes;  // what is given
  }
}

TEST_F(Imports, name_rays_whose_forces_point_against_the_displacement) {
  Given given;
  given.radius = {0.02};
  for (std::size_t i = 0; i < 9; ++i) given.forces[i] *= -1;  // one ray of eight
  write(given);
  EXPECT_EQ(import_responses(given_file(), file, tools_of).against, (std::vector<std::string>{"node 1, direction 0"}));
}

TEST_F(Imports, of_round_tools_whose_mean_is_elsewhere_are_refused) {
  Given given;
  given.radius = {0.02};
  given.output = {0, 1, 2, 3};  // all that the tool moves, with it
  given.displacements.clear();
  for (int ray = 0; ray < 8; ++ray)
    for (const double m : given.magnitudes)
      for (int o = 0; o < 4; ++o)
        for (const double u : Eigen::Vector3d(
                 m * Eigen::Vector3d::Map(&given.directions[static_cast<std::size_t>(ray % 4 * 3)]).normalized()))
          given.displacements.push_back(u);
  const auto swapped = [&](Given& g) {
    g = given;
    for (std::size_t i = 0; i < g.displacements.size(); i += 3) std::swap(g.displacements[i], g.displacements[i + 1]);
  };
  expect_names(refused(swapped), {"the mean under the round tool", "order of the axes"});
  write(given);
  EXPECT_EQ(import_responses(given_file(), file, tools_of).rays, 8);
  // Beside fixed nodes weights have a sum below 1, and another program's may not.
  std::filesystem::remove(file);
  const auto beside_fixed = [](const auto&... of) {
    auto tools = tools_of(of...);
    for (auto& tool : tools)
      for (double& w : tool.weights) w *= 0.5;
    return tools;
  };
  EXPECT_EQ(import_responses(given_file(), file, beside_fixed).rays, 8);
}

TEST_F(Imports, are_refused_in_words) {
  const auto says = [&](const char* words, const std::function<void(Given&)>& change) {
    expect_names(refused(change), {words});
  };
  says("/forces is missing", [](Given& g) { g.forces.clear(); });
  says("/forces has the wrong shape: [1, 4, 3, 3] instead of [2, 4, 3, 3]", [](Given& g) { g.forces.resize(36); });
  says("/forces has another unit: mN", [](Given& g) { g.unit = "mN"; });
  says("neither", [](Given& g) { g.cells.clear(); });
  says("direction twice: row 1", [](Given& g) { std::copy_n(g.directions.begin(), 3, g.directions.begin() + 3); });
  says("/touched must hold numbers of points: 4", [](Given& g) { g.touched = {1, 4}; });
  says("/touched must ascend", [](Given& g) { g.touched = {3, 1}; });
  says("implausible size: its diagonal is 173.2 m", [](Given& g) {
    for (auto& x : g.points) x *= 1000;
  });
  says("not finite: node 1, direction 2, increment 1", [](Given& g) { g.forces[22] = std::nan(""); });
  says("point against the displacements", [](Given& g) {
    for (auto& f : g.forces) f = -f;
  });
  says("energies are not those of the forces", [](Given& g) {
    for (auto& e : g.energies) e *= 1000;
  });
  says("follow the tool: node 1, direction 0, increment 0, output node 1",
       [](Given& g) { g.displacements[3] = 0.001; });
  says("ten times", [](Given& g) { g.displacements[0] = 0.1; });
}

}  // namespace
}  // namespace phynness::test
