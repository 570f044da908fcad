// Claim: kill -9 at any moment of one process, of one or all of several ranks, of a run or of a part loses no finished
// work. After any number of resumed runs the database is identical to that of an uninterrupted run. Half of the moments
// are distributed over the whole length of a run including start and packing, half over the time from its first
// finished ray on. The number of runs for a database depends on the machine; the database does not. Kills go on until
// one has found some rays finished and some not.
#include <fcntl.h>
#include <spawn.h>

#include <chrono>
#include <csignal>
#include <phynness/formats/database_lock.hpp>
#include <random>
#include <thread>

#include "command_line.hpp"
#include "same_results.hpp"

extern char** environ;

namespace phynness::test {
namespace {

constexpr unsigned seed = 20110325;

class Killed : public CommandLine {
 protected:
  using Clock = std::chrono::steady_clock;

  void SetUp() override {
    CommandLine::SetUp();
    auto text = small_scene("P1", 12);
    text.replace(text.find("0.025"), 5, "0.05");  // 30 nodes: a run takes about as long as its start
    write_file(folder / "scene.toml", text);
    std::printf("seed %u\n", seed);
    RecordProperty("seed", static_cast<int>(seed));
    succeed("precompute scene.toml -o whole.h5");
  }

  /// Starts a command in the folder, its output to a file there.
  pid_t start(std::vector<std::string> words) const {
    std::vector<char*> argv;
    for (auto& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addchdir_np(&files, folder.c_str());
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, 1, "out.txt", O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&files, 1, 2);
    pid_t child = 0;
    EXPECT_EQ(posix_spawnp(&child, argv[0], &files, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&files);
    return child;
  }

  static int wait_for(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    return status;
  }
  static bool ended_well(int status) { return WIFEXITED(status) && WEXITSTATUS(status) == 0; }

  /// Processes that a process has started.
  static std::vector<pid_t> children_of(pid_t parent) {
    std::istringstream list(
        read_file("/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children"));
    std::vector<pid_t> children;
    for (pid_t child; list >> child;) children.push_back(child);
    return children;
  }

  /// More than three logs hold before their first ray.
  static constexpr std::uintmax_t opening_bytes = 300;
  static std::uintmax_t bytes_logged(const std::filesystem::path& database) {
    std::uintmax_t sum = 0;
    std::error_code code;
    std::filesystem::directory_iterator log(database.string() + ".log", code);
    while (!code && log != std::filesystem::directory_iterator()) {
      const auto size = log->file_size(code);
      if (!code) sum += size;
      log.increment(code);
    }
    return sum;
  }

  /// Runs the command with --resume and kills it, again and again, until `kills` have struck, and one of them between
  /// the first ray and the last; whenever it has come to its end in spite of that, `finished` looks at the result and
  /// clears it away.
  template <class Kill, class Finished>
  void torment(const std::vector<std::string>& command, const std::filesystem::path& database, int kills,
               Kill&& kill_it, Finished&& finished) {
    std::mt19937 random(seed);
    double length_s = 0;  // of the first run, which nobody kills
    bool begun = false;
    std::int64_t logged = 0;  // rays that were finished before this run
    int struck = 0, while_solving = 0, databases = 0;
    const auto kill_more = [&] { return struck < kills || (while_solving == 0 && struck < 4 * kills); };
    while (kill_more() || begun) {
      // Ranks may outlive their mpirun for a moment.
      while (!DatabaseLock::holder(database).empty()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      const auto start_time = Clock::now();
      const pid_t child = start(command);
      int status = 0;
      if (kill_more() && length_s > 0) {
        const bool whole_length = random() % 2 == 0;
        std::uniform_real_distribution<> delay_s(0, whole_length ? length_s : length_s / 3);
        const auto delay = std::chrono::duration<double>(delay_s(random));
        const auto old_bytes = bytes_logged(database);
        std::optional<Clock::time_point> from;
        if (whole_length) from = start_time;
        pid_t ended = 0;
        while ((ended = waitpid(child, &status, WNOHANG)) == 0 && !(from && Clock::now() >= *from + delay)) {
          if (!from && bytes_logged(database) > old_bytes + opening_bytes) from = Clock::now();
          std::this_thread::sleep_for(std::chrono::microseconds(500));
        }
        if (ended == 0) {
          kill_it(child, random);
          status = wait_for(child);
        }
      } else {
        status = wait_for(child);
      }
      begun = true;
      if (ended_well(status)) {
        length_s = std::chrono::duration<double>(Clock::now() - start_time).count();
        finished();
        if (HasFailure()) return;
        begun = false;
        logged = 0;
        ++databases;
      } else {
        const bool was_killed = WIFSIGNALED(status) ? WTERMSIG(status) == SIGKILL : kill_more();
        ASSERT_TRUE(was_killed) << "status " << status << "\n" << read_file(folder / "out.txt");
        ++struck;
        if (!std::filesystem::exists(database)) {
          ASSERT_EQ(logged, 0) << "the database is gone";
          continue;
        }
        const auto now = database_progress(database);
        ASSERT_GE(now.rays_logged, logged) << "finished rays are gone";
        logged = now.rays_logged;
        if (logged > 0 && logged < now.rays_total) ++while_solving;
      }
    }
    std::printf("%d kills, %d of them with some rays finished and some not; %d databases finished\n", struck,
                while_solving, databases);
    EXPECT_GT(while_solving, 0) << "every kill came before the first ray or after the last: nothing could be lost";
  }

  static void kill_process(pid_t child, std::mt19937&) { kill(child, SIGKILL); }

  void expect_whole_and_remove(const std::filesystem::path& database) {
    expect_same_results(folder / "whole.h5", database);
    EXPECT_FALSE(std::filesystem::exists(database.string() + ".log"));
    std::filesystem::remove(database);
  }
};

/// One process that talks to nobody: Open MPI need not look for networks, which takes longer than the solves.
class KilledAlone : public Killed {
 protected:
  void SetUp() override {
    setenv("OMPI_MCA_pml", "ob1", 0);
    setenv("OMPI_MCA_btl", "self", 0);
    setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
    Killed::SetUp();
  }
  void TearDown() override {
    for (const char* name : {"OMPI_MCA_pml", "OMPI_MCA_btl", "OMPI_MCA_ess_singleton_isolated"}) unsetenv(name);
    Killed::TearDown();
  }
};

TEST_F(KilledAlone, ProcessEndsAtTheSameDatabase) {
  const auto database = folder / "database.h5";
  torment({PHYNNESS_COMMAND, "precompute", "scene.toml", "-o", "database.h5", "--resume"}, database, 24, kill_process,
          [&] { expect_whole_and_remove(database); });
}

TEST_F(KilledAlone, PartEndsAtTheSameDatabase) {
  const auto database = folder / "database.h5";
  torment({PHYNNESS_COMMAND, "precompute", "scene.toml", "-o", "database.h5", "--part", "1/2"}, database, 22,
          kill_process, [&] {
            succeed("precompute scene.toml -o database.h5 --resume");
            expect_whole_and_remove(database);
          });
}

TEST_F(Killed, RanksEndAtTheSameDatabase) {
  const auto database = folder / "database.h5";
  const std::vector<std::string> command{"mpirun",     "--oversubscribe", "-n", "3",           PHYNNESS_COMMAND,
                                         "precompute", "scene.toml",      "-o", "database.h5", "--resume"};
  bool one = false;
  const auto kill_ranks = [&](pid_t mpirun, std::mt19937& random) {
    auto ranks = children_of(mpirun);
    if ((one = !one) && !ranks.empty()) {
      kill(ranks[random() % ranks.size()], SIGKILL);  // mpirun ends the others
      return;
    }
    kill(mpirun, SIGKILL);
    for (const pid_t rank : ranks) kill(rank, SIGKILL);
  };
  torment(command, database, 8, kill_ranks, [&] { expect_whole_and_remove(database); });
}

}  // namespace
}  // namespace phynness::test
