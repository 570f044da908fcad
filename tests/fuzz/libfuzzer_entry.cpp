// Under libFuzzer: fuzz_TARGET --write-seeds FOLDER fills a corpus to start from.
#include <filesystem>
#include <fstream>

#include "fuzz_target.hpp"

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc != 3 || std::string_view((*argv)[1]) != "--write-seeds") return 0;
  const std::filesystem::path folder = (*argv)[2];
  std::filesystem::create_directories(folder);
  int i = 0;
  for (const auto& seed : phynness::fuzz::seeds()) {
    std::ofstream file(folder / ("seed-" + std::to_string(i++)), std::ios::binary);
    file.write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
    if (!file.flush()) {
      std::fprintf(stderr, "cannot write to %s\n", (*argv)[2]);
      std::exit(1);
    }
  }
  std::exit(0);
}
