// The database of response sets. Layout, units and errors: formats/database.md.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/ray.hpp>
#include <phynness/formats/scene.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Of a database and its logs. A change of an element's equations that changes forces raises it, too.
inline constexpr std::int32_t format_version = 5;

/// The search for a fold halves an increment this often: a fold is located to a sixteenth of an increment, whatever the
/// full depth is, so that the rays of a shallower scene are the first increments of those of a deeper one.
inline constexpr int fold_halvings = 4;

/// Contents of a database except the rays. Empty `mesh_hash` and `physics_hash` are computed when a database is
/// created.
struct DatabaseHeader {
  Mesh mesh;
  NodeSets sets;
  std::vector<Vec3> directions;      ///< unit vectors
  std::vector<double> magnitudes_m;  ///< increments, ascending; the last is the maximum displacement
  bool imported = false;             ///< responses of another program (imported.hpp), which belong to no scene
  bool tangents = false, float64 = false;
  /// Displacements of an increment are multiples of 2^-field_bits times the power of two below its magnitude; 0: any.
  int field_bits = 0;
  std::vector<Field> fields;  ///< stored at the output nodes, in the order of the enum; always float32
  std::string scene_text, scene_name, scene_folder;
  std::string physics_hash, mesh_hash, software_version;
};

/// The linear response at rest to a tool at one of the points NodeSets::linear.
struct AtRest {
  std::array<double, 9> stiffness_N_per_m{};  ///< 3 x 3, row-major, symmetric
  std::vector<double> displacement;  ///< 3 x n_output x 3: of the output nodes, per unit along x, y and z, without unit
};

/// The prescribed displacements, n_directions * n_increments x 3 [m], row direction * n_increments + increment.
Points prescribed_displacements(const DatabaseHeader& header);

/// @throws Error (input) if the responses are imported, because there is no scene that could be solved
void require_scene(const DatabaseHeader& header);

/// A ray that is not requested: every column that the header asks for, filled with zeros.
Ray empty_ray(const DatabaseHeader& header, std::int32_t active, std::int32_t direction);

/// The scene of a database. Its mesh file may be absent.
/// @throws Error (input) as parse_scene()
Scene stored_scene(const DatabaseHeader& header);

