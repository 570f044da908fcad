// Claim: for each reason why a database cannot be read or started there is a separate message with the file and a
// remedy.
#include "../as_nobody.hpp"
#include "bad_database.hpp"

namespace phynness::test {
namespace {

TEST_F(BadDatabase, that_does_not_exist) { expect_names(open_error(), {"does not exist", file.c_str(), "precompute"}); }

TEST_F(BadDatabase, that_is_a_folder) {
  expect_names(refusal([&] { Database::open(folder()); }),
               {"is a folder", folder().c_str(), "give the name of a file in it"});
}

TEST_F(BadDatabase, that_is_no_hdf5) {
  write_bytes(file, {'h', 'e', 'l', 'l', 'o'});
  expect_names(open_error(), {"HDF5", file.c_str()});
  write_bytes(file, {});
  expect_names(open_error(), {"HDF5", file.c_str()});
}

TEST_F(BadDatabase, that_is_hdf5_of_another_kind) {
  H5Fclose(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  expect_names(open_error(), {"phynness database", file.c_str()});
}

TEST_F(BadDatabase, of_another_format_version) {
  write_packed();
  set_attribute("format_version", format_version + 1);
  expect_names(open_error(), {"another version of the format", "phynness precompute SCENE -o DATABASE"});
}

TEST_F(BadDatabase, that_is_truncated) {
  write_packed();
  const auto whole = bytes_of(file);
  for (std::size_t part : {1u, 2u, 3u}) {
    write_bytes(file, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(part * whole.size() / 4)});
    expect_names(open_error(), {"truncated", file.c_str()});
  }
}

TEST_F(BadDatabase, that_is_unfinished) {
  const auto header = small_header(true);
  DatabaseWriter::create(file, header, false);
  {
    DatabaseWriter writer(file, header, 0);
    for (int d = 0; d < 5; ++d) writer.append(random_ray(header, 0, d));
  }
  expect_names(open_error(), {"unfinished", "5 of 21 rays", "--resume", file.c_str()});
}

TEST_F(BadDatabase, with_a_dataset_missing) {
  write_packed();
  tamper([](hid_t id) { H5Ldelete(id, "/responses/energy", H5P_DEFAULT); });
  expect_names(open_error(), {"/responses/energy is missing", "damaged"});
}

TEST_F(BadDatabase, with_a_mesh_that_was_changed) {
  write_packed();
  tamper([](hid_t id) {
    const hid_t nodes = H5Dopen2(id, "/mesh/nodes", H5P_DEFAULT);
    const std::vector<double> zeros(18, 0.0);
    H5Dwrite(nodes, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, zeros.data());
    H5Dclose(nodes);
  });
  expect_names(open_error(), {"mesh", file.c_str(), "hash"});
}

TEST_F(BadDatabase, with_a_code_that_is_none) {
  for (const char* column : {"/responses/status", "/responses/end_reason"}) {
    fs::remove(file);
    write_packed();
    tamper([&](hid_t id) {
      const hid_t codes = H5Dopen2(id, column, H5P_DEFAULT), space = H5Dget_space(codes);
      const std::vector<std::int8_t> sevens(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)), 77);
      EXPECT_GE(H5Dwrite(codes, H5T_NATIVE_INT8, H5S_ALL, H5S_ALL, H5P_DEFAULT, sevens.data()), 0);
      H5Sclose(space);
      H5Dclose(codes);
    });
    expect_names(refusal([&] { Database::open(file).rays(0); }), {column, "77", file.c_str()});
  }
}

// Data is under fletcher32, metadata under the checksums of the 1.10 format, the mesh under its hash. Texts
// are not: HDF5 keeps those of variable length in heaps without a checksum (and trusts what it reads there),
// so these are left out.
TEST_F(BadDatabase, with_any_changed_byte_gives_the_right_numbers_or_none) {
  const auto header = small_header(true);
  write_packed();
  const auto rays = all_rays(header);
  const auto whole = bytes_of(file);
  std::vector<char> in_heap(whole.size(), 0);
  constexpr std::size_t heap_bytes = 4096;
  const std::string_view signature = "GCOL", text(whole.data(), whole.size());
  for (auto at = text.find(signature); at != text.npos; at = text.find(signature, at + 1))
    std::fill_n(in_heap.begin() + static_cast<std::ptrdiff_t>(at), std::min(heap_bytes, whole.size() - at), char{1});
  ASSERT_LT(std::count(in_heap.begin(), in_heap.end(), char{1}), static_cast<std::ptrdiff_t>(whole.size() / 2));

  int refused = 0, read = 0;
  constexpr std::size_t stride = 29;  // prime, so that every place within a field has its turn
  for (std::size_t at = 0; at < whole.size(); at += stride) {
    if (in_heap[at]) continue;
    auto changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 0x5a);
    write_bytes(file, changed);
    try {
      const Database database = Database::open(file);
      std::size_t next = 0;
      for (std::int32_t active = 0; active < 3; ++active)
        for (const Ray& ray : database.rays(active)) {
          ASSERT_EQ(ray.force, rays[next].force) << at;
          ASSERT_EQ(ray.status, rays[next].status) << at;
          ASSERT_EQ(ray.displacement, rays[next++].displacement) << at;
        }
      ASSERT_EQ(database.header().sets.output, header.sets.output) << at;
      ASSERT_EQ(database.header().directions, header.directions) << at;
      ASSERT_EQ(database.header().magnitudes_m, header.magnitudes_m) << at;
      ++read;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0);
  std::printf("%d changed bytes refused, %d without effect\n", refused, read);
}

TEST_F(BadDatabase, begun_in_a_folder_that_is_missing_or_not_writable) {
  const auto header = small_header(true);
  expect_names(refusal([&] { DatabaseWriter::create(folder() / "no" / "x.h5", header, false); }),
               {"does not exist", "mkdir"});
  for (const bool resume : {false, true})
    expect_names(refusal([&] { DatabaseWriter::create(folder(), header, resume); }), {"is a folder", "database.h5"});
  fs::permissions(folder(), fs::perms::owner_read | fs::perms::owner_exec);
  const AsNobody as_nobody;
  expect_names(refusal([&] { DatabaseWriter::create(file, header, false); }), {"not writable", folder().c_str()});
}

}  // namespace
}  // namespace phynness::test
