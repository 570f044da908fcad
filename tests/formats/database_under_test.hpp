// A small database with every kind of content, in a folder of its own.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>
#include <random>
#include <string>
#include <vector>

#include "../messages.hpp"

namespace phynness::test {

namespace fs = std::filesystem;

inline const std::string database_scene = R"([mesh]
shape = "block"
[material]
law = "neo-hookean"
c10_Pa = 250.0
bulk_modulus_Pa = 100e3
[solver]
element = "P1"
[nodes]
fixed = { nodes = [0] }
[probe]
max_displacement_m = 0.02
increments = 3
)";

inline DatabaseHeader small_header(bool float64, const std::string& scene = database_scene) {
  DatabaseHeader h;
  h.mesh.nodes.resize(6, 3);
  h.mesh.nodes << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1, 0.1, -0.3, 1.0 / 3;
  h.mesh.cells.resize(2, 4);
  h.mesh.cells << 0, 1, 2, 3, 1, 2, 3, 4;
  h.mesh.surface = boundary_triangles(h.mesh.cells);
  h.mesh.groups["left / right"] = {0, 2};
  h.mesh.groups["empty"] = {};
  h.mesh.regions = {0, 1};
  h.sets.fixed = {0};
  h.sets.active = {1, 2, 4};
  h.sets.tools = single_nodes(h.sets.active);
  h.sets.output = {1, 2, 3, 4};
  h.directions = exploratory_directions(Directions::twenty_six);
  h.directions.resize(7);
  h.magnitudes_m = {0.01 / 3, 0.02 / 3, 0.02};
  h.tangents = true;
  h.float64 = float64;
  h.scene_text = scene;
  h.scene_name = "small.toml";
  h.scene_folder = "/somewhere";
  h.software_version = "phynness test";
  return h;
}

inline RayEnd random_end(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  RayEnd end;
  end.reason = every_end[random() % std::size(every_end)].code;
  end.depth_m = 0.02 * static_cast<double>(random() % 65) / 64;
  end.fold_depth_m = end.reason == EndReason::fold ? end.depth_m + 0.0003 : 0;
  end.energy_lost_J = end.reason == EndReason::fold ? normal(random) : 0;
  return end;
}

inline void expect_same_end(const RayEnd& found, const RayEnd& expected) {
  EXPECT_EQ(found.reason, expected.reason);
  EXPECT_EQ(found.depth_m, expected.depth_m);
  EXPECT_EQ(found.fold_depth_m, expected.fold_depth_m);
  EXPECT_EQ(found.energy_lost_J, expected.energy_lost_J);
}

/// Random but reproducible; every third ray fails at its last increment.
inline Ray random_ray(const DatabaseHeader& h, int active, int direction) {
  std::mt19937_64 random(static_cast<std::uint64_t>(1000 * active + direction + 1));
  std::normal_distribution<double> normal;
  const std::size_t n = h.magnitudes_m.size();
  const auto numbers = [&](std::size_t count) {
    std::vector<double> v(count);
    for (double& x : v) x = normal(random);
    return v;
  };
  Ray r = empty_ray(h, active, direction);
  r.status.assign(n, Status::converged);
  if ((active + direction) % 3 == 0) r.status.back() = Status::inverted;
  r.force = numbers(3 * n);
  r.energy = numbers(n);
  if (h.tangents) r.tangent = numbers(9 * n);
  r.negative_pivots.assign(n, direction == 2 ? 1 : 0);
  r.iterations.assign(n, 4 + active);
  r.cutbacks.assign(n, direction);
  r.min_jacobian = numbers(n);
  r.seconds = numbers(n);
  for (double& s : r.seconds) s = std::abs(s);
  r.displacement = numbers(3 * n * h.sets.output.size());
  for (auto& field : r.fields) field = numbers(n * h.sets.output.size());
  r.end = random_end(random);
  return r;
}

inline std::vector<Ray> all_rays(const DatabaseHeader& h) {
  std::vector<Ray> rays;
  for (int a = 0; a < static_cast<int>(h.sets.active.size()); ++a)
    for (int d = 0; d < static_cast<int>(h.directions.size()); ++d) rays.push_back(random_ray(h, a, d));
  return rays;
}

inline std::vector<char> bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}
inline void write_bytes(const fs::path& file, const std::vector<char>& bytes) {
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// A fresh folder that goes with the test.
class DatabaseTest : public testing::Test {
 protected:
  DatabaseTest() {
    std::string pattern = (fs::temp_directory_path() / "phynness-database-XXXXXX").string();
    _folder = ::mkdtemp(pattern.data());
    file = _folder / "responses.h5";
    log = file.string() + ".log";
  }
  ~DatabaseTest() override {
    std::error_code code;
    fs::permissions(_folder, fs::perms::owner_all, code);
    fs::remove_all(_folder, code);
  }
  const fs::path& folder() const { return _folder; }

  /// Spreads the rays over `n_logs` logs and leaves the database unpacked.
  void write_logs(const DatabaseHeader& header, int n_logs = 1) {
    DatabaseWriter::create(file, header, false);
    const auto rays = all_rays(header);
    for (int rank = 0; rank < n_logs; ++rank) {
      DatabaseWriter writer(file, header, rank);
      for (std::size_t i = static_cast<std::size_t>(rank); i < rays.size(); i += static_cast<std::size_t>(n_logs))
        writer.append(rays[i]);
      writer.close();
    }
  }

  void write_database(const DatabaseHeader& header, int n_logs = 1) {
    write_logs(header, n_logs);
    DatabaseWriter::pack(file, header);
  }

  /// The message of the Error that `work` throws; fails the test if it throws none.
  template <class Work>
  static std::string refusal(Work&& work, Error::Kind kind = Error::Kind::input) {
    const auto message = message_of(work, kind);
    expect_names(message, {"remedy: "});
    return message;
  }

  fs::path file, log;

 private:
  fs::path _folder;
};

}  // namespace phynness::test
