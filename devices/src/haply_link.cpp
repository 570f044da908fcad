#include "haply_link.hpp"

#include <algorithm>
#include <boost/asio/connect.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <sstream>
#include <stdexcept>

namespace phynness::devices {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

constexpr int most_unanswered = 4;
constexpr std::size_t longest_message = 1 << 20;
constexpr auto tick_period = std::chrono::milliseconds(2);
/// How long a connection that failed is kept for the zero force to be sent and the service to close it [s].
constexpr double farewell_s = 0.2;

const char* const is_it_running =
    "check in Haply Hub that the Inverse service runs, and that host and port are its own";

}  // namespace

void HaplyInverse::Link::start() {
  auto started = _started.get_future();
  _thread = std::thread([this] { run(); });
  started.get();
}

void HaplyInverse::Link::stop() noexcept {
  if (!_thread.joinable()) return;
  try {
    asio::post(_io, [this] {
      if (_phase == Phase::running)
        enter(Phase::closing);
      else if (_phase != Phase::closing)
        end();
      pump();
    });
  } catch (...) {
    _io.stop();
  }
  _thread.join();
}

bool HaplyInverse::Link::reported_force(haply::Force& force) {
  Reported reported;
  _reported.read(reported);
  force = reported.force_N;
  return reported.is_known;
}

void HaplyInverse::Link::hold(const haply::Force& force) {
  _forces.write(force);
  if (_is_woken.exchange(true)) return;
  asio::post(_io, [this] {
    _is_woken.exchange(false);
    _is_new = _forces.read(_force) || _is_new;
    _held_at = now();
    pump();
  });
}

std::string HaplyInverse::Link::lost() const {
  const std::lock_guard<std::mutex> lock(_reason_mutex);
  return _reason;
}

void HaplyInverse::Link::run() {
  asio::post(_io, [this] {
    connect();
    tick();
  });
  while (true) {
    try {
      _io.run();
      return;
    } catch (const std::exception& error) {
      fail(error.what(), is_it_running);
      end();
    }
  }
}

void HaplyInverse::Link::connect() {
  using Addresses = asio::ip::tcp::resolver::results_type;
  enter(Phase::connecting);
  _resolver.async_resolve(_settings.host, std::to_string(_settings.port), [this](Error error, const Addresses& found) {
    if (_phase == Phase::ended) return;
    if (error) return fail("no address for " + address() + ": " + error.message(), is_it_running);
    beast::get_lowest_layer(_socket).async_connect(found, [this](Error refused, const asio::ip::tcp::endpoint&) {
      if (_phase == Phase::ended) return;
      if (refused) return fail("no connection to " + address() + ": " + refused.message(), is_it_running);
      upgrade();
    });
  });
}

void HaplyInverse::Link::upgrade() {
  Error ignored;
  beast::get_lowest_layer(_socket).expires_never();
  beast::get_lowest_layer(_socket).socket().set_option(asio::ip::tcp::no_delay(true), ignored);
  _socket.read_message_max(longest_message);
  _socket.async_handshake(_settings.host + ":" + std::to_string(_settings.port), "/", [this](Error error) {
    if (_phase == Phase::ended) return;
    if (error) return fail(address() + " is not a WebSocket: " + error.message(), is_it_running);
    _socket.text(true);
    // A read ends only when the service closes the connection below the WebSocket, too, which may be never.
    _socket.control_callback([this](websocket::frame_type kind, beast::string_view) {
      if (kind == websocket::frame_type::close) asio::post(_io, [this] { closed_by_service(); });
    });
    enter(Phase::inventory);
    listen();
  });
}

void HaplyInverse::Link::listen() {
  _socket.async_read(_incoming, [this](Error error, std::size_t) {
    const double arrived = now();
    if (_phase == Phase::ended) return;
    if (error && _phase == Phase::closing) return end();
    if (error == websocket::error::closed) return closed_by_service();
    if (error) return fail("the connection is lost: " + error.message(), is_it_running);
    const std::string message = beast::buffers_to_string(_incoming.data());
    _incoming.consume(_incoming.size());
    on_message(message, arrived);
    if (_phase != Phase::ended) listen();
  });
}

void HaplyInverse::Link::closed_by_service() {
  if (_phase == Phase::closing) return;
  _is_closing = true;  // the close frame was answered, and nothing can be sent any more
  fail("the service closed the connection: code " + std::to_string(_socket.reason().code),
       "restart the service and open the device again");
}

void HaplyInverse::Link::on_message(const std::string& message, double arrived) {
  if (_phase == Phase::inventory) {
    try {
      _device_id = haply::select_device(message, _settings.device_id);
      const haply::State state = haply::read_state(message, _device_id);
      if (!state.not_ready.empty()) return fail("device " + _device_id + " is not ready", state.not_ready);
    } catch (const std::runtime_error& error) {
      return fail(error.what(), "");
    }
    enter(Phase::first_update);
    return send({}, _settings.profile);
  }
  if (_unanswered == 0) {
    ++_unasked;
    return;
  }
  --_unanswered;
  _asked_at = arrived;
  on_state(message, arrived);
  if (_phase != Phase::ended) pump();
}

