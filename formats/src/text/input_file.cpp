#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <system_error>

namespace phynness {
namespace fs = std::filesystem;

void require_input_file(const fs::path& file, const InputFile& about) {
  std::error_code code;
  const auto status = fs::status(file, code);
  if (status.type() == fs::file_type::not_found)
    throw input_error(about.what + " does not exist", file.string(), about.remedy);
  if (code || ::access(file.c_str(), R_OK) != 0)
    throw input_error(
        about.what + " cannot be opened: " + (code ? code.message() : std::generic_category().message(errno)),
        file.string(), "check its permissions");
  if (fs::is_directory(status))
    throw input_error(about.what + " is a folder", file.string(), "give the name of a file in it");
  if (!fs::is_regular_file(status))
    throw input_error(about.what + " is a pipe or a device, not a file", file.string(),
                      "write what comes out of it into a file first");
  if (const auto size = fs::file_size(file, code); size > about.most_bytes)
    throw input_error(about.what + " is too large", file.string() + ", " + std::to_string(size) + " bytes",
                      "no more than " + std::to_string(about.most_bytes) + " bytes are read");
}

std::string read_input_file(const fs::path& file, const InputFile& about) {
  require_input_file(file, about);
  std::string bytes(fs::file_size(file), '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(bytes.data(), std::ssize(bytes));
  if (in.bad() || in.gcount() < std::ssize(bytes))
    throw failure("cannot read " + file.string(), "it has become shorter, or the disk fails", "check the disk");
  if (const auto zero = bytes.find('\0'); about.is_text && zero != bytes.npos)
    throw input_error(
        file.string() + ":" +
            std::to_string(1 + std::count(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(zero), '\n')) +
            ": " + about.what + " holds a zero byte, which no text has",
        "byte " + std::to_string(zero), "it is damaged or no text file: " + about.remedy);
  return bytes;
}

}  // namespace phynness
