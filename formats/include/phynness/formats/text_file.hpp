// Text files that are either complete or absent.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace phynness {

/// A text that is filled beside its place, in FILE.part, and gets its name when it is complete, so that a reader never
/// sees an incomplete file. Without put() or keep() the part is removed. Symbolic links are followed. A file that is
/// not regular (a pipe, /dev/stdout) is written directly.
class GrowingTextFile {
 public:
  /// @throws Error (input) if the file cannot be created
  explicit GrowingTextFile(const std::filesystem::path& file);
  ~GrowingTextFile();
  GrowingTextFile(const GrowingTextFile&) = delete;

  /// The text has left this process afterwards. @throws Error (failure)
  void append(const std::string& text);
  /// Gives the file its name. @throws Error (failure)
  void put();
  /// From now on what is written stays beside its place, unless put() follows. @return where it is
  std::filesystem::path keep();

 private:
  [[noreturn]] void fail() const;

  std::filesystem::path _file, _target, _written;
  bool _in_place = false, _made = false;
  std::ofstream _out;
};

/// Writes a GrowingTextFile that is complete at once. @throws Error (input) if the file cannot be created, (failure) if
/// writing fails
void write_text_file(const std::filesystem::path& file, const std::string& text);

/// Several files that belong together: all of them are filled beside their places before the first is renamed, so that
/// a full disk leaves what was there. @throws Error, as write_text_file()
void write_text_files(const std::vector<std::pair<std::filesystem::path, std::string>>& files);

}  // namespace phynness
