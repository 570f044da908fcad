// The database of response sets. Layout, units and errors: formats/database.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <phynness/formats/shard.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Outcome of one increment. Values are stored; never renumber.
enum class Status : std::int8_t {
  converged = 0,
  not_requested = 1,   ///< direction outside the hemisphere
  not_solved = 2,      ///< no result yet (an unfinished database)
  inverted = -1,       ///< J <= 0 at a quadrature point
  diverged = -2,       ///< line search or iteration limit, or an equilibrium of a mixed element alone
  factorization = -3,  ///< singular or failed factorization
  not_finite = -4,     ///< NaN or infinity in the residual, the energy or a field
  after_failure = -5,  ///< an earlier increment of the ray failed
  library_error = -6,  ///< a library call failed or memory ran out; the solver's log has the message
};
inline constexpr Status every_status[] = {Status::converged,  Status::not_requested, Status::not_solved,
                                          Status::inverted,   Status::diverged,      Status::factorization,
                                          Status::not_finite, Status::after_failure, Status::library_error};
const char* name(Status);

/// One ray: an active node displaced along one direction in n_increments steps. All SI.
/// Arrays are sized n_increments (x ...); entries of increments that did not converge are zero.
struct Ray {
  std::int32_t active = 0;     ///< index into NodeSets::active
  std::int32_t direction = 0;  ///< index into the directions
  std::vector<Status> status;
  std::vector<double> force;                  ///< x 3 [N]: what must be applied to hold the displacement
  std::vector<double> energy;                 ///< [J] stored strain energy
  std::vector<double> tangent;                ///< x 9 [N/m], row-major dF/dd; empty unless asked for
  std::vector<std::int32_t> negative_pivots;  ///< of the tangent beyond those of the pressure block; 0 = stable
  std::vector<std::int32_t> iterations;       ///< Newton iterations spent, cut-back attempts included
  std::vector<std::int32_t> cutbacks;
  std::vector<double> min_jacobian;         ///< smallest J over all quadrature points
  std::vector<double> seconds;              ///< CPU time spent
  std::vector<double> displacement;         ///< x n_output x 3 [m]
  std::vector<std::vector<double>> fields;  ///< of DatabaseHeader::fields: x n_output, in the field's unit
};

/// Everything but the rays. Empty `mesh_hash` and `physics_hash` are filled in when a database is created.
struct DatabaseHeader {
  Mesh mesh;
  NodeSets sets;
  std::vector<Vec3> directions;      ///< unit vectors
  std::vector<double> magnitudes_m;  ///< increments, ascending; the last is the maximum displacement
  bool tangents = false, float64 = false;
  std::vector<Field> fields;  ///< stored at the output nodes, in the order of the enum; always float32
  std::string scene_text, scene_name, scene_folder;
  std::string physics_hash, mesh_hash, software_version;
  /// Set if the file is to hold the rays of one shard only; never in a finished database.
  std::optional<Shard> shard;
};

/// The scene of a database. Its mesh file may be absent. Where it names no element, it is the one that the database was
/// solved with, which the physics hash tells: P1 was the default before p1-p1.
/// @throws Error (input) as parse_scene()
Scene stored_scene(const DatabaseHeader& header);

/// The finished file in a few figures.
struct DatabaseSummary {
  std::map<Status, std::int64_t> states;  ///< increments per outcome; outcomes that do not occur are absent
  std::int64_t rays = 0;                  ///< rays with at least one requested increment
  std::int64_t failed_rays = 0;           ///< of them, rays with an increment that failed
  std::int64_t newton_iterations = 0;
  std::int64_t unstable_states = 0;  ///< converged with a negative pivot: the answer may depend on the path
  double seconds = 0;                ///< CPU time of all solves
  double min_jacobian = 0;           ///< smallest J over all converged states; 0 if there is none
};

/// The finished file. Reading is random access by active node; h5py reads the same arrays.
class Database {
 public:
  /// @throws Error if the file is no database, of another version, damaged, or unfinished (names --resume)
  static Database open(const std::filesystem::path& file);
  /// True if the rays have all been packed into the file.
  static bool is_complete(const std::filesystem::path& file);
  ~Database();
  Database(Database&&) noexcept;
  Database& operator=(Database&&) noexcept;

  const DatabaseHeader& header() const;
  /// All rays of one active node (index into sets.active), one per direction, in order.
  std::vector<Ray> rays(std::int32_t active) const;
  /// Status of every increment, [active][direction][increment] flattened.
  std::vector<Status> statuses() const;

  friend DatabaseSummary summarize(const Database& database);

 private:
  struct Impl;
  explicit Database(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> _impl;
};

/// Reads everything but the displacements.
DatabaseSummary summarize(const Database& database);

/// A stretch of a log without a whole record: dropped, and its rays solved again on --resume.
struct LogDamage {
  std::filesystem::path log;
  std::string reason;
  std::int64_t dropped_bytes = 0;
};
/// How far an unfinished database has come.
struct DatabaseProgress {
  bool complete = false;
  std::optional<Shard> shard;                    ///< rays_total then counts its rays only
  std::int64_t rays_logged = 0, rays_total = 0;  ///< of those that are solved, not mirrored
  std::vector<LogDamage> damage;
};
/// @throws Error if the file is no database
DatabaseProgress database_progress(const std::filesystem::path& file);

/// The header of a finished or unfinished database.
/// @throws Error if the file is no database, of another version, or damaged
DatabaseHeader read_database_header(const std::filesystem::path& file);

/// A database under construction. Rank 0 creates the header file and packs; every rank appends to a log of
/// its own, FILE.log/rank-NNNN, so there is no shared lock and a killed process loses at most the record it
/// was writing.
class DatabaseWriter {
 public:
  /// Creates FILE (header, marked unfinished) and an empty FILE.log/. With `resume`, keeps the rays already
  /// logged and refuses if the physics or mesh of the existing file differ, saying how. A finished file is
  /// returned as finished. Call on one process only.
  /// @throws Error if FILE exists and `resume` is false: "finished work is never lost"
  static void create(const std::filesystem::path& file, const DatabaseHeader& header, bool resume);
  /// Which rays are in the logs, or are mirror images of such: n_active x n_directions flags. Torn or
  /// corrupted records are dropped.
  static std::vector<char> logged(const std::filesystem::path& file, const DatabaseHeader& header);

  /// This process's log: a new file, as a resumed run may have another number of ranks.
  /// @throws Error if it cannot be created
  DatabaseWriter(const std::filesystem::path& file, const DatabaseHeader& header, int rank);
  ~DatabaseWriter();
  DatabaseWriter(DatabaseWriter&&) noexcept;
  DatabaseWriter& operator=(DatabaseWriter&&) noexcept;
  /// Appends one ray: length, payload, checksum; flushed to the operating system before it returns.
  /// @throws Error on a full disk or any failed write; the log then ends at the last whole record
  void append(const Ray& ray);
  /// Forces the log to the disk and closes it, reporting what the destructor cannot.
  void close();

  /// Packs all logs into FILE (written beside it, then renamed) and removes FILE.log. Call on one process,
  /// after all have closed their logs.
  /// @throws Error if rays are missing
  static void pack(const std::filesystem::path& file, const DatabaseHeader& header);

 private:
  struct Impl;
  std::unique_ptr<Impl> _impl;
};

}  // namespace phynness
