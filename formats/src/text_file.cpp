#include <fstream>
#include <memory>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>

namespace phynness {
namespace {

namespace fs = std::filesystem;

/// A file that is filled beside its place; removed again unless it is put there.
class FileBeside {
 public:
  explicit FileBeside(const fs::path& file) : _file(file) {
    std::error_code code;
    _target = fs::is_symlink(file, code) ? fs::weakly_canonical(file, code) : file;
    _in_place = fs::exists(_target, code) && !fs::is_regular_file(_target, code);
    _written = _target;
    if (!_in_place) _written += ".part";
  }
  ~FileBeside() {
    std::error_code code;
    if (!_in_place && _made) fs::remove(_written, code);
  }
  FileBeside(const FileBeside&) = delete;

  void fill(const std::string& text) {
    std::ofstream out(_written, std::ios::binary | std::ios::trunc);
    if (!out)
      throw input_error("cannot write the file", _file.string(), "check that the folder exists and is writable");
    _made = true;
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    out.close();
    if (!out) fail();
  }
  void put() {
    std::error_code code;
    if (!_in_place) fs::rename(_written, _target, code);
    if (code) fail();
    _made = false;
  }

 private:
  [[noreturn]] void fail() const {
    throw failure("writing failed", _file.string(), "check the free space of the disk");
  }

  fs::path _file, _target, _written;
  bool _in_place = false, _made = false;
};

}  // namespace

void write_text_file(const fs::path& file, const std::string& text) {
  FileBeside beside(file);
  beside.fill(text);
  beside.put();
}

void write_text_files(const std::vector<std::pair<fs::path, std::string>>& files) {
  std::vector<std::unique_ptr<FileBeside>> all;
  for (const auto& [file, text] : files) {
    all.push_back(std::make_unique<FileBeside>(file));
    all.back()->fill(text);
  }
  for (const auto& beside : all) beside->put();
}

}  // namespace phynness
