// Text files that are either complete or absent.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace phynness {

/// Writes a temporary file and renames it to `file`, so that a reader never sees an incomplete file. Symbolic links are
/// followed. A file that is not regular (a pipe, /dev/stdout) is written directly.
/// @throws Error (input) if the file cannot be created, (failure) if writing fails
void write_text_file(const std::filesystem::path& file, const std::string& text);

/// Several files that belong together: all of them are filled beside their places before the first is renamed, so that
/// a full disk leaves what was there. @throws Error, as write_text_file()
void write_text_files(const std::vector<std::pair<std::filesystem::path, std::string>>& files);

}  // namespace phynness
