// The work of a renderer: in each frame it reads the latest contact and deforms the body, with its own scratch.
#pragma once

#include <phynness/phynness.h>

#include <atomic>
#include <thread>
#include <vector>

#include "force_thread.hpp"

class PictureThread {
 public:
  /// @param data  used by this thread only
  PictureThread(Latest<Touch>& touch, const phn_model* model, phn_data* data, int32_t node, double frames_per_s);
  ~PictureThread() { stop(); }
  void stop();

  // Call these after stop().
  long frames() const { return _frames; }
  double slowest_frame_us() const { return _slowest_us; }
  double largest_displacement_m() const { return _largest_m; }  ///< of any output node in any frame

 private:
  void run(int32_t node, double frames_per_s);

  Latest<Touch>& _touch;
  const phn_model* _model;
  phn_data* _data;
  std::vector<double> _field;
  std::atomic<bool> _stop{false};
  long _frames = 0;
  double _slowest_us = 0, _largest_m = 0;
  std::thread _thread;
};
