// A fake Inverse service in a process of its own, for one client: fake_inverse_service.py. Nothing here waits for a
// certain time; what waits, waits for an event, and gives up after a minute.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <phynness/devices/haply_inverse.hpp>
#include <sstream>
#include <string>
#include <thread>

namespace phynness::devices {

/// Waits until something is true. @return false after a minute
template <class Condition>
bool waited_for(Condition is_true) {
  for (int i = 0; i < 60000; ++i) {
    if (is_true()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

class InverseService {
 public:
  /// @param options  of fake_inverse_service.py
  explicit InverseService(const std::string& options = "") {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    static int number = 0;
    _log_file = testing::TempDir() + "inverse_service_" + std::to_string(getpid()) + "_" + test->name() + "_" +
                std::to_string(++number) + ".log";
    const std::string script = std::string(PHYNNESS_SOURCE_DIR) + "/tests/devices/fake_inverse_service.py";
    _pipe = popen(("exec python3 '" + script + "' --log '" + _log_file + "' " + options).c_str(), "r");
    int port = 0;
    if (_pipe == nullptr || std::fscanf(_pipe, "port %d", &port) != 1)
      ADD_FAILURE() << "the fake service does not start";
    settings.host = "127.0.0.1";
    settings.port = static_cast<std::uint16_t>(port);
    settings.timeout_s = 30;
    settings.hold_timeout_s = settings.answer_timeout_s = 1;
  }
  ~InverseService() {
    if (_pipe != nullptr) finish();
    std::remove(_log_file.c_str());
  }
  InverseService(const InverseService&) = delete;
  InverseService& operator=(const InverseService&) = delete;

  /// Waits for the end of the service. @return its exit status: 0 if all messages of the client were as documented
  int finish() {
    const int status = pclose(_pipe);
    _pipe = nullptr;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string log() const {
    std::ifstream in(_log_file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }
  bool logs(const std::string& text) const {
    return waited_for([&] { return log().find(text) != std::string::npos; });
  }

  HaplyInverseSettings settings;  ///< for the client

 private:
  std::FILE* _pipe = nullptr;
  std::string _log_file;
};

/// Holds a force and waits for the state update that answers it. @return false if the connection is lost
inline bool exchange(HaplyInverse& device, std::array<double, 3> force, phn_loop_sample& sample) {
  const long before = device.counts().answers;
  device.hold(force.data());
  return waited_for([&] { return device.counts().answers > before || !device.lost().empty(); }) &&
         device.lost().empty() && device.read(sample);
}

/// What open() refuses with; empty: it does not.
inline std::string refusal(const HaplyInverseSettings& settings) {
  HaplyInverse device(settings);
  try {
    device.open();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

}  // namespace phynness::devices
