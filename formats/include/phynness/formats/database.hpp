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
  after_end = 3,       ///< the ray ends before: a fold, a crushed cell or the force limit of the scene
  inverted = -1,       ///< J <= 0 at a quadrature point
  diverged = -2,       ///< line search or iteration limit, or an equilibrium that the continuous body does not have
  factorization = -3,  ///< singular or failed factorization
  not_finite = -4,     ///< NaN or infinity in the residual, the energy or a field
  after_failure = -5,  ///< an earlier increment of the ray failed
  library_error = -6,  ///< a library call failed or memory ran out; the solver's log has the message
};
inline constexpr Status every_status[] = {
    Status::converged, Status::not_requested, Status::not_solved, Status::after_end,     Status::inverted,
    Status::diverged,  Status::factorization, Status::not_finite, Status::after_failure, Status::library_error};
const char* name(Status);
/// What it means, in a few words for people.
const char* meaning(Status);

/// Why a ray ends where it ends. Values are stored; never renumber.
enum class EndReason : std::int8_t {
  full_depth = 0,     ///< all increments are solved
  fold = 1,           ///< the body loses energy at once: it snaps, or the mesh folds
  crushed = 2,        ///< the smallest J falls below [probe] min_jacobian
  force_limit = 3,    ///< the force exceeds [probe] max_force_N
  not_requested = 4,  ///< direction outside the hemisphere
  solver = -1,        ///< an increment could not be solved; its status tells why
  not_recorded = -2,  ///< the ray was solved by a version that does not record it, and did not fail
};
inline constexpr EndReason every_end[] = {EndReason::full_depth,  EndReason::fold,          EndReason::crushed,
                                          EndReason::force_limit, EndReason::not_requested, EndReason::solver,
                                          EndReason::not_recorded};
const char* name(EndReason);
/// What it means, in a few words for people.
const char* meaning(EndReason);

/// The end of a ray.
struct RayEnd {
  EndReason reason = EndReason::not_recorded;
  double depth_m = 0;        ///< up to which the ray is followed; of a fold, of a crushed cell: where it happens
  double fold_depth_m = 0;   ///< of the first fold, also if the ray goes on; 0 without a fold
  double energy_lost_J = 0;  ///< there: work of the force minus change of the stored energy
  /// True if something known ended the ray before its full depth.
  bool is_early() const {
    return reason != EndReason::full_depth && reason != EndReason::not_requested && reason != EndReason::not_recorded;
  }
};

/// One ray: an active node displaced along one direction in n_increments steps. All SI.
/// Arrays have n_increments entries (x ...). Entries of increments that did not converge are zero.
struct Ray {
  std::int32_t active = 0;     ///< index into NodeSets::active
  std::int32_t direction = 0;  ///< index into the directions
  std::vector<Status> status;
  std::vector<double> force;                  ///< x 3 [N]: force that must be applied to hold the displacement
  std::vector<double> energy;                 ///< [J] stored strain energy
  std::vector<double> tangent;                ///< x 9 [N/m], row-major dF/dd; empty unless the database has tangents
  std::vector<std::int32_t> negative_pivots;  ///< of the tangent, without those of the pressure block; 0 = stable
  std::vector<std::int32_t> iterations;       ///< Newton iterations, including those of cut-back attempts
  std::vector<std::int32_t> cutbacks;
  std::vector<double> min_jacobian;         ///< smallest J over all quadrature points
  std::vector<double> seconds;              ///< CPU time spent
  std::vector<double> displacement;         ///< x n_output x 3 [m]
  std::vector<std::vector<double>> fields;  ///< of DatabaseHeader::fields: x n_output, in the field's unit
  RayEnd end;
};

/// Contents of a database except the rays. Empty `mesh_hash` and `physics_hash` are computed when a database is
/// created.
struct DatabaseHeader {
  Mesh mesh;
  NodeSets sets;
  std::vector<Vec3> directions;      ///< unit vectors
  std::vector<double> magnitudes_m;  ///< increments, ascending; the last is the maximum displacement
  bool tangents = false, float64 = false;
  std::vector<Field> fields;  ///< stored at the output nodes, in the order of the enum; always float32
  std::string scene_text, scene_name, scene_folder;
  std::string physics_hash, mesh_hash, software_version;
  /// Set if the file contains the rays of one shard only; never in a finished database.
  std::optional<Shard> shard;
};

/// The scene of a database. Its mesh file may be absent. If it does not name an element, the element is the default
/// with which the database was solved. The physics hash tells which: P1 was the default before p1-p1.
/// @throws Error (input) as parse_scene()
Scene stored_scene(const DatabaseHeader& header);

/// Figures of a finished database.
struct DatabaseSummary {
  std::map<Status, std::int64_t> states;  ///< increments per outcome; outcomes that do not occur are absent
  std::int64_t rays = 0;                  ///< rays with at least one requested increment
  std::int64_t failed_rays = 0;           ///< those of them with a failed increment
  std::int64_t newton_iterations = 0;
  std::int64_t unstable_states = 0;  ///< converged with a negative pivot: the result may depend on the path
  double seconds = 0;                ///< CPU time of all solves
  double min_jacobian = 0;           ///< smallest J over all converged states; 0 if there is none
};

