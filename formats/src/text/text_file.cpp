#include <memory>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>

namespace phynness {
namespace fs = std::filesystem;

GrowingTextFile::GrowingTextFile(const fs::path& file) : _file(file) {
  std::error_code code;
  _target = fs::is_symlink(file, code) ? fs::weakly_canonical(file, code) : file;
  _in_place = fs::exists(_target, code) && !fs::is_regular_file(_target, code);
  _written = _target;
  if (!_in_place) _written += ".part";
  // What a link or another name of an older file leads to stays as it is, and a pipe would wait for its reader.
  if (!_in_place && !fs::is_directory(_written, code)) fs::remove(_written, code);
  _out.open(_written, std::ios::binary | std::ios::trunc);
  if (!_out) throw input_error("cannot write the file", _file.string(), "check that the folder exists and is writable");
  _made = true;
}

GrowingTextFile::~GrowingTextFile() {
  std::error_code code;
  if (!_in_place && _made) fs::remove(_written, code);
}

void GrowingTextFile::append(const std::string& text) {
  _out.write(text.data(), static_cast<std::streamsize>(text.size()));
  _out.flush();
  if (!_out) fail();
}

void GrowingTextFile::put() {
  _out.close();
  if (!_out) fail();
  std::error_code code;
  if (!_in_place) fs::rename(_written, _target, code);
  if (code) fail();
  _made = false;
}

fs::path GrowingTextFile::keep() {
  _made = false;
  return _written;
}

void GrowingTextFile::fail() const {
  const bool kept = !_in_place && !_made;
  throw failure("writing failed", _file.string() + (kept ? "; what is written is in " + _written.string() : ""),
                "check the free space of the disk");
}

void write_text_file(const fs::path& file, const std::string& text) {
  GrowingTextFile beside(file);
  beside.append(text);
  beside.put();
}

void write_text_files(const std::vector<std::pair<fs::path, std::string>>& files) {
  std::vector<std::unique_ptr<GrowingTextFile>> all;
  for (const auto& [file, text] : files) {
    all.push_back(std::make_unique<GrowingTextFile>(file));
    all.back()->append(text);
  }
  for (const auto& beside : all) beside->put();
}

}  // namespace phynness
