#include <fstream>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>

namespace phynness {

void write_text_file(const std::filesystem::path& file, const std::string& text) {
  std::error_code code;
  const auto target = std::filesystem::is_symlink(file, code) ? std::filesystem::weakly_canonical(file, code) : file;
  const bool in_place = std::filesystem::exists(target, code) && !std::filesystem::is_regular_file(target, code);
  auto written = target;
  if (!in_place) written += ".part";
  std::ofstream out(written, std::ios::binary | std::ios::trunc);
  if (!out) throw input_error("cannot write the file", file.string(), "check that the folder exists and is writable");
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  bool good = static_cast<bool>(out);
  if (good && !in_place) {
    std::filesystem::rename(written, target, code);
    good = !code;
  }
  if (good) return;
  if (!in_place) std::filesystem::remove(written, code);
  throw failure("writing failed", file.string(), "check the free space of the disk");
}

}  // namespace phynness
