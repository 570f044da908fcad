// Claim: every number of a database that is used as an index, a count or a divisor, and every response that is used, is
// checked when it is read. The message names dataset, entry and value.
#include <cmath>
#include <limits>

#include "bad_database.hpp"

namespace phynness::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

class WrongNumbers : public BadDatabase {
 protected:
  WrongNumbers() { write_packed(); }

  /// Changes one value of a dataset and makes the hash of the mesh that of the changed one.
  template <class T>
  void set(const char* name, std::size_t at, T value) {
    tamper([&](hid_t id) {
      const hid_t set = H5Dopen2(id, name, H5P_DEFAULT), space = H5Dget_space(set);
      const hid_t type = std::is_same_v<T, double> ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT32;
      std::vector<T> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
      ASSERT_LT(at, values.size());
      ASSERT_GE(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
      values[at] = value;
      ASSERT_GE(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
      H5Sclose(space);
      H5Dclose(set);
    });
  }
  void expect_refused(std::initializer_list<const char*> parts) {
    expect_contains(open_error(), parts);
    write_packed_again();
  }
  /// Of reading everything.
  std::string rays_error() {
    return refusal([&] {
      const Database database = Database::open(file);
      for (std::int32_t a = 0; a < 3; ++a) database.rays(a);
      summarize(database);
    });
  }
};

TEST_F(WrongNumbers, nodes_that_the_mesh_does_not_have) {
  for (const std::int32_t node : {std::numeric_limits<std::int32_t>::max(), -1, 6}) {
    const std::string value = std::to_string(node);
    set("/mesh/surface", 4, node);
    expect_refused({"/mesh/surface", "entry [1, 1]", value.c_str(), "of 6 nodes"});
    for (const char* name : {"/sets/fixed", "/sets/active", "/sets/output", "/mesh/groups/1"}) {
      set(name, 0, node);
      expect_refused({name, "entry [0]", value.c_str(), "of 6 nodes"});
    }
  }
  set("/sets/active", 1, std::int32_t{1});
  expect_refused({"/sets/active", "ascending", "1 after 1"});
}

TEST_F(WrongNumbers, directions_and_magnitudes_of_no_probe) {
  for (const double value : {nan, inf, 0.0, -1.5, 1e300}) {
    set("/directions", 0, value);
    expect_refused({"/directions", "length 1", "entry [0]"});
    set("/magnitudes", 1, value);
    expect_refused({"/magnitudes", "ascending", "entry [1]"});
  }
  set("/magnitudes", 2, 1e4);
  expect_refused({"/magnitudes", "100 diagonals of the body"});
}

TEST_F(WrongNumbers, coordinates_and_cells_are_refused_even_under_the_right_hash) {
  const auto refused = [&](auto&& change) {
    auto header = small_header(true);
    change(header);
    return refusal([&] { DatabaseWriter::create(folder() / "other.h5", header, false); });
  };
  expect_contains(refused([](auto& h) { h.mesh.nodes(2, 1) = nan; }), {"/mesh/nodes", "entry [2, 1]", "nan"});
  expect_contains(refused([](auto& h) { h.mesh.nodes *= 1e200; }), {"/mesh/nodes", "diagonal"});
  expect_contains(refused([](auto& h) { h.mesh.nodes.setZero(); }), {"/mesh/nodes", "diagonal"});
  expect_contains(refused([](auto& h) { h.mesh.cells(1, 3) = 6; }), {"/mesh/cells", "entry [1, 3]", "6 of 6"});
  expect_contains(refused([](auto& h) { h.mesh.cells = Cells::Zero(2, 5); }), {"/mesh/cells", "3 or 4"});
  expect_contains(refused([](auto& h) { h.mesh_hash = "not a hash"; }), {"mesh_hash", "not a hash"});
}

TEST_F(WrongNumbers, flags_and_words_that_mean_nothing) {
  set_attribute("tangents", 7);
  expect_refused({"tangents", "neither 0 nor 1", "7"});
  set_attribute("complete", -1);
  expect_refused({"complete", "neither 0 nor 1", "-1"});
}

TEST_F(WrongNumbers, responses_that_cannot_be) {
  const auto expect_named = [&](const char* name, const char* value) {
    expect_contains(rays_error(), {name, value, "damaged"});
    write_packed_again();
  };
  // Entry 3: the second increment of the first ray and more; all of the first two converged in the second.
  for (const char* name : {"/responses/force", "/responses/energy", "/responses/displacement", "/responses/tangent",
                           "/responses/min_jacobian"}) {
    const std::size_t second_ray = std::string_view(name).ends_with("energy") ? 3 : 40;
    set(name, std::string_view(name).ends_with("jacobian") ? 3 : second_ray, nan);
    expect_named(name, "nan");
  }
  set("/responses/displacement", 40, 1e300);
  expect_named("/responses/displacement", "1e+300");
  set("/responses/seconds", 3, -1.0);
  expect_named("/responses/seconds", "-1");
  set("/responses/status", 0, std::int32_t{4});
  expect_named("/responses/status", "4");
  for (const char* name : {"/responses/iterations", "/responses/negative_pivots", "/responses/cutbacks"}) {
    set(name, 0, std::int32_t{-1});
    expect_named(name, "-1");
  }
}

TEST_F(WrongNumbers, ends_that_cannot_be) {
  const auto expect_named = [&](const char* name, const char* value) {
    expect_contains(rays_error(), {name, value, "damaged"});
    EXPECT_THROW(Database::open(file).ends(), Error);
    write_packed_again();
  };
  set("/responses/end_reason", 0, std::int32_t{5});
  expect_named("/responses/end_reason", "5");
  for (const char* name : {"/responses/end_depth", "/responses/fold_depth"}) {
    set(name, 0, -1.0);
    expect_named(name, "-1");
  }
  for (const char* name : {"/responses/end_depth", "/responses/fold_depth", "/responses/energy_lost"}) {
    set(name, 0, nan);
    expect_named(name, "nan");
  }
}

// Their checksums are right: a program wrote them so.
TEST_F(WrongNumbers, records_of_logs_that_cannot_be_are_dropped) {
  const auto header = small_header(true);
  fs::remove(file);
  DatabaseWriter::create(file, header, false);
  DatabaseWriter writer(file, header, 0);
  for (int d = 0; d < 7; ++d) {
    Ray ray = random_ray(header, 1, d);
    ray.status[0] = Status::converged;
    if (d == 1) ray.force[0] = nan;
    if (d == 2) ray.status[1] = static_cast<Status>(77);
    if (d == 3) ray.displacement[0] = 1e300;
    if (d == 4) ray.iterations[2] = -1;
    writer.append(ray);
  }
  writer.close();
  const auto progress = database_progress(file);
  EXPECT_EQ(progress.rays_logged, 3);
  ASSERT_FALSE(progress.damage.empty());
  expect_contains(progress.damage.front().reason, {"numbers"});
}

}  // namespace
}  // namespace phynness::test
