// Prints the answers of phynness::Organ bit by bit, for comparison with those of bindings/csharp (Answers.cs), which
// makes the same calls. Usage: answers MODEL|- BODY|-
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <phynness/phynness.hpp>
#include <vector>

namespace {

void print(const char* what, int status, const double* numbers, std::size_t n) {
  std::printf("%s %d", what, status);
  for (std::size_t i = 0; i < n; ++i) {
    std::uint64_t bits;
    std::memcpy(&bits, numbers + i, sizeof(bits));
    std::printf(" %016" PRIx64, bits);
  }
  std::printf("\n");
}

/// Xor of the bits, so that a field is one number.
double mixed(const std::vector<double>& field) {
  std::uint64_t all = 0, bits = 0;
  for (const double x : field) {
    std::memcpy(&bits, &x, sizeof(bits));
    all = (all << 1 | all >> 63) ^ bits;
  }
  double out;
  std::memcpy(&out, &all, sizeof(out));
  return out;
}

/// Of a linear congruential generator, in 0 ... 1.
double random(std::uint32_t& state) {
  state = state * 1664525u + 1013904223u;
  return static_cast<double>(state >> 8) / 16777216.0;
}

}  // namespace

int main(int, char** argv) {
  const auto given = [&](int i) { return std::strcmp(argv[i], "-") == 0 ? nullptr : argv[i]; };
  auto organ = phynness::Organ::read(given(1), given(2), 2);
  if (!organ) return 1;
  const bool has_model = organ.model() != nullptr;
  const double* points = has_model ? organ.info().output_points : organ.body_info().points;
  const auto n = static_cast<std::size_t>(has_model ? organ.info().n_output : organ.body_info().n_nodes);
  const double depth = has_model ? organ.info().max_displacement_m : organ.body_info().max_displacement_m;
  std::printf("%zu nodes\n", n);

  std::uint32_t state = 1;
  std::vector<double> field(organ.n_deform());
  double top[3] = {0, 0, -1e300};
  for (std::size_t i = 0; i < n; ++i)
    if (points[3 * i + 2] > top[2]) std::memcpy(top, points + 3 * i, sizeof(top));
  phn_relaxing history{};
  for (int call = 0; call < 100; ++call) {
    phn_tool tools[2];
    double force[3]{}, forces[6]{}, bounds[1]{}, point[3]{}, distance = 0, energy = 0;
    phynness::OrganReport report;
    for (auto& tool : tools) {
      double x[3];
      for (std::size_t k = 0; k < 3; ++k)
        x[k] = points[3 * (static_cast<std::size_t>(call) % n) + k] + 0.3 * depth * random(state);
      print("nearest", organ.nearest(x, tool, point, distance), &distance, 1);
      for (double& d : tool.displacement) d = depth * (random(state) - 0.5);
    }
    print("point", 0, point, 3);
    print("hold", organ.hold(tools[0], force, energy), force, 3);
    print("energy", 0, &energy, 1);
    if (call == 50) history.outward[2] = 1;
    print("relax", phn_relax(&organ.relaxation(), &history, force, point, 0.01, force), force, 3);
    print("deform", organ.deform(field), field.data(), 0);
    const double one = mixed(field);
    print("field", 0, &one, 1);
    print("bound", organ.bound(bounds), bounds, 1);
    print("two", organ.hold(phynness::Span<const phn_tool>(tools, 2), forces, &report), forces, 6);
    print("energy", 0, &report.energy_J, 1);
  }
  for (int call = 0; call < 300; ++call) {
    phn_contact_tool spheres[2]{};
    phn_contact_state states[2]{};
    phynness::OrganReport report;
    for (int s = 0; s < 2; ++s) {
      auto& sphere = spheres[s];
      sphere = {
          {top[0] + (s - 0.5) * depth, top[1], top[2] + 2 * depth - 0.01 * depth * call}, 0.3 * depth, 0.3, s + 1, 0};
    }
    const bool one = !organ.body();  // a model of round tools answers one
    print("touch", organ.touch({spheres, one ? 1u : 2u}, {states, one ? 1u : 2u}, &report), states[0].force, 9);
    print("second", states[0].in_contact, states[1].force, 9);
    print("energy", 0, &report.energy_J, 1);
  }
  print("deform", organ.deform(field), field.data(), 0);
  const double last = mixed(field);
  print("field", 0, &last, 1);
  print("reset", organ.reset(), &last, 0);
  return 0;
}
