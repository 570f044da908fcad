// The latest value from one thread to another, without locks and without waiting. Of three slots the writer and the
// reader own one each; they exchange theirs with the third.
#pragma once

#include <atomic>

namespace phynness::devices {

template <class Value>
class Latest {
 public:
  /// Called by one thread only.
  void write(const Value& value) {
    _slot[_writing] = value;
    _writing = _middle.exchange(_writing | fresh, std::memory_order_acq_rel) & index;
  }
  /// One other thread only. @return whether the value is newer than at the last call
  bool read(Value& value) {
    const bool is_new = _middle.load(std::memory_order_relaxed) & fresh;
    if (is_new) _reading = _middle.exchange(_reading, std::memory_order_acq_rel) & index;
    value = _slot[_reading];
    return is_new;
  }

 private:
  static constexpr unsigned index = 3, fresh = 4;
  Value _slot[3] = {};
  unsigned _writing = 0, _reading = 1;
  std::atomic<unsigned> _middle{2};
};

}  // namespace phynness::devices
