#include "haply_link.hpp"

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
constexpr auto tick_period = std::chrono::milliseconds(5);

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
  try {
    connect();
    tick();
    _io.run();
  } catch (const std::exception& error) {
    fail(error.what(), is_it_running);
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
    enter(Phase::inventory);
    listen();
  });
}

void HaplyInverse::Link::listen() {
  _socket.async_read(_incoming, [this](Error error, std::size_t) {
    const double arrived = now();
    if (_phase == Phase::ended) return;
    if (error && _phase == Phase::closing) return end();
    if (error == websocket::error::closed)
      return fail("the service closed the connection: code " + std::to_string(_socket.reason().code),
                  "restart the service and open the device again");
    if (error) return fail("the connection is lost: " + error.message(), is_it_running);
    const std::string message = beast::buffers_to_string(_incoming.data());
    _incoming.consume(_incoming.size());
    on_message(message, arrived);
    if (_phase != Phase::ended) listen();
  });
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
    } else if (_unanswered == 0) {
      begin_close();
    }
  } else if (_phase == Phase::running && _is_new && _unanswered < most_unanswered) {
    _is_new = false;
    send(_force);
  }
}

void HaplyInverse::Link::begin_close() {
  if (_is_closing) return;
  _is_closing = true;
  _socket.async_close(websocket::close_code::normal, [this](Error) { end(); });
}

/// Looks every few milliseconds for what did not happen in time.
void HaplyInverse::Link::tick() {
  const double time = now(), limit = _settings.timeout_s;
  if (_phase == Phase::closing && time > _entered + limit) return end();
  if (_phase < Phase::running && time > _entered + limit)
    return fail(address() + " does not answer" + within(), is_it_running);
  if (_phase == Phase::running && _unanswered > 0 && time > _asked_at + limit)
    return fail("the service does not answer" + within(), is_it_running);
  const bool is_silent = time > _held_at + _settings.hold_timeout_s;
  if (_phase == Phase::running && is_silent && _at_device != haply::Force{} && !_is_writing) {
    ++_silenced;
    _is_new = false;
    send({});
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
  const bool opening = _phase < Phase::running;
  const std::string prefix = "Haply Inverse service: ";
  const std::string reason =
      (what.compare(0, prefix.size(), prefix) == 0 ? what : prefix + what) + (remedy.empty() ? "" : "; " + remedy);
  {
    const std::lock_guard<std::mutex> lock(_reason_mutex);
    _reason = reason;
  }
  _is_lost.store(true, std::memory_order_release);
  end();
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
