// Text files that are whole or absent.
#pragma once

#include <filesystem>
#include <string>

namespace phynness {

/// Writes beside `file` and renames, so that whoever reads never sees half of it; a symbolic link is
/// followed, and what is no regular file (a pipe, /dev/stdout) is written to as it is.
/// @throws Error (input) if the file cannot be made, (failure) if it cannot be filled
void write_text_file(const std::filesystem::path& file, const std::string& text);

}  // namespace phynness
