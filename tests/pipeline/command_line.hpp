// Runs the command through the shell, in a separate folder for each test.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <phynness/formats/hash.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "../messages.hpp"

namespace phynness::test {

inline std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

inline void write_file(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

/// The text with its lines as they were before the command broke those of more than 100 characters.
inline std::string unbroken(const std::string& text) { return std::regex_replace(text, std::regex("\n +"), " "); }

/// The text with its first `from` replaced.
inline std::string changed(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

struct Outcome {
  int exit_status = -1;
  std::string out, err;
};

/// A fresh folder per test, removed with it.
class CommandLine : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder = std::filesystem::temp_directory_path() /
             (std::string("phynness-") + info->test_suite_name() + "-" + info->name() + "-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder);
    setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 0);
    setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 0);
    setenv("OMP_NUM_THREADS", "1", 0);
  }
  void TearDown() override {
    if (!HasFailure()) std::filesystem::remove_all(folder);
  }

  /// Runs in the folder through the shell; PHYNNESS is the command's path.
  Outcome shell(const std::string& line) const {
    const auto full = "cd '" + folder.string() + "' && PHYNNESS='" PHYNNESS_COMMAND "' && { " + line +
                      "; } >stdout.txt 2>stderr.txt </dev/null";
    const int status = std::system(full.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_file(folder / "stdout.txt"),
            read_file(folder / "stderr.txt")};
  }
  Outcome phynness(const std::string& arguments) const { return shell("\"$PHYNNESS\" " + arguments); }
  /// The outcome of a command that must end with this exit status.
  Outcome ended(int exit_status, const std::string& arguments) const {
    auto outcome = phynness(arguments);
    EXPECT_EQ(outcome.exit_status, exit_status) << arguments << "\n" << outcome.err;
    return outcome;
  }
  Outcome succeed(const std::string& arguments) const { return ended(0, arguments); }
  Outcome be_refused(const std::string& arguments) const { return ended(2, arguments); }
  /// What commands make of the files in the folder, once for all tests of a build that ask for the same, and copied
  /// here.
  void make_once(const std::vector<std::string>& commands) const {
    std::string key, lines;
    for (const char* program : {"", "-solver"}) {
      std::error_code code;
      const auto time = std::filesystem::last_write_time(PHYNNESS_COMMAND + std::string(program), code);
      key += std::to_string(time.time_since_epoch().count()) + "\n";
    }
    std::set<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) files.insert(entry.path());
    for (const auto& file : files) key += file.filename().string() + "\n" + read_file(file);
    for (const auto& arguments : commands) lines += " && \"$PHYNNESS\" " + arguments;
    const auto made = std::filesystem::path(PHYNNESS_COMMAND).parent_path() / "tests/made" / hash_of(key + lines);
    const auto outcome =
        shell("made='" + made.string() +
              "' && here=$(pwd) && mkdir -p \"${made%/*}\" && exec 9> \"$made.lock\" && flock 9 && "
              "if [ ! -d \"$made\" ]; then rm -rf \"$made.new\" && cp -r . \"$made.new\" && cd \"$made.new\"" +
              lines + " && mv \"$made.new\" \"$made\" && cd \"$here\"; fi && cp -r \"$made/.\" .");
    ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  }
  /// Runs `signal` with the process of a command line in $pid as soon as the shell finds `ready`; then as the command.
  Outcome signalled(const std::string& line, const std::string& ready, const std::string& signal) const {
    return shell("PHYNNESS_PROGRESS=1 " + line + " 2>progress.txt & pid=$!; for i in $(seq 6000); do " + ready +
                 " && break; sleep 0.01; done; " + signal +
                 "; wait $pid; status=$?; cat progress.txt >&2; exit $status");
  }
  /// The command, with a signal when its progress has these words.
  Outcome interrupted(const std::string& arguments, const std::string& words, const std::string& name = "INT") const {
    return signalled("\"$PHYNNESS\" " + arguments, "grep -qE '" + words + "' progress.txt", "kill -" + name + " $pid");
  }
  /// The command, killed when the logs of its rays have more than 40 kB.
  Outcome killed(const std::string& arguments, const std::string& logs, const std::string& name = "KILL") const {
    const auto outcome =
        signalled("\"$PHYNNESS\" " + arguments, "[ \"$(cat " + logs + " 2>/dev/null | wc -c)\" -gt 40000 ]",
                  "kill -" + name + " $pid");
    EXPECT_NE(outcome.exit_status, 0) << "it finished before the signal came: the scene is too small for this test";
    return outcome;
  }
  Outcome on_two_ranks(const std::string& arguments) const {
    auto outcome = shell("mpirun --oversubscribe -n 2 \"$PHYNNESS\" " + arguments);
    EXPECT_EQ(outcome.exit_status, 0) << arguments << "\n" << outcome.err;
    return outcome;
  }
  /// Active nodes of a scene, database or model; `info.json` has the other figures.
  std::vector<int> active_of(const std::string& file) const {
    succeed("info " + file + " --json info.json");
    return json("info.json").at("active").get<std::vector<int>>();
  }
  nlohmann::json json(const std::string& name) const { return nlohmann::json::parse(read_file(folder / name)); }
  /// What a page of `phynness view` holds, base64 of gzip.
  nlohmann::json page_data(const std::string& page) const {
    const auto packed = shell("sed -n 's/.*id=\"phynness-data\">\\([^<]*\\).*/\\1/p' " + page +
                              " | base64 --decode | gunzip > page.json");
    EXPECT_EQ(packed.exit_status, 0) << packed.err;
    return json("page.json");
  }

  /// A block of a few dozen nodes, fixed below, two nodes of its top touched: seconds, not minutes.
  static std::string small_scene(const std::string& element = "P1", int increments = 2) {
    return "title = \"small block\"\n"
           "[mesh]\nshape = \"block\"\nsize_m = [0.1, 0.08, 0.05]\ntarget_size_m = 0.025\n"
           "[material]\nlaw = \"neo-hookean\"\nyoungs_modulus_Pa = 2000.0\npoisson_ratio = 0.45\n"
           "[solver]\nelement = \"" +
           element +
           "\"\n"
           "[nodes]\nfixed = { plane = { point_fraction = [0, 0, 0], normal = [0, 0, 1], tolerance_m = 1e-6 "
           "} }\n"
           "active = [{ nearest = { point_fraction = [0.3, 0.4, 1.0] }, surface_only = true },\n"
           "          { nearest = { point_fraction = [0.7, 0.6, 1.0] }, surface_only = true }]\n"
           "[probe]\ndirections = 26\nincrements = " +
           std::to_string(increments) +
           "\nmax_displacement_m = 0.008\n"
           "[training]\nfamily = \"rbfn\"\ndeformation_neurons = 40\nforce_neurons = 20\nforce_spread = 2.0\nsamples = "
           "500\n"
           "[validation]\nprobes = 8\ncheck_probes = 0\n";
  }

  static constexpr const char* active_top =
      "active = { plane = { point_fraction = [0, 0, 1], normal = [0, 0, 1], tolerance_m = 1e-6 } }\n";
  /// The scene with other lines from `active` to the end of [nodes].
  static std::string with_active(const std::string& scene, const std::string& lines) {
    const auto at = scene.find("active = ");
    return changed(scene, scene.substr(at, scene.find("[probe]") - at), lines);
  }
  /// A small_scene with round tools of one and a half edges at every node of the top, family modal.
  static std::string patch_scene(const std::string& element, const std::string& output = "") {
    auto scene = with_active(small_scene(element, 2), active_top + output);
    const auto training = scene.find("family = ");
    scene = changed(scene, scene.substr(training, scene.find("[validation]") - training), "family = \"modal\"\n");
    return changed(scene, "directions = 26", "kind = \"patch\"\ntool_radius_m = 0.0375\ndirections = 26");
  }

  /// A small_scene with more lines in [training].
  static std::string with_training(std::string scene, const std::string& lines) {
    return scene.insert(scene.find("[validation]"), lines + "\n");
  }

  std::filesystem::path folder;
};

}  // namespace phynness::test
