// The connection to Haply's Inverse service: a thread that reads and writes the socket. Used by haply_inverse.cpp.
#pragma once

#include "haply_messages.hpp"

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <future>
#include <mutex>
#include <phynness/devices/haply_inverse.hpp>
#include <phynness/devices/latest.hpp>
#include <thread>

namespace phynness::devices {

class HaplyInverse::Link {
 public:
  explicit Link(const HaplyInverseSettings& settings) : _settings(settings), _socket(_io), _tick(_io), _resolver(_io) {}
  ~Link() { stop(); }

  /// Returns after the first state update.
  void start();
  void stop() noexcept;

  // Called by the thread of the controller.
  static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
  bool read(phn_loop_sample& sample) { return _samples.read(sample); }
  bool reported_force(haply::Force& force);
  void hold(const haply::Force& force);
  bool is_lost() const { return _is_lost.load(std::memory_order_acquire); }
  std::string lost() const;
  HaplyInverseCounts counts() const { return {_sent, _answers, _malformed, _unasked, _silenced}; }

 private:
  enum class Phase { connecting, inventory, first_update, running, closing, ended };
  struct Reported {
    bool is_known = false;
    haply::Force force_N{};
  };
  using Error = boost::beast::error_code;

  // Called by the thread of the socket.
  void run();
  void connect();
  void upgrade();
  void listen();
  void on_message(const std::string& message, double arrived);
  void on_state(const std::string& message, double arrived);
  void send(const haply::Force& force, const std::string& profile = "");
  void pump();
  void silence();
  bool answers_stopped() const;
  void closed_by_service();
  void begin_close();
  void tick();
  void enter(Phase phase);
  void fail(const std::string& what, const std::string& remedy);
  void end();
  std::string within() const;
  std::string address() const { return "ws://" + _settings.host + ":" + std::to_string(_settings.port); }

  const HaplyInverseSettings _settings;

  // Between the threads.
  Latest<phn_loop_sample> _samples;
  Latest<Reported> _reported;
  Latest<haply::Force> _forces;
  std::atomic<bool> _is_woken{false}, _is_lost{false};
  std::atomic<long> _sent{0}, _answers{0}, _malformed{0}, _unasked{0}, _silenced{0};
  mutable std::mutex _reason_mutex;
  std::string _reason;
  std::promise<void> _started;

  // Of the thread of the socket.
  boost::asio::io_context _io{1};
  boost::beast::websocket::stream<boost::beast::tcp_stream> _socket;
  boost::asio::steady_timer _tick;
  boost::asio::ip::tcp::resolver _resolver;
  boost::beast::flat_buffer _incoming;
  std::string _outgoing, _device_id;
  Phase _phase = Phase::connecting;
  haply::Force _force{};      ///< newest of hold()
  haply::Force _at_device{};  ///< last one sent
  bool _is_new = false, _is_writing = false, _zero_is_sent = false, _is_closing = false;
  int _unanswered = 0;
  double _entered = 0, _held_at = 0, _asked_at = 0;  ///< times of now()
  double _valid_at = 0;                              ///< of the last valid answer, or of the first message after it
  double _malformed_since = -1;                      ///< < 0: the newest answer was valid

  std::thread _thread;
};

}  // namespace phynness::devices
