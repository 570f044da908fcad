// Outputs of a command are looked at before its work starts, which may take hours, and are written independently.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace phynness::cli {

/// "-", which only --json takes: its JSON then goes to stdout, and the texts for people to stderr.
bool is_stdout(const std::filesystem::path& path);

/// The path itself or the nearest folder above it that exists.
std::filesystem::path existing_part(std::filesystem::path path);

/// Symbolic links are followed. Pipes must have a reader, because opening them would otherwise wait for one.
/// @param option  for messages
/// @param made  folders that the command makes itself
/// @throws Error (input) if the file cannot be written: no folder, no permission, a folder of that name, a pipe that
/// nobody reads
void check_file_place(const std::string& option, const std::filesystem::path& file,
                      const std::vector<std::filesystem::path>& made);

/// @param begin  of every text that this program writes under this name
/// @throws Error (input) if there is a file with another beginning, which would be lost
void check_own_text(const std::string& option, const std::filesystem::path& file, std::string_view begin);

/// @throws Error (input) if the folder neither is there and writable nor can be made
void check_folder_place(const std::string& option, const std::filesystem::path& folder);

/// Writes every output, also after one that failed. Reports all failures.
/// @throws the last failure; those before are printed on stderr
void write_each(const std::vector<std::function<void()>>& outputs);

}  // namespace phynness::cli
