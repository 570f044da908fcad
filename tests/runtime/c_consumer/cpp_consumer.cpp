// The wrapper is C++17, works without exceptions and RTTI, and gives statuses of the C library.
#include <cstdio>
#include <phynness/phynness.hpp>

int main() {
  phynness::Organ organ("hello");
  const phn_tool tool = {{1, -1, -1}, {1, 0, 0}, {0, 0, 0.01}};
  double force[3] = {1, 1, 1}, deformation[3] = {1, 1, 1};
  const phynness::Organ::Status status = organ.hold(tool, force);
#ifdef OVERLOOK
  organ.hold(tool, force);
#endif
  std::printf("phynness %s: %s\n", phn_version(), organ.status().message());
  return !organ && organ.status() == PHN_ERROR_NOT_A_MODEL && status == PHN_ERROR_ARGUMENT && force[2] == 0 &&
                 organ.deform(deformation) == PHN_ERROR_ARGUMENT
             ? 0
             : 1;
}
