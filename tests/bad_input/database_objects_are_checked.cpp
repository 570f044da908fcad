// Claim: an object of the wrong kind in a database is refused with its name before any of its contents is read:
// attributes and datasets of any type or shape.
#include <array>

#include "bad_database.hpp"

namespace phynness::test {
namespace {

class ForeignObjects : public BadDatabase {
 protected:
  ForeignObjects() { write_packed(); }

  void replace_attribute(const char* name, hid_t type, hid_t space, const void* values) {
    tamper([&](hid_t id) {
      H5Adelete(id, name);
      const hid_t attribute = H5Acreate2(id, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
      ASSERT_GE(attribute, 0);
      if (values) {
        ASSERT_GE(H5Awrite(attribute, type, values), 0);
      }
      H5Aclose(attribute);
      H5Sclose(space);
    });
  }
  void replace_dataset(const char* name, hid_t type, const std::vector<hsize_t>& shape) {
    tamper([&](hid_t id) {
      H5Ldelete(id, name, H5P_DEFAULT);
      const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
      const hid_t set = H5Dcreate2(id, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
      ASSERT_GE(set, 0);
      H5Dclose(set);
      H5Sclose(space);
    });
  }
  static hid_t vector_of(hsize_t n) { return H5Screate_simple(1, &n, nullptr); }
};

TEST_F(ForeignObjects, attributes_with_more_values_than_one_do_not_reach_the_stack) {
  const std::vector<std::int32_t> many(1000, 0x41414141);
  for (const char* name : {"format_version", "complete", "tangents"}) {
    write_packed_again();
    replace_attribute(name, H5T_STD_I32LE, vector_of(many.size()), many.data());
    expect_names(open_error(), {name, "[1000]", "damaged"});
  }
  const std::vector<const char*> texts(100, "phynness database");
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, H5T_VARIABLE);
  for (const char* name : {"format", "physics_hash", "scene_name"}) {
    write_packed_again();
    replace_attribute(name, text, vector_of(texts.size()), texts.data());
    expect_names(open_error(), {name, "[100]"});
  }
  H5Tclose(text);
}

TEST_F(ForeignObjects, attributes_of_another_type) {
  const double number = 1;
  replace_attribute("complete", H5T_IEEE_F64LE, H5Screate(H5S_SCALAR), &number);
  expect_names(open_error(), {"complete", "float64"});
  write_packed_again();
  replace_attribute("mesh_hash", H5T_IEEE_F64LE, H5Screate(H5S_SCALAR), &number);
  expect_names(open_error(), {"mesh_hash", "float64"});
  write_packed_again();
  replace_attribute("tangents", H5T_STD_I32LE, H5Screate(H5S_NULL), nullptr);
  expect_names(open_error(), {"tangents", "damaged"});
  write_packed_again();
  const std::int64_t large = std::int64_t{1} << 40;
  replace_attribute("format_version", H5T_STD_I64LE, H5Screate(H5S_SCALAR), &large);
  expect_names(open_error(), {"format_version", "1099511627776"});
}

TEST_F(ForeignObjects, texts_of_fixed_length_are_texts) {
  const auto hash = Database::open(file).header().mesh_hash;
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, 40);
  std::array<char, 40> padded{};
  std::copy(hash.begin(), hash.end(), padded.begin());
  replace_attribute("mesh_hash", type, H5Screate(H5S_SCALAR), padded.data());
  H5Tclose(type);
  EXPECT_EQ(Database::open(file).header().mesh_hash, hash);
}

TEST_F(ForeignObjects, datasets_of_another_type) {
  const hid_t pair = H5Tcreate(H5T_COMPOUND, 16);
  H5Tinsert(pair, "a", 0, H5T_IEEE_F64LE);
  H5Tinsert(pair, "b", 8, H5T_IEEE_F64LE);
  for (const hid_t type : {H5T_STD_I64LE, H5T_IEEE_F64LE, H5T_STD_REF_OBJ, H5T_C_S1, pair}) {
    write_packed_again();
    replace_dataset("/sets/fixed", type, {0});
    expect_names(open_error(), {"/sets/fixed has the wrong type", "instead of int32"});
  }
  H5Tclose(pair);
}

// Numbers under a right checksum, which another program wrote.
TEST_F(ForeignObjects, numbers_that_are_none_of_the_mesh) {
  const auto write = [&](const char* name, hid_t type, const void* first) {
    write_packed_again();
    tamper([&](hid_t id) {
      const hid_t set = H5Dopen2(id, name, H5P_DEFAULT), all = H5Dget_space(set), one = vector_of(1);
      const hsize_t start = 0, count = 1;
      H5Sselect_hyperslab(all, H5S_SELECT_SET, &start, nullptr, &count, nullptr);
      ASSERT_GE(H5Dwrite(set, type, one, all, H5P_DEFAULT, first), 0);
      H5Sclose(one);
      H5Sclose(all);
      H5Dclose(set);
    });
  };
  for (const std::int32_t number : {-3, 999999})
    for (const char* name : {"/sets/active", "/sets/output", "/tools/nodes"}) {
      write(name, H5T_NATIVE_INT32, &number);
      expect_names(open_error(), {name, " has a number that no node has", std::to_string(number).c_str()});
    }
  const double negative = -0.01;
  write("/magnitudes", H5T_NATIVE_DOUBLE, &negative);
  expect_names(open_error(), {"/magnitudes must ascend from 0"});
}

TEST_F(ForeignObjects, groups_that_are_datasets) {
  tamper([](hid_t id) {
    H5Ldelete(id, "/sets", H5P_DEFAULT);
    H5Lcreate_hard(id, "/directions", id, "/sets", H5P_DEFAULT, H5P_DEFAULT);
  });
  expect_names(open_error(), {"/sets/fixed is missing"});
}

}  // namespace
}  // namespace phynness::test
