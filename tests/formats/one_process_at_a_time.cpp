// Claims: a database on which a process works is refused to a second process, with a message about the first one, also
// once it is packed. A killed process leaves no lock.
#include <sys/wait.h>

#include <csignal>
#include <phynness/formats/database_lock.hpp>

#include "../as_nobody.hpp"
#include "database_under_test.hpp"

namespace phynness::test {
namespace {

using Lock = DatabaseTest;

TEST_F(Lock, is_refused_to_a_second_process_by_name) {
  {
    const DatabaseLock lock(file);
    EXPECT_EQ(lock.warning(), "");
    const auto own = "process " + std::to_string(getpid());
    expect_names(refusal([&] { DatabaseLock second(file); }), {file.c_str(), own.c_str(), "wait"});
    expect_names(refusal([&] { DatabaseLock::require_free(file); }), {file.c_str(), own.c_str(), "wait"});
  }
  DatabaseLock::require_free(file);
  EXPECT_FALSE(fs::exists(log)) << "an empty folder stays behind";
  const DatabaseLock again(file);
}

TEST_F(Lock, dies_with_its_process) {
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const DatabaseLock lock(file);
    if (write(ready[1], "x", 1) != 1) _exit(1);
    for (;;) pause();
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  refusal([&] { DatabaseLock second(file); });
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(ready[0]);
  close(ready[1]);
  EXPECT_TRUE(fs::exists(log / "lock"));
  const DatabaseLock lock(file);
  EXPECT_EQ(lock.warning(), "");
}

TEST_F(Lock, survives_packing) {
  const auto header = small_header(false);
  write_logs(header);
  {
    const DatabaseLock first(file);
    DatabaseWriter::pack(file, header);
    refusal([&] { DatabaseLock second(file); });
  }
  EXPECT_FALSE(fs::exists(log));
}

TEST_F(Lock, in_a_missing_or_read_only_folder_is_an_error) {
  expect_names(refusal([&] { DatabaseLock lock(folder() / "nowhere" / "a.h5"); }), {"does not exist", "mkdir"});
  fs::permissions(folder(), fs::perms::owner_read | fs::perms::owner_exec);
  const AsNobody as_nobody;
  expect_names(refusal([&] { DatabaseLock lock(file); }), {"not writable"});
}

}  // namespace
}  // namespace phynness::test
