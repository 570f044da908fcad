// Claims: fields are read from a database as float32, rounded once. A database is not continued with other fields. One
// without fields contains no bytes for them.

#include "database_under_test.hpp"

namespace phynness::test {
namespace {

DatabaseHeader header_with(std::vector<Field> fields) {
  auto header = small_header(true);
  header.fields = std::move(fields);
  return header;
}
const std::vector<Field> both{Field::von_mises_stress, Field::energy_density};

class StoredFields : public DatabaseTest {};

TEST_F(StoredFields, ComeBackAsFloat32) {
  for (const auto& fields : {both, std::vector<Field>{Field::energy_density}}) {
    fs::remove(file);
    const auto header = header_with(fields);
    write_logs(header, 2);
    EXPECT_EQ(read_database_header(file).fields, fields);  // unfinished
    DatabaseWriter::pack(file, header);
    const auto database = Database::open(file);
    EXPECT_EQ(database.header().fields, fields);
    for (std::int32_t a = 0; a < 3; ++a)
      for (const Ray& ray : database.rays(a)) {
        const Ray expected = random_ray(header, a, ray.direction);
        EXPECT_EQ(ray.displacement, expected.displacement);
        ASSERT_EQ(ray.fields.size(), fields.size());
        for (std::size_t f = 0; f < fields.size(); ++f) {
          ASSERT_EQ(ray.fields[f].size(), expected.fields[f].size());
          for (std::size_t i = 0; i < ray.fields[f].size(); ++i)
            EXPECT_EQ(ray.fields[f][i], static_cast<double>(static_cast<float>(expected.fields[f][i])));
        }
      }
  }
}

TEST_F(StoredFields, AreRefusedIfTheRayHasNone) {
  const auto header = header_with(both);
  DatabaseWriter::create(file, header, false);
  DatabaseWriter writer(file, header, 0);
  auto ray = random_ray(header, 0, 0);
  ray.fields.pop_back();
  refusal([&] { writer.append(ray); }, Error::Kind::failure);
}

TEST_F(StoredFields, AreTheSameOnResume) {
  const auto header = header_with(both);
  write_logs(header);
  for (const auto& fields : {std::vector<Field>{}, std::vector<Field>{Field::von_mises_stress}})
    expect_names(refusal([&] { DatabaseWriter::create(file, header_with(fields), true); }),
                 {"other [database] fields", "von-mises-stress, energy-density in the file",
                  fields.empty() ? "none now" : "von-mises-stress now"});
  // The header is gone, the logs are not: they say themselves that they hold something else.
  fs::remove(file);
  DatabaseWriter::create(file, header_with({Field::energy_density}), true);
  EXPECT_NE(refusal([&] { DatabaseWriter::logged(file, header_with({Field::energy_density})); }).find("another scene"),
            std::string::npos);
}

TEST_F(StoredFields, LeaveNoTraceWhereThereAreNone) {
  const auto header = header_with({});
  write_database(header);
  const auto bytes = bytes_of(file);
  const std::string text(bytes.begin(), bytes.end());
  EXPECT_EQ(text.find("von-mises"), std::string::npos);
  EXPECT_EQ(text.find("/responses/fields"), std::string::npos);
  EXPECT_TRUE(Database::open(file).rays(0).front().fields.empty());
}

}  // namespace
}  // namespace phynness::test
