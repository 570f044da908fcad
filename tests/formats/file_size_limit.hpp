// A stand-in for a full disk.
#pragma once

#include <sys/resource.h>

#include <csignal>

namespace phynness::test {

/// The size limit of files stands in for a full disk: write(2) comes back short, then fails.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    _handler = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &_before);
    rlimit limit = _before;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &_before);
    std::signal(SIGXFSZ, _handler);
  }

 private:
  rlimit _before{};
  void (*_handler)(int) = SIG_DFL;
};

}  // namespace phynness::test
