#include <algorithm>
#include <chrono>
#include <phynness/validation/model_figures.hpp>

namespace phynness {
namespace {

/// The median over several batches of the mean time of a call in a batch [us].
template <typename Call>
double median_us(int batches, int calls, const Call& call) {
  std::vector<double> times;
  for (int b = 0; b < batches; ++b) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < calls; ++i) call(i);
    const std::chrono::duration<double, std::micro> elapsed = std::chrono::steady_clock::now() - start;
    times.push_back(elapsed.count() / calls);
  }
  std::nth_element(times.begin(), times.begin() + batches / 2, times.end());
  return times[static_cast<std::size_t>(batches / 2)];
}

}  // namespace

RuntimeSpeed measure_speed(const NamedOrgan& model) {
  const auto nodes = model.active_nodes();
  if (nodes.size() == 0) return {};
  Organ& organ = model.organ();
  const double depth = model.info().max_displacement_m;
  std::vector<double> u(3 * static_cast<std::size_t>(model.info().n_output));
  double f[3], checksum = 0;
  // The displacement changes from call to call, as that of a moving hand.
  const auto displacement = [&](int i, Vec3& d) {
    for (int k = 0; k < 3; ++k) d[static_cast<std::size_t>(k)] = depth * 0.01 * ((i * (k + 3)) % 50);
  };
  RuntimeSpeed speed;
  speed.force_us = median_us(15, 200, [&](int i) {
    Vec3 d;
    displacement(i, d);
    organ.hold(tool_at(nodes[static_cast<std::size_t>(i) % nodes.size()], d), f).ignore();
    checksum += f[0];
  });
  // A tool stays at a node for many frames, so that the preparation of the node is not measured.
  std::vector<double> times;
  for (std::size_t b = 0; b < 7; ++b) {
    const auto node = nodes[b * nodes.size() / 7];
    phn_tool tool = tool_at(node, Vec3{});
    phn_prepare(organ.model(), organ.data(), &tool);
    times.push_back(median_us(1, 5, [&](int i) {
      Vec3 d;
      displacement(i, d);
      tool = tool_at(node, d);
      phn_deform(organ.model(), organ.data(), &tool, u.data());
      checksum += u[0];
    }));
  }
  std::nth_element(times.begin(), times.begin() + 3, times.end());
  organ.hold(tool_at(nodes[0], Vec3{}), f).ignore();
  if (organ.deform(u).ok()) speed.deformation_us = times[3];
  if (model.info().n_fields > 0)
    speed.field_us = median_us(7, 5, [&](int i) {
      Vec3 d;
      displacement(i, d);
      const phn_tool tool = tool_at(nodes[static_cast<std::size_t>(i) % nodes.size()], d);
      phn_field(organ.model(), organ.data(), &tool, 0, u.data());
      checksum += u[0];
    });
  volatile double keep = checksum;  // prevents the compiler from removing the calls
  static_cast<void>(keep);
  return speed;
}

double measure_step_us(const NamedOrgan& body, std::span<const std::int32_t> nodes) {
  Organ& organ = body.organ();
  organ.reset().ignore();
  const double depth = body.body_info().max_displacement_m;
  std::vector<phn_tool> tools(nodes.size());
  std::vector<double> forces(3 * nodes.size());
  int calls = 0;
  // From rest to half of the depth and back.
  return median_us(9, 100, [&](int) {
    const int at = calls++ % 100;
    const double part = 0.01 * (at < 50 ? at : 100 - at);
    for (std::size_t t = 0; t < nodes.size(); ++t)
      tools[t] = tool_at(nodes[t], Vec3{depth * part * 0.6, 0, -depth * part * 0.8});
    phn_body_force(organ.body(), organ.state(), static_cast<std::int32_t>(tools.size()), tools.data(), 1, forces.data(),
                   nullptr);
  });
}

}  // namespace phynness
