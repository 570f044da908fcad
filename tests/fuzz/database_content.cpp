// A database with wrong values in valid HDF5, or with changed bytes in its logs, is read and used for training, or
// results in an Error, but never in a model with values that are not finite. Input: a byte (below), then changes: of
// values by HDF5 (database_changes.hpp), or of bytes of a log as pairs of place and value.
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <phynness/formats/error.hpp>
#include <phynness/training/training.hpp>

#include "database_changes.hpp"
#include "small_database.hpp"

namespace phynness::fuzz {
namespace {

namespace fs = std::filesystem;

// Bits of the first byte.
constexpr int of_bytes = 1, unfinished = 2, rich = 4, sealed = 8, networks = 16, of_forces = 32;

class Folder {
 public:
  Folder() {
    // In memory where there is such a place: thousands of files are written a second.
    const fs::path memory = "/dev/shm";
    std::error_code code;
    const auto place = ::access(memory.c_str(), W_OK) == 0 ? memory : fs::temp_directory_path(code);
    std::string pattern = (place / "phynness-fuzz-XXXXXX").string();
    require(::mkdtemp(pattern.data()) != nullptr, "a folder for databases");
    _path = pattern;
  }
  ~Folder() {
    std::error_code code;
    fs::remove_all(_path, code);
  }
  const fs::path& path() const { return _path; }

 private:
  fs::path _path;
};

Input bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}
void write_bytes(const fs::path& file, const Input& bytes) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// The databases that are changed, made once.
struct Originals {
  Folder folder;
  Input file[2][2], log[2];  // [rich][complete], [rich]
  std::size_t record_bytes[2];

  Originals() {
    for (const bool with : {false, true}) {
      for (const bool complete : {false, true}) {
        const auto path = folder.path() / ("original" + std::to_string(with) + std::to_string(complete));
        write_small_database(path, with, complete);
        file[with][complete] = bytes_of(path);
        if (!complete) log[with] = bytes_of(path.string() + ".log/rank-0000");
      }
      constexpr std::size_t opening_bytes = 72, n_records = 12;
      record_bytes[with] = (log[with].size() - opening_bytes) / n_records;
    }
  }
};

void change_bytes(Input& bytes, Script& script) {
  while (!script.at_end() && !bytes.empty()) {
    const std::size_t at = script.raw<std::uint32_t>() % bytes.size();
    const std::size_t n = std::min<std::size_t>(bytes.size() - at, 1U << script.below(11));
    const std::uint8_t value = script.byte();
    if (n > 16) {
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), n, std::uint8_t{0});
    } else {
      for (std::size_t i = at; i < at + n; ++i) bytes[i] ^= i == at ? value : script.byte();
    }
  }
}

void check_model(const Database& database, int how) {
  TrainingSpec spec;
  spec.family = how & networks ? Family::rbfn : Family::modal;
  spec.deformation_neurons = spec.force_neurons = spec.force_centers = spec.amplitude_centers = 4;
  spec.deformation_spread = spec.force_spread = 0.75;
  spec.samples = 50;
  spec.modes = how & of_forces ? 0 : 2;
  spec.shared_modes = 2;
  spec.near_nodes = 1;
  TrainingReport report;
  const Model model = train(database, spec, report, {}, 1);
  const std::string text = write_model_text(model);
  require(write_model_text(read_model_text(text, "model.txt")) == text, "a model that can be read");
  const std::string mesh = write_mesh_text(database.header().mesh);
  read_mesh_text(mesh, "mesh.txt");
}

void read_all(const Database& database) {
  const auto& header = database.header();
  const auto summary = summarize(database);
  require(std::isfinite(summary.seconds) && std::isfinite(summary.min_jacobian), "finite costs");
  require(
      database.statuses().size() == header.sets.active.size() * header.directions.size() * header.magnitudes_m.size(),
      "a status of every increment");
  node_normals(header.mesh);
  for (std::int32_t a = 0; a < static_cast<std::int32_t>(header.sets.active.size()); ++a)
    for (const Ray& ray : database.rays(a))
      for (std::size_t i = 0; i < ray.status.size(); ++i)
        if (ray.status[i] == Status::converged)
          for (std::size_t k = 0; k < 3; ++k) require(std::isfinite(ray.force[3 * i + k]), "finite forces");
}

}  // namespace

std::vector<Input> seeds() {
  std::vector<Input> all;
  for (const int bits : {0, rich, sealed, rich | sealed, networks, unfinished, rich | unfinished, of_bytes | unfinished,
                         of_bytes | unfinished | sealed, rich | of_forces}) {
    const auto how = static_cast<std::uint8_t>(bits);
    all.push_back({how});
    // Values and an attribute.
    for (std::uint8_t kind = 0; kind < 4; ++kind)
      for (std::uint8_t object = 0; object < 24; object = static_cast<std::uint8_t>(object + 5))
        all.push_back({how, kind, object, 1, 0, 0, 3, 70, 0, 0, 0, 0, 0, 0, 0});
  }
  return all;
}

}  // namespace phynness::fuzz

using namespace phynness;
using namespace phynness::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Originals originals;
  Script script(data, size);
  const int how = script.byte();
  const bool with = how & rich, complete = !(how & unfinished);
  const fs::path file = originals.folder.path() / "database.h5", logs = file.string() + ".log";
  const Input& bytes = originals.file[with][complete];
  if (!complete) {
    fs::create_directories(logs);
    Input log = originals.log[with];
    if (how & of_bytes) change_bytes(log, script);
    if (how & sealed) seal_log(log, originals.record_bytes[with]);
    write_bytes(logs / "rank-0000", log);
  }
  write_bytes(file, bytes);
  if (!(how & of_bytes)) change_objects(file, script);
  if (how & sealed) seal_mesh(file);
  try {
    if (!complete) {
      const auto header = read_database_header(file);
      database_progress(file);
      DatabaseWriter::pack(file, header);
    }
    const Database database = Database::open(file);
    read_all(database);
    check_model(database, how);
  } catch (const Error& error) {
    require(std::string_view(error.what()).size() > 10, "an error in words");
  }
  std::error_code code;
  fs::remove_all(logs, code);
  fs::remove(file, code);
  return 0;
}
