// Writes a small packed database to the path given, for the h5py test; with "symmetric", one with a mirror
// plane.
#include "database_under_test.hpp"

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) return 2;
  using namespace phynness;
  auto header = test::small_header(true);
  if (argc == 3) {
    MirrorSymmetry mirror;
    mirror.normal = {1, 0, 0};
    mirror.image = {0, 2, 1, 3, 4, 5};
    header.sets.mirror = mirror;
  }
  DatabaseWriter::create(argv[1], header, false);
  DatabaseWriter writer(argv[1], header, 0);
  for (const auto& ray : test::all_rays(header)) writer.append(ray);
  writer.close();
  DatabaseWriter::pack(argv[1], header);
}
