// Files that a person named, read whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace phynness {

struct InputFile {
  std::string what;    ///< for messages: "the scene file"
  std::string remedy;  ///< where it is missing or something else than a file
  std::uint64_t most_bytes = 0;
  bool is_text = true;  ///< texts hold no zeros
};

/// @throws Error (input) if `file` is missing, a folder, a pipe or a device, may not be read, or is larger than
/// `about.most_bytes`; (failure) if reading fails
std::string read_input_file(const std::filesystem::path& file, const InputFile& about);

/// The checks of read_input_file() before it reads, for a file that is read in parts.
/// @throws Error (input), as read_input_file()
void require_input_file(const std::filesystem::path& file, const InputFile& about);

}  // namespace phynness