/// Header of the database that precompute() writes for a scene.
DatabaseHeader database_header(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

/// Size of the responses at rest before compression.
double at_rest_bytes(const DatabaseHeader& header);

/// Size of the record of a ray in a log. A finished database has about five sixths of it for each ray.
double record_bytes(const DatabaseHeader& header);

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

/// Where the rays of a database end. Its shares of the probe volume are those of trained_share() in validation.
struct EndSummary {
  std::int64_t rays = 0;                      ///< requested rays
  std::map<EndReason, std::int64_t> reasons;  ///< rays per reason; reasons that do not occur are absent
  std::map<EndReason, double> volume;         ///< share of the probe volume that is not trained, per reason
  std::int64_t folds = 0;                     ///< rays with a fold, of those that go on, too
  double largest_loss_J = 0;                  ///< largest energy lost at a fold
  std::vector<double> reached;                ///< per active node: share of its probe volume that is trained
  std::vector<std::int32_t> early;            ///< per active node: rays that end early
  double share_of_rays() const;               ///< that end early
  double share_of_volume() const;             ///< that is not trained
};

/// A finished database, read by active node in any order. h5py reads the same arrays. Copies share the open file.
class Database {
 public:
  /// @throws Error (input) if the file is not a database, of another version, damaged, or unfinished; the remedy of an
  /// unfinished database is --resume
  static Database open(const std::filesystem::path& file);
  /// True if all rays have been packed into the file.
  static bool is_complete(const std::filesystem::path& file);

  const DatabaseHeader& header() const;
  /// All rays of one active node (index into sets.active), one per direction, in order.
  std::vector<Ray> rays(std::int32_t active) const;
  /// @param point  index into sets.linear
  AtRest at_rest(std::int32_t point) const;
  /// Status of every increment, [active][direction][increment] flattened.
  std::vector<Status> statuses() const;

  /// End of every ray, [active][direction] flattened.
  std::vector<RayEnd> ends() const;

  friend DatabaseSummary summarize(const Database& database);

 private:
  struct Impl;
  explicit Database(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> _impl;
};

/// Reads all datasets except those of the output nodes.
DatabaseSummary summarize(const Database& database);

/// Part of the probes of a direction up to `range_m` that lie before a depth: they fill a cone around it.
double part_of_volume(double depth_m, double range_m);
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
  std::int64_t rays_logged = 0, rays_total = 0;
  std::vector<LogDamage> damage;
};
/// @throws Error (input) if the file is not a database
DatabaseProgress database_progress(const std::filesystem::path& file);

/// What a database has of the rays of a study.
enum class Coverage {
  same,  ///< all
  part,  ///< of the same physics those of some of its active nodes and directions, or to a smaller depth, no others
  other  ///< others, or some of both
};
Coverage coverage(const DatabaseHeader& on_disk, const DatabaseHeader& wanted);
/// @throws Error (input) with all differences unless the database has the rays of the study, Coverage::same
void require_same_rays(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file);

/// The header of a finished or unfinished database.
/// @throws Error (input) if the file is not a database, of another version, or damaged
DatabaseHeader read_database_header(const std::filesystem::path& file);

/// The processes that pack a database, by default one. All of them call the functions at once.
struct PackingRanks {
  int rank = 0, size = 1;
  /// Runs the work of each. What one throws is thrown on all.
  std::function<void(const std::function<void()>& work)> together = [](const auto& work) { work(); };
  /// The numbers of all, one after another, on all.
  std::function<std::vector<std::int64_t>(const std::vector<std::int64_t>&)> gathered = [](const auto& own) {
    return own;
  };
  /// The bytes of all, one after another, on rank 0.
  std::function<std::vector<unsigned char>(const std::vector<unsigned char>&)> to_first = [](const auto& own) {
    return own;
  };
  /// Called with every ray that this process packs, without the columns of output nodes.
  std::function<void(const Ray&)> packed = [](const Ray&) {};
};

/// Writer of a database. Rank 0 creates the header file; all pack. Every rank appends to its own log,
/// FILE.log/rank-NNNN, so that ranks need no common lock and a killed process loses at most one record.
class DatabaseWriter {
 public:
  /// Creates FILE (the header, marked as unfinished) and an empty FILE.log/. With `resume`, logged rays are kept, and a
  /// finished file that has all rays of the study is left as it is. Must be called in one process only.
  /// @throws Error (input) if FILE exists and `resume` is false, or if an existing FILE is of another study
  /// @param part  of several processes that may create FILE at the same time, each its own number
  static void create(const std::filesystem::path& file, const DatabaseHeader& header, bool resume, int part = 0);

  /// What create() refuses is refused, and nothing is written.
  static void check(const std::filesystem::path& file, const DatabaseHeader& header, bool resume);

  /// The part of check() that needs no header. @return whether FILE exists
  /// @throws Error (input) if FILE or its logs exist and `resume` is false
  static bool refuse_begun(const std::filesystem::path& file, bool resume);
  /// Flags, n_active x n_directions, of the rays that are in the logs. Torn and corrupted records are ignored.
  static std::vector<char> logged(const std::filesystem::path& file, const DatabaseHeader& header,
                                  const PackingRanks& ranks = {});

  /// Copies rays of FROM, a finished or unfinished database of Coverage::part, to a log of FILE. Of rays to a smaller
  /// depth these are the ones that end before. Rays that a failed library call ended are left to be solved again.
  /// @param missing  n_active x n_directions flags of FILE: the others are left out
  /// @param log      number of the log, as that of the writer
  /// @param rank     copies its share of the nodes of FROM
  /// @return number of rays. @throws Error as open(), logged() and append()
  static std::int64_t take(const std::filesystem::path& file, const DatabaseHeader& header,
                           const std::filesystem::path& from, const std::vector<char>& missing, int log = 0,
                           int rank = 0, int n_ranks = 1);

  /// Puts a finished database in the place of another one, at once, and removes its logs. @throws Error (failure)
  static void replace(const std::filesystem::path& by, const std::filesystem::path& file);

  /// Creates the log of this process. It is always a new file, because a resumed run may have another number of ranks.
  /// @param rank  of those that may create logs at the same time, each its own number
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

  /// Packs all logs into a new file, renames it to FILE, and removes FILE.log. The bytes do not depend on the number of
  /// ranks. Must be called after all processes have closed their logs.
  /// @param at_rest  gives, on rank 0, the response at rest of each of sets.linear; what it throws ends the packing,
  ///                 and the logs remain
  /// @throws Error (failure) if rays are missing
  static void pack(const std::filesystem::path& file, const DatabaseHeader& header, const PackingRanks& ranks = {},
                   const std::function<AtRest(std::int32_t point)>& at_rest = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> _impl;
};

}  // namespace phynness
