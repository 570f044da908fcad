// Text files that are whole or absent.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace phynness {

/// Writes beside `file` and renames, so that whoever reads never sees half of it; a symbolic link is
/// followed, and what is no regular file (a pipe, /dev/stdout) is written to as it is.
/// @throws Error (input) if the file cannot be made, (failure) if it cannot be filled
void write_text_file(const std::filesystem::path& file, const std::string& text);

/// Several files that belong together: all of them are filled beside their places before the first is renamed, so that
/// a full disk leaves what was there. @throws Error, as write_text_file()
void write_text_files(const std::vector<std::pair<std::filesystem::path, std::string>>& files);

}  // namespace phynness
