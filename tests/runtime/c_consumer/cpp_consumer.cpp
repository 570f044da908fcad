// The wrapper is C++17, works without exceptions, and gives statuses of the C library.
#include <cstdio>
#include <phynness/phynness.hpp>

int main() {
  const phynness::rt::Model model("hello");
  phynness::rt::Data data(model, 1);
  const double d[3] = {0, 0, 0.01};
  double force[3] = {1, 1, 1}, deformation[3] = {1, 1, 1};
  const phynness::rt::Status status = data.force(1, d, force);
#ifdef OVERLOOK
  data.force(1, d, force);
#endif
  std::printf("phynness %s: %s\n", phn_version(), model.status().message());
  return !model && model.status() == PHN_ERROR_NOT_A_MODEL && status == PHN_ERROR_ARGUMENT && force[2] == 0 &&
                 data.deform(1, d, deformation) == PHN_ERROR_ARGUMENT
             ? 0
             : 1;
}
