#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <phynness/drawing/gnuplot.hpp>
#include <phynness/formats/error.hpp>

namespace phynness::report {
namespace {

/// Empty if the command failed.
std::optional<std::string> output_of(const std::string& command) {
  std::string out;
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return std::nullopt;
  std::array<char, 4096> part;
  for (std::size_t n = 0; (n = std::fread(part.data(), 1, part.size(), pipe)) > 0;) out.append(part.data(), n);
  if (pclose(pipe) != 0) return std::nullopt;
  return out;
}

/// Text as one word for a shell.
std::string shell_word(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') {
      out += "'\\''";
    } else {
      out += c;
    }
  }
  return out + "'";
}

class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text) {
    std::string name = (std::filesystem::temp_directory_path() / "phynness_plot_XXXXXX").string();
    const int file = mkstemp(name.data());
    if (file < 0) throw failure("no temporary file can be made", name, "free space on the disk, or set TMPDIR");
    std::FILE* out = fdopen(file, "w");
    const bool written = std::fwrite(text.data(), 1, text.size(), out) == text.size();
    _path = name;
    if (std::fclose(out) != 0 || !written)
      throw failure("writing failed", name, "free space on the disk, or set TMPDIR");
  }
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(_path, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& path() const { return _path; }

 private:
  std::filesystem::path _path;
};

}  // namespace

bool gnuplot_is_there() { return output_of("gnuplot --version 2>/dev/null").has_value(); }

std::string gnuplot(const std::string& script, const std::string& what, const std::string& remedy) {
  const TemporaryFile file(script);
  // -d: without the user's ~/.gnuplot, so that pages look the same for all users.
  const auto out = output_of("gnuplot -d " + shell_word(file.path().string()) + " 2>/dev/null");
  if (!out) throw failure("gnuplot failed", what, "install gnuplot-nox, or " + remedy);
  return *out;
}

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') out += '\'';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "'";
}

}  // namespace phynness::report