void HaplyInverse::Link::on_state(const std::string& message, double arrived) {
  try {
    const haply::State state = haply::read_state(message, _device_id);
    if (!state.not_ready.empty()) return fail("device " + _device_id + " is not ready any more", state.not_ready);
    phn_loop_sample sample{};
    for (std::size_t i = 0; i < 3; ++i) sample.position_m[i] = state.position_m[i];
    sample.time_s = arrived - _settings.position_age_s;
    _samples.write(sample);
    _reported.write({state.has_force, state.force_N});
    ++_answers;
    _valid_at = arrived;
    _malformed_since = -1;
    if (_phase == Phase::first_update) {
      enter(Phase::running);
      _started.set_value();
    }
  } catch (const std::runtime_error& error) {
    ++_malformed;
    if (_malformed_since < 0) _malformed_since = arrived;
    const bool lasts = arrived > _malformed_since + _settings.timeout_s;
    if (_phase == Phase::first_update || lasts) fail(error.what(), "");
  }
}

void HaplyInverse::Link::send(const haply::Force& force, const std::string& profile) {
  _outgoing = haply::force_command(_device_id, _settings.force_name, force, profile);
  _is_writing = true;
  _at_device = force;
  if (_unanswered++ == 0) _asked_at = now();
  if (_unanswered == 1 && _malformed_since < 0) _valid_at = _asked_at;
  ++_sent;
  _socket.async_write(asio::buffer(_outgoing), [this](Error error, std::size_t) {
    _is_writing = false;
    if (_phase == Phase::ended) return;
    if (error && _phase == Phase::closing) return end();
    if (error) return fail("a force cannot be sent: " + error.message(), is_it_running);
    pump();
  });
}

/// Sends what is to be sent next.
void HaplyInverse::Link::pump() {
  if (_is_writing) return;
  if (_phase == Phase::closing) {
    if (!_zero_is_sent) {
      _zero_is_sent = true;
      send({});
    } else if (_unanswered == 0 || _is_lost) {
      begin_close();
    }
    return;
  }
  if (_phase != Phase::running || !_is_new) return;
  const bool is_zero = _force == haply::Force{};
  if (answers_stopped() && !is_zero) {
    if (_unanswered == 0) silence();  // asks for an answer
  } else if (_unanswered < most_unanswered || (is_zero && _at_device != _force)) {
    _is_new = false;
    send(_force);
  }
}

void HaplyInverse::Link::silence() {
  if (_at_device != haply::Force{}) ++_silenced;
  send({});
}

bool HaplyInverse::Link::answers_stopped() const {
  return (_unanswered > 0 || _malformed_since >= 0) && now() > _valid_at + _settings.answer_timeout_s;
}

void HaplyInverse::Link::begin_close() {
  if (_is_closing) return;
  _is_closing = true;
  _socket.async_close(websocket::close_code::normal, [this](Error) { end(); });
}

/// Looks every few milliseconds for what did not happen in time.
void HaplyInverse::Link::tick() {
  const double time = now(), limit = _settings.timeout_s;
  if (_phase == Phase::closing && time > _entered + (_is_lost ? std::min(limit, farewell_s) : limit)) return end();
  if (_phase == Phase::closing && _zero_is_sent && !_is_writing && answers_stopped()) begin_close();
  if (_phase < Phase::running && time > _entered + limit)
    return fail(address() + " does not answer" + within(), is_it_running);
  if (_phase == Phase::running && _unanswered > 0 && time > _asked_at + limit)
    return fail("the service does not answer" + within(), is_it_running);
  const bool is_silent = time > _held_at + _settings.hold_timeout_s;
  if (_phase == Phase::running && (is_silent || answers_stopped()) && _at_device != haply::Force{} && !_is_writing) {
    if (is_silent) _is_new = false;
    silence();
  }
  _tick.expires_after(tick_period);
  _tick.async_wait([this](Error) {
    if (_phase != Phase::ended) tick();
  });
}

std::string HaplyInverse::Link::within() const {
  std::ostringstream text;
  text << " within " << _settings.timeout_s << " s";
  return text.str();
}

void HaplyInverse::Link::enter(Phase phase) {
  _phase = phase;
  _entered = _held_at = now();
}

void HaplyInverse::Link::fail(const std::string& what, const std::string& remedy) {
  if (_phase == Phase::ended) return;
  if (_is_lost) return;
  const bool opening = _phase < Phase::running;
  const std::string prefix = "Haply Inverse service: ";
  const std::string reason = haply::printable((what.compare(0, prefix.size(), prefix) == 0 ? what : prefix + what) +
                                              (remedy.empty() ? "" : "; " + remedy));
  {
    const std::lock_guard<std::mutex> lock(_reason_mutex);
    _reason = reason;
  }
  _is_lost.store(true, std::memory_order_release);
  if (_phase == Phase::running && _at_device != haply::Force{} && !_is_closing && _socket.is_open()) {
    enter(Phase::closing);
    pump();
  } else if (_phase != Phase::closing || _is_closing) {
    end();
  }
  if (opening) _started.set_exception(std::make_exception_ptr(std::runtime_error(reason)));
}

void HaplyInverse::Link::end() {
  Error ignored;
  _phase = Phase::ended;
  _tick.cancel();
  _resolver.cancel();
  beast::get_lowest_layer(_socket).socket().close(ignored);
  beast::get_lowest_layer(_socket).cancel();
}

}  // namespace phynness::devices
