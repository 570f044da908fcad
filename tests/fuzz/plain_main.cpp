// Runs a fuzz target without libFuzzer: its seeds, then the requested number of changed seeds, which are the same in
// every run. Usage: regress_TARGET [RUNS] [FILE ...]. Files are the seeds; without RUNS they are not changed. An input
// that ends the program is kept in crash-TARGET.
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "fuzz_target.hpp"

using namespace phynness::fuzz;

namespace {

Input current;
std::string crash_file;
Random random_numbers(1);

void keep_input(int signal) {
  // The program ends anyway: nothing is lost if this call is not safe here.
  if (std::FILE* file = std::fopen(crash_file.c_str(), "wb")) {
    std::fwrite(current.data(), 1, current.size(), file);
    std::fclose(file);
    std::fprintf(stderr, "the input is in %s\n", crash_file.c_str());
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void run(const Input& input) {
  current = input;
  // A copy of its own size: reading beyond it shows under a sanitizer.
  const Input exact(input.begin(), input.end());
  LLVMFuzzerTestOneInput(exact.data(), exact.size());
}

}  // namespace

/// For a target whose seeds are files.
__attribute__((weak)) std::vector<Input> phynness::fuzz::seeds() { return {}; }

extern "C" {
__attribute__((weak)) std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                                          unsigned) {
  return LLVMFuzzerMutate(data, size, max_size);
}

std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size) {
  Random& random = random_numbers;
  if (size == 0 || (random.below(8) == 0 && size < max_size)) {
    const std::size_t at = random.below(size + 1);
    std::memmove(data + at + 1, data + at, size - at);
    data[at] = static_cast<std::uint8_t>(random.next());
    return size + 1;
  }
  const std::size_t at = random.below(size), n = std::min(size - at, random.below(8) + 1);
  switch (random.below(5)) {
    case 4:
      for (std::size_t i = at; i < size; ++i) data[i] = static_cast<std::uint8_t>(random.next());
      return size;
    case 0:
      data[at] ^= static_cast<std::uint8_t>(1U << random.below(8));
      return size;
    case 1:
      for (std::size_t i = 0; i < n; ++i) data[at + i] = static_cast<std::uint8_t>(random.next());
      return size;
    case 2:
      std::memmove(data + at, data + random.below(size - n + 1), n);
      return size;
    default:
      std::memmove(data + at, data + at + n, size - at - n);
      return size - n;
  }
}
}

int main(int argc, char** argv) {
  crash_file = "crash-" + std::filesystem::path(argv[0]).filename().string();
  std::signal(SIGABRT, keep_input);
  std::signal(SIGSEGV, keep_input);
  std::signal(SIGFPE, keep_input);
  Random& random = random_numbers;
  char* end = nullptr;
  const long number = argc > 1 ? std::strtol(argv[1], &end, 10) : 2000;
  const bool counted = argc < 2 || *end == '\0';
  const long runs = counted ? number : 0;
  std::vector<Input> from;
  for (int i = counted ? 2 : 1; i < argc; ++i) {
    std::ifstream file(argv[i], std::ios::binary);
    if (!file) {
      std::fprintf(stderr, "cannot read %s\n", argv[i]);
      return 2;
    }
    from.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  if (from.empty()) from = seeds();
  if (from.empty()) {
    std::fputs("this target needs files as seeds\n", stderr);
    return 2;
  }
  for (const auto& seed : from) run(seed);
  for (long i = 0; i < runs; ++i) {
    Input input = from[static_cast<std::size_t>(i) % from.size()];
    std::size_t size = input.size();
    const std::size_t max_size = std::max<std::size_t>(1 << 16, size);
    input.resize(max_size);
    for (std::size_t n = random.below(4) + 1; n > 0; --n)
      size = LLVMFuzzerCustomMutator(input.data(), size, max_size, static_cast<unsigned>(random.next()));
    input.resize(size);
    run(input);
  }
  std::printf("%zu seeds, %ld changed ones\n", from.size(), runs);
  return 0;
}
