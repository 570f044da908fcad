// Text files that are either complete or absent.
#pragma once

#include <filesystem>
#include <string>

namespace phynness {

/// Writes a temporary file and renames it to `file`, so that a reader never sees an incomplete file. Symbolic links are
/// followed. A file that is not regular (a pipe, /dev/stdout) is written directly.
/// @throws Error (input) if the file cannot be created, (failure) if writing fails
void write_text_file(const std::filesystem::path& file, const std::string& text);

}  // namespace phynness
