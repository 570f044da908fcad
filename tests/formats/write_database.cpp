// Writes a small packed database, for tests in other languages; with "fields", one with all fields.
// Usage: write_database FILE [fields | OUTPUT_NODE ...]
#include <cstdlib>
#include <cstring>

#include "database_under_test.hpp"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  using namespace phynness;
  auto header = test::small_header(true);
  if (argc > 2 && std::strcmp(argv[2], "fields") == 0) {
    header.fields.assign(every_field.begin(), every_field.end());
  } else if (argc > 2) {
    header.sets.output.clear();
    for (int i = 2; i < argc; ++i) header.sets.output.push_back(std::atoi(argv[i]));
  }
  header.sets.linear = {3};
  header.sets.linear_tools = {{{1, 3}, {0.25, 0.75}, true}};
  DatabaseWriter::create(argv[1], header, false);
  DatabaseWriter writer(argv[1], header, 0);
  for (const auto& ray : test::all_rays(header)) writer.append(ray);
  writer.close();
  DatabaseWriter::pack(argv[1], header, {}, [&](std::int32_t) {
    return AtRest{{3, 1, 0, 1, 4, 0, 0, 0, 5}, std::vector<double>(9 * header.sets.output.size(), 0.5)};
  });
}