/// Where the rays of a database end. Shares of the probe volume weigh each ray by the cube of its depth.
struct EndSummary {
  std::int64_t rays = 0;                      ///< requested rays
  std::map<EndReason, std::int64_t> reasons;  ///< rays per reason; reasons that do not occur are absent
  std::map<EndReason, double> volume;         ///< share of the probe volume beyond the ends, per reason
  std::int64_t folds = 0;                     ///< rays with a fold, of those that go on, too
  double largest_loss_J = 0;                  ///< largest energy lost at a fold
  std::vector<double> reached;                ///< per active node: share of its probe volume before the ends
  std::vector<std::int32_t> early;            ///< per active node: rays that end early
  bool is_recorded = true;                    ///< false in files of versions that do not record ends
  double share_of_rays() const;               ///< that end early
  double share_of_volume() const;             ///< beyond the ends
};

/// A finished database, read by active node in any order. h5py reads the same arrays.
class Database {
 public:
  /// @throws Error (input) if the file is not a database, of another version, damaged, or unfinished; the remedy of an
  /// unfinished database is --resume
  static Database open(const std::filesystem::path& file);
  /// True if all rays have been packed into the file.
  static bool is_complete(const std::filesystem::path& file);
  ~Database();
  Database(Database&&) noexcept;
  Database& operator=(Database&&) noexcept;

  const DatabaseHeader& header() const;
  /// All rays of one active node (index into sets.active), one per direction, in order.
  std::vector<Ray> rays(std::int32_t active) const;
  /// Status of every increment, [active][direction][increment] flattened.
  std::vector<Status> statuses() const;

  /// End of every ray, [active][direction] flattened. In files of versions that do not record them, the reason is
  /// solver if an increment failed, else not_recorded, and the depth is that of the last converged increment.
  std::vector<RayEnd> ends() const;

  friend DatabaseSummary summarize(const Database& database);

 private:
  struct Impl;
  explicit Database(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> _impl;
};

/// Reads all datasets except the displacements.
DatabaseSummary summarize(const Database& database);

/// @param ends  of all rays, [active][direction] flattened
EndSummary summarize_ends(const DatabaseHeader& header, const std::vector<RayEnd>& ends);
EndSummary summarize_ends(const Database& database);

/// A part of a log without a complete record. It is ignored, and its rays are solved again with --resume.
struct LogDamage {
  std::filesystem::path log;
  std::string reason;
  std::int64_t dropped_bytes = 0;
};
/// Progress of an unfinished database.
struct DatabaseProgress {
  bool complete = false;
  std::optional<Shard> shard;                    ///< rays_total then counts its rays only
  std::int64_t rays_logged = 0, rays_total = 0;  ///< without mirror images
  std::vector<LogDamage> damage;
};
/// @throws Error (input) if the file is not a database
DatabaseProgress database_progress(const std::filesystem::path& file);

/// The header of a finished or unfinished database.
/// @throws Error (input) if the file is not a database, of another version, or damaged
DatabaseHeader read_database_header(const std::filesystem::path& file);

/// Writer of a database. Rank 0 creates the header file and packs. Every rank appends to its own log,
/// FILE.log/rank-NNNN, so that ranks need no common lock and a killed process loses at most one record.
class DatabaseWriter {
 public:
  /// Creates FILE (the header, marked as unfinished) and an empty FILE.log/. With `resume`, logged rays are kept, and a
  /// finished file is left as it is. Must be called in one process only.
  /// @throws Error (input) if FILE exists and `resume` is false, or if the physics or mesh of an existing FILE differ
  static void create(const std::filesystem::path& file, const DatabaseHeader& header, bool resume);

  /// What create() refuses is refused, and nothing is written.
  static void check(const std::filesystem::path& file, const DatabaseHeader& header, bool resume);

  /// The part of check() that needs no header. @return whether FILE exists
  /// @throws Error (input) if FILE or its logs exist and `resume` is false
  static bool refuse_begun(const std::filesystem::path& file, bool resume);
  /// Flags, n_active x n_directions, of the rays that are in the logs or are mirror images of such rays. Torn and
  /// corrupted records are ignored.
  static std::vector<char> logged(const std::filesystem::path& file, const DatabaseHeader& header);

  /// Creates the log of this process. It is always a new file, because a resumed run may have another number of ranks.
  /// @throws Error (failure) if it cannot be created
  DatabaseWriter(const std::filesystem::path& file, const DatabaseHeader& header, int rank);
  ~DatabaseWriter();
  DatabaseWriter(DatabaseWriter&&) noexcept;
  DatabaseWriter& operator=(DatabaseWriter&&) noexcept;
  /// Appends one ray as length, payload and checksum, and passes it to the operating system before it returns.
  /// @throws Error (failure) after a failed write, such as on a full disk; the log then ends at the last complete
  /// record
  void append(const Ray& ray);
  /// Forces the log to the disk and closes it. @throws Error (failure), which the destructor cannot do
  void close();

  /// Packs all logs into a new file, renames it to FILE, and removes FILE.log. Must be called in one process, after all
  /// processes have closed their logs.
  /// @throws Error (failure) if rays are missing
  static void pack(const std::filesystem::path& file, const DatabaseHeader& header);

 private:
  struct Impl;
  std::unique_ptr<Impl> _impl;
};

}  // namespace phynness
