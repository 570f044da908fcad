#include "picture_thread.hpp"

#include <algorithm>
#include <chrono>

namespace {

int32_t n_output(const phn_model* model) {
  phn_info info;
  phn_model_info(model, &info);
  return info.n_output;
}

}  // namespace

PictureThread::PictureThread(Latest<Touch>& touch, const phn_model* model, phn_data* data, int32_t node,
                             double frames_per_s)
    : _touch(touch),
      _model(model),
      _data(data),
      _field(3 * static_cast<std::size_t>(n_output(model))),
      _thread([this, node, frames_per_s] { run(node, frames_per_s); }) {}

void PictureThread::stop() {
  _stop = true;
  if (_thread.joinable()) _thread.join();
}

void PictureThread::run(int32_t node, double frames_per_s) {
  using Clock = std::chrono::steady_clock;
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / frames_per_s));
  phn_prepare(_model, _data, node);
  for (auto next = Clock::now(); !_stop; next += period) {
    std::this_thread::sleep_until(next);
    Touch touch;
    if (!_touch.read(touch)) continue;
    const auto start = Clock::now();
    const double d[3] = {touch.displacement.x, touch.displacement.y, touch.displacement.z};
    double force[3];
    const int32_t n_held = touch.held.nodes[0] >= 0 ? 1 : 0;
    const int status = !touch.anywhere ? phn_deform(_model, _data, node, d, _field.data())
                       : phn_couple(_model, _data, n_held, &touch.held, force, nullptr) < 0
                           ? PHN_ERROR_ARGUMENT
                           : phn_coupled_deform(_model, _data, _field.data());
    if (status < 0) continue;
    _slowest_us = std::max(_slowest_us, std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    for (std::size_t i = 0; i < _field.size(); i += 3)
      _largest_m = std::max(_largest_m, length({_field[i], _field[i + 1], _field[i + 2]}));
    ++_frames;
  }
}
