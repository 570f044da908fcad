// The places that a database under construction needs.
#pragma once

#include <filesystem>

namespace phynness {

/// @throws Error (input) unless the folder that `file` is to be in exists and can be written
void check_folder_of(const std::filesystem::path& file);
/// FILE.log/, if it is not there yet. @throws Error (failure)
void make_log_folder(const std::filesystem::path& file);
/// Removes the logs in FILE.log/, and the folder if nothing else is in it: what others put there is theirs.
void remove_logs(const std::filesystem::path& file);

}  // namespace phynness
