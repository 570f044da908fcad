#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <system_error>

#include "durable_file.hpp"

namespace phynness {
namespace {

/// The file of a path that goes through it as if it were a folder; empty: there is none.
std::filesystem::path file_in_place_of_a_folder(const std::filesystem::path& path) {
  std::error_code code;
  for (auto part = path.parent_path(); !part.empty() && part != part.parent_path(); part = part.parent_path())
    if (std::filesystem::exists(part, code)) return std::filesystem::is_directory(part, code) ? "" : part;
  return {};
}

/// @throws Error (input) unless a regular file is opened
Descriptor open_input(const std::filesystem::path& file, const InputFile& about, std::uint64_t& size) {
  // A pipe without a writer would keep an open() waiting.
  Descriptor input(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  const bool missing = !input.is_open() && (errno == ENOENT || errno == ENOTDIR);
  if (missing && errno == ENOTDIR)
    if (const auto other = file_in_place_of_a_folder(file); !other.empty())
      throw input_error(about.what + " cannot be there, because this is a file and no folder", other.string(),
                        about.remedy);
  if (missing) throw input_error(about.what + " does not exist", file.string(), about.remedy);
  if (!input.is_open())
    throw input_error(about.what + " cannot be opened: " + std::generic_category().message(errno), file.string(),
                      "check its permissions");
  struct stat status {};
  if (::fstat(input.get(), &status) != 0 || S_ISDIR(status.st_mode))
    throw input_error(about.what + " is a folder", file.string(), about.remedy);
  if (!S_ISREG(status.st_mode))
    throw input_error(about.what + " is a pipe or a device, not a file", file.string(),
                      "write what comes out of it into a file first");
  size = static_cast<std::uint64_t>(status.st_size);
  if (size > about.most_bytes)
    throw input_error(about.what + " is too large", file.string() + ", " + std::to_string(size) + " bytes",
                      "no more than " + std::to_string(about.most_bytes) + " bytes are read");
  return input;
}

}  // namespace

void require_input_file(const std::filesystem::path& file, const InputFile& about) {
  std::uint64_t size = 0;
  open_input(file, about, size);
}

std::string read_input_file(const std::filesystem::path& file, const InputFile& about) {
  constexpr std::size_t part = 1 << 20;
  std::uint64_t size = 0;
  const Descriptor input = open_input(file, about, size);
  std::string bytes;
  while (bytes.size() < size) {
    const std::size_t before = bytes.size(), wanted = std::min<std::uint64_t>(part, size - before);
    // A text may end at a zero long before its size is reached; of other files the memory is taken once.
    if (!about.is_text && before == 0) bytes.reserve(size);
    bytes.resize(before + wanted);
    const std::size_t got = read_at(input, file, static_cast<std::int64_t>(before), bytes.data() + before, wanted);
    bytes.resize(before + got);
    if (about.is_text && got > 0) {
      if (const void* zero = std::memchr(bytes.data() + before, 0, got)) {
        const auto at = static_cast<const char*>(zero) - bytes.data();
        throw input_error(file.string() + ":" +
                              std::to_string(1 + std::count(bytes.begin(), bytes.begin() + at, '\n')) + ": " +
                              about.what + " holds a zero byte, which no text has",
                          "byte " + std::to_string(at), "it is damaged or no text file: write or copy it again");
      }
    }
    if (got < wanted) break;  // it became shorter in the meantime
  }
  return bytes;
}

}  // namespace phynness
