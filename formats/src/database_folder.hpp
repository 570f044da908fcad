// Folders of a database that is being written.
#pragma once

#include <filesystem>

namespace phynness {

/// @throws Error (input) unless the folder of `file` exists and is writable
void check_folder_of(const std::filesystem::path& file);
/// Creates FILE.log/ if it does not exist. @throws Error (failure)
void make_log_folder(const std::filesystem::path& file);
/// Removes the logs in FILE.log/, and the folder if nothing else is in it: what others put there is theirs.
void remove_logs(const std::filesystem::path& file);

}  // namespace phynness
