// The adapter for Haply's Inverse service: positions and forces arrive unchanged and in order, force is zero at the end
// and when the controller is silent, and whatever the service sends, the adapter goes on or says what is wrong. All
// over a real socket, against a service that simulates a device and checks each message. Positions agree to 1e-15 m, as
// they travel as the shortest decimal numbers that give the same double; forces are compared as the service prints
// them, in six digits.
#include "inverse_service.hpp"

#include <netinet/in.h>
#include <sys/socket.h>

#include <cmath>
#include <limits>
#include <memory>
#include <set>

namespace phynness::devices {
namespace {

using Force = std::array<double, 3>;

TEST(HaplyInverse, PositionsComeWithTheTimeOfTheirArrival) {
  InverseService service;
  HaplyInverse device(service.settings);
  const double begin = device.now();
  device.open();
  EXPECT_TRUE(device.traits().has_times);
  phn_loop_sample sample{}, last{};
  ASSERT_TRUE(device.read(last)) << "open() waits for a position";
  EXPECT_FALSE(device.read(sample)) << "a position is given once";
  EXPECT_GE(last.time_s, begin);
  EXPECT_NEAR(last.position_m[0], 0, 0.01);
  EXPECT_NEAR(last.position_m[1], -0.12, 0.01);
  EXPECT_NEAR(last.position_m[2], 0.15, 0.01);
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(exchange(device, {0.1, 0, 0}, sample)) << device.lost();
    EXPECT_GT(sample.time_s, last.time_s);
    EXPECT_LE(sample.time_s, device.now());
    EXPECT_NE(sample.position_m[2], last.position_m[2]);
    last = sample;
  }
  EXPECT_FALSE(device.read(sample));
  device.close();
  EXPECT_EQ(service.finish(), 0) << service.log();
}

TEST(HaplyInverse, EachForceArrivesInItsOrder) {
  InverseService service;
  HaplyInverse device(service.settings);
  device.open();
  phn_loop_sample sample{};
  for (int i = 1; i <= 50; ++i) ASSERT_TRUE(exchange(device, {0.01 * i, -0.02, 0.5}, sample)) << device.lost();
  double reported[3];
  ASSERT_TRUE(device.reported_force(reported));
  EXPECT_EQ(reported[0], 0.5);
  device.close();
  EXPECT_EQ(service.finish(), 0) << service.log();
  EXPECT_EQ(device.counts().sent, 52) << "one message each, one at the beginning and one at the end";
  for (int i = 1; i <= 50; ++i) {
    std::ostringstream line;
    line << "message " << i + 1 << ": force " << 0.01 * i << " -0.02 0.5\n";
    EXPECT_NE(service.log().find(line.str()), std::string::npos) << line.str() << service.log();
  }
}

TEST(HaplyInverse, ForceIsZeroAtCloseAndAtDestruction) {
  for (const bool closes : {true, false}) {
    InverseService service;
    auto device = std::make_unique<HaplyInverse>(service.settings);
    device->open();
    phn_loop_sample sample{};
    ASSERT_TRUE(exchange(*device, {1, -1, 0.5}, sample));
    if (closes) {
      device->close();
      EXPECT_FALSE(device->wait());
      device->close();
    }
    device.reset();
    EXPECT_EQ(service.finish(), 0);
    EXPECT_NE(service.log().find("message 2: force 1 -1 0.5\nmessage 3: force 0 0 0\nclose frame"), std::string::npos)
        << service.log();
  }
}

TEST(HaplyInverse, ForceIsZeroWhenTheControllerIsSilent) {
  InverseService service;
  service.settings.hold_timeout_s = 0.02;
  HaplyInverse device(service.settings);
  device.open();
  const double force[] = {0, 0, 1.5};
  device.hold(force);
  EXPECT_TRUE(service.logs("message 2: force 0 0 1.5\nmessage 3: force 0 0 0\n")) << service.log();
  EXPECT_EQ(device.counts().silenced, 1);
  phn_loop_sample sample{};
  EXPECT_TRUE(exchange(device, {0, 0, 0.25}, sample)) << "the controller may go on";
  EXPECT_TRUE(service.logs("message 4: force 0 0 0.25\n")) << service.log();
}

// The time limit of the connection is far away, and more messages have no answer than are sent otherwise: the zero
// comes from the limit of answers alone.
TEST(HaplyInverse, ForceIsZeroWhenAnswersStop) {
  for (const char* kind : {"silent", "no-position"}) {
    InverseService service(std::string("--answers ok,ok --then ") + kind);
    service.settings.answer_timeout_s = 0.01;
    HaplyInverse device(service.settings);
    device.open();
    phn_loop_sample sample{};
    ASSERT_TRUE(exchange(device, {0, 0, 1}, sample));
    const double force[] = {0, 0, 1};
    ASSERT_TRUE(waited_for([&] {
      device.hold(force);
      return device.counts().silenced > 0;
    }));
    EXPECT_TRUE(service.logs("force 0 0 0\n")) << service.log();
    EXPECT_EQ(device.lost(), "") << kind;
    for (int i = 0; i < 20; ++i) {
      device.hold(force);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const std::string log = service.log();
    EXPECT_EQ(log.find("force 0 0 1\n", log.find("force 0 0 0\n", log.find("force 0 0 1\n"))), std::string::npos)
        << "no force before there is a valid answer: " << log;
    device.close();
    EXPECT_EQ(service.finish(), 0) << service.log();
    // How long this took is measured and not judged: the machine may be busy.
    double seconds = 0, work_mJ = 0;
    const std::string all = service.log();
    const std::size_t at = all.find("a force stayed");
    if (kind == std::string("silent")) {
      ASSERT_NE(at, std::string::npos) << all;
      ASSERT_EQ(std::sscanf(all.c_str() + at, "a force stayed for %lf s and did %lf mJ", &seconds, &work_mJ), 2);
      std::printf("1 N stayed for %.4f s without an answer and did %.4f mJ of work\n", seconds, work_mJ);
    }
  }
}

TEST(HaplyInverse, ForceIsZeroAfterAMissingAnswerUntilTheNextOne) {
  InverseService service("--answers ok,ok,late,ok");
  service.settings.answer_timeout_s = 0.01;
  HaplyInverse device(service.settings);
  device.open();
  phn_loop_sample sample{};
  const double force[] = {0, 0, 1};
  ASSERT_TRUE(exchange(device, {0, 0, 1}, sample));
  device.hold(force);  // its answer comes with that to the zero force
  ASSERT_TRUE(service.logs("answer 3: late"));
  ASSERT_TRUE(waited_for([&] { return device.counts().answers == 4; }));
  EXPECT_NE(service.log().find("force 0 0 0\n"), std::string::npos);
  EXPECT_TRUE(exchange(device, {0, 0, 0.25}, sample)) << device.lost();
  EXPECT_TRUE(service.logs("force 0 0 0.25\n"));
}

TEST(HaplyInverse, ForceIsZeroBeforeAConnectionIsGivenUp) {
  for (const char* options : {"--answers ok,ok,unpowered", "--answers ok,ok --then no-position"}) {
    InverseService service(options);
    service.settings.timeout_s = 0.2;
    HaplyInverse device(service.settings);
    device.open();
    const double force[] = {0, 0, 1};
    while (device.wait()) device.hold(force);
    device.close();
    EXPECT_EQ(service.finish(), 0) << service.log();
    EXPECT_NE(service.log().find("last force 0 0 0"), std::string::npos) << service.log();
  }
}

TEST(HaplyInverse, AForceThatTheServiceReportsIsTheOneThatIsHeld) {
  for (const char* reports : {"commanded", "0", "0.3"}) {
    InverseService service(std::string("--reports ") + reports);
    HaplyInverse device(service.settings);
    device.open();
    phn_loop_sample sample{};
    for (int i = 1; i <= 20; ++i) ASSERT_TRUE(exchange(device, {0, 0, 1 + 0.01 * i}, sample));
    const double next[] = {0, 0, 1.21};
    device.hold(next);
    double held[3];
    ASSERT_TRUE(device.held(held));
    EXPECT_DOUBLE_EQ(held[2], reports == std::string("0.3") ? 0.3 : 1.21) << reports;
  }
}

TEST(HaplyInverse, ForcesAreShortenedAndFinite) {
  InverseService service("--largest-force 2");
  HaplyInverse device(service.settings);
  device.open();
  EXPECT_EQ(settings_for(device.traits()).largest_force_N, 2);
  phn_loop_sample sample{};
  ASSERT_TRUE(exchange(device, {30, 0, 40}, sample));
  double held[3];
  ASSERT_TRUE(device.held(held));
  EXPECT_NEAR(held[0], 1.2, 1e-12);
  EXPECT_NEAR(held[2], 1.6, 1e-12);
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(exchange(device, {nan, 1, 1}, sample));
  ASSERT_TRUE(exchange(device, {1, -infinity, 1}, sample));
  device.close();
  EXPECT_EQ(service.finish(), 0) << service.log();
  EXPECT_NE(service.log().find("message 2: force 1.2 0 1.6\nmessage 3: force 0 0 0\nmessage 4: force 0 0 0\n"),
            std::string::npos)
      << service.log();
}

TEST(HaplyInverse, MalformedAnswersAreCountedAndNotUsed) {
  for (const char* kind :
       {"not-json", "list", "no-device", "no-position", "text-position", "infinite", "scaled", "deep", "deep-scale"}) {
    InverseService service(std::string("--answers ok,ok,") + kind + ",ok");
    HaplyInverse device(service.settings);
    device.open();
    phn_loop_sample sample{}, next{};
    ASSERT_TRUE(exchange(device, {0, 0, 1}, sample)) << kind;
    const double force[] = {0, 0, 0.5};
    device.hold(force);
    ASSERT_TRUE(waited_for([&] { return device.counts().malformed == 1; })) << kind;
    EXPECT_FALSE(device.read(next)) << kind;
    ASSERT_TRUE(exchange(device, {0, 0, 0}, next)) << kind << device.lost();
    EXPECT_TRUE(std::isfinite(next.position_m[0])) << kind;
    EXPECT_GT(next.time_s, sample.time_s) << kind;
    device.close();
    EXPECT_EQ(service.finish(), 0) << kind << service.log();
  }
}

TEST(HaplyInverse, NothingButMalformedAnswersIsALostConnection) {
  InverseService service("--answers ok --then no-position");
  service.settings.timeout_s = 0.3;
  HaplyInverse device(service.settings);
  device.open();
  const double force[] = {0, 0, 0.5};
  while (device.wait()) device.hold(force);
  EXPECT_NE(device.lost().find("cursor_position"), std::string::npos) << device.lost();
  phn_loop_sample sample{};
  EXPECT_FALSE(device.read(sample));
}

TEST(HaplyInverse, LateRepeatedAndSplitMessagesDoNoHarm) {
  InverseService service("--answers ok,late,ok,twice,ok,unasked,ok,ping,fragments,ok");
  HaplyInverse device(service.settings);
  device.open();
  phn_loop_sample sample{}, last{};
  ASSERT_TRUE(device.read(last));
  const double force[] = {0, 0, 0.1};
  device.hold(force);  // its answer comes together with the next one
  ASSERT_TRUE(service.logs("answer 2: late"));
  EXPECT_FALSE(device.read(sample));
  device.hold(force);
  ASSERT_TRUE(waited_for([&] { return device.counts().answers == 3; }));
  ASSERT_TRUE(device.read(sample)) << "of two that came together, the newest";
  EXPECT_FALSE(device.read(sample));
  ASSERT_TRUE(exchange(device, {0, 0, 0.2}, sample));  // comes twice
  ASSERT_TRUE(waited_for([&] { return device.counts().unasked == 1; }));
  EXPECT_FALSE(device.read(sample)) << "a repeated message is no new position";
  ASSERT_TRUE(exchange(device, {0, 0, 0.3}, sample));
  ASSERT_TRUE(exchange(device, {0, 0, 0.4}, sample));  // five more come unasked
  ASSERT_TRUE(waited_for([&] { return device.counts().unasked == 6; }));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(exchange(device, {0, 0, 0.5}, sample)) << device.lost();
  EXPECT_TRUE(service.logs("pong: are you there"));
  device.close();
  EXPECT_EQ(service.finish(), 0) << service.log();
  EXPECT_EQ(device.counts().answers, 12) << "with those of open() and close()";
  EXPECT_EQ(device.counts().malformed, 0);
}

TEST(HaplyInverse, ForcesDoNotQueueBehindASlowService) {
  InverseService service("--answers ok,late,late,late,late");
  service.settings.hold_timeout_s = 1;
  HaplyInverse device(service.settings);
  device.open();
  for (int i = 1; i <= 4; ++i) {
    const double force[] = {0, 0, 0.1 * i};
    device.hold(force);
    ASSERT_TRUE(service.logs("message " + std::to_string(i + 1))) << service.log();
  }
  for (int i = 1; i <= 1000; ++i) {
    const double force[] = {0, 0, 1e-3 * i};
    device.hold(force);
  }
  EXPECT_EQ(device.counts().sent, 5) << "four without an answer, and the one of open()";
  device.close();
  EXPECT_EQ(service.finish(), 0) << service.log();
  EXPECT_NE(service.log().find("answer 5: late\nmessage 6: force 0 0 0\n"), std::string::npos) << service.log();
}

TEST(HaplyInverse, ALostConnectionEndsTheLoopAndSaysWhy) {
  const struct {
    const char *kind, *reason;
  } cases[] = {{"close", "1001"}, {"close-half", "1001"}, {"vanish", "lost"},
               {"huge", "lost"},  {"unpowered", "power"}, {"silent", "answer"}};
  for (const auto& c : cases) {
    InverseService service(std::string("--answers ok,ok,") + c.kind + " --then silent");
    if (c.kind == std::string("silent")) service.settings.timeout_s = 0.3;
    HaplyInverse device(service.settings);
    device.open();
    const double force[] = {0, 0, 1};
    while (device.wait()) device.hold(force);
    EXPECT_NE(device.lost().find(c.reason), std::string::npos) << c.kind << ": " << device.lost();
    EXPECT_NE(device.lost().find("; "), std::string::npos) << "a remedy";
    phn_loop_sample sample{};
    EXPECT_FALSE(device.read(sample)) << c.kind;
    device.hold(force);
    EXPECT_FALSE(device.wait());
    device.close();
    EXPECT_FALSE(device.lost().empty()) << "the reason stays known";
  }
}

TEST(HaplyInverse, OpenRefusesWhatCannotWork) {
  const struct {
    const char *greeting, *reason;
  } cases[] = {{"none", "no Inverse3"},
               {"two", "049D, 04A1"},
               {"not-json", "\"hello\""},
               {"list", "[1, 2]"},
               {"no-id", "device_id"},
               {"no-position", "cursor_position"},
               {"uncalibrated", "calibrate"},
               {"scaled", "1000"},
               {"close", "1001"},
               {"not-websocket", "WebSocket"},
               {"control-characters", "04?9D?[31m"},
               {"deep", "nested too deeply"},
               {"deep-scale", "config"},
               {"silent", "0.2 s"}};
  std::set<std::string> messages;
  for (const auto& c : cases) {
    InverseService service(std::string("--greeting ") + c.greeting);
    if (c.greeting == std::string("silent")) service.settings.timeout_s = 0.2;
    const std::string message = refusal(service.settings);
    EXPECT_NE(message.find(c.reason), std::string::npos) << c.greeting << ": " << message;
    EXPECT_NE(message.find("; "), std::string::npos) << "a remedy: " << message;
    messages.insert(message);
    EXPECT_EQ(service.finish(), 0) << c.greeting << service.log();
    EXPECT_EQ(service.log().find("message 1"), std::string::npos) << "nothing is sent to a device that is refused";
  }
  EXPECT_EQ(messages.size(), std::size(cases));
}

TEST(HaplyInverse, OneOfSeveralDevicesIsSelectedByItsId) {
  InverseService service("--greeting two");
  service.settings.device_id = "049D";
  HaplyInverse device(service.settings);
  device.open();
  device.close();
  EXPECT_EQ(service.finish(), 0) << service.log();
  InverseService other("--greeting two");
  other.settings.device_id = "0000";
  EXPECT_NE(refusal(other.settings).find("0000"), std::string::npos);
}

TEST(HaplyInverse, TheEarlierNameOfTheForceIsASetting) {
  InverseService service("--force-name values");
  service.settings.force_name = "values";
  HaplyInverse device(service.settings);
  device.open();
  phn_loop_sample sample{};
  EXPECT_TRUE(exchange(device, {0, 0, 1}, sample));
  device.close();
  EXPECT_EQ(service.finish(), 0) << service.log();
}

TEST(HaplyInverse, NoServiceIsAnError) {
  const int taken = socket(AF_INET, SOCK_STREAM, 0);  // bound but not listening: connections are refused
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(taken, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(getsockname(taken, reinterpret_cast<sockaddr*>(&address), &size), 0);
  HaplyInverseSettings settings;
  settings.host = "127.0.0.1";
  settings.port = ntohs(address.sin_port);
  const std::string message = refusal(settings);
  EXPECT_NE(message.find(std::to_string(settings.port)), std::string::npos) << message;
  EXPECT_NE(message.find("Haply Hub"), std::string::npos) << message;
  ::close(taken);
}

TEST(HaplyInverse, SettingsOutOfRangeAreRefusedBeforeAnyConnection) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (double HaplyInverseSettings::*setting :
       {&HaplyInverseSettings::period_s, &HaplyInverseSettings::timeout_s, &HaplyInverseSettings::hold_timeout_s,
        &HaplyInverseSettings::answer_timeout_s, &HaplyInverseSettings::largest_force_N,
        &HaplyInverseSettings::position_age_s, &HaplyInverseSettings::force_delay_s,
        &HaplyInverseSettings::position_resolution_m})
    for (const double wrong : {-1.0, 1e6, nan}) {
      HaplyInverseSettings settings;
      settings.*setting = wrong;
      EXPECT_NE(refusal(settings).find("; set it to"), std::string::npos) << wrong;
    }
}

TEST(HaplyInverse, UnopenedAndReopenedDevicesAreSafe) {
  InverseService service("--clients 3");
  HaplyInverse device(service.settings);
  phn_loop_sample sample{};
  const double force[] = {0, 0, 1};
  device.hold(force);
  EXPECT_FALSE(device.read(sample));
  EXPECT_FALSE(device.wait());
  device.close();
  double before = device.now();
  for (int i = 0; i < 3; ++i) {
    device.open();  // the second time without close()
    ASSERT_TRUE(exchange(device, {0, 0, 1}, sample));
    EXPECT_GT(sample.time_s, before);
    before = sample.time_s;
    if (i > 0) device.close();
  }
  EXPECT_EQ(service.finish(), 0) << service.log();
}

}  // namespace
}  // namespace phynness::devices
