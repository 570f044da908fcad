// The record of a ray: its values in memory, and the table of its columns. Datasets, logs, checks and what
// `phynness info` lists follow from the table; formats/database.md describes every column.
#pragma once

#include <cstdint>
#include <phynness/formats/fields.hpp>
#include <variant>
#include <vector>

namespace phynness {

/// Name of a stored code in files, and what it means, in a few words for people.
template <class Code>
struct CodeRow {
  Code code;
  const char* name;
  const char* meaning;
};

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
inline constexpr CodeRow<Status> every_status[] = {
    {Status::converged, "converged", "solved"},
    {Status::not_requested, "not_requested", "direction outside the hemisphere"},
    {Status::not_solved, "not_solved", "no result yet"},
    {Status::after_end, "after_end", "not solved: the ray ends before, at a fold, a crushed cell or the force limit"},
    {Status::inverted, "inverted", "a cell was inverted, even with the smallest steps"},
    {Status::diverged, "diverged", "Newton's method found no equilibrium, even with the smallest steps"},
    {Status::factorization, "factorization", "the tangent was singular or could not be factorized"},
    {Status::not_finite, "not_finite", "force, energy or a field was infinite or undefined: mostly a cell was crushed"},
    {Status::after_failure, "after_failure", "not tried: an earlier increment of the ray failed"},
    {Status::library_error, "library_error", "a library call failed or memory ran out; see the solver's log"}};
const char* name(Status);
const char* meaning(Status);

/// Why a ray ends where it ends. Values are stored; never renumber.
enum class EndReason : std::int8_t {
  full_depth = 0,     ///< all increments are solved
  fold = 1,           ///< the body loses energy at once: it snaps, or the mesh folds
  crushed = 2,        ///< the smallest J falls below [probe] min_jacobian
  force_limit = 3,    ///< the force exceeds [probe] max_force_N
  not_requested = 4,  ///< direction outside the hemisphere
  solver = -1,        ///< an increment could not be solved; its status tells why
};
inline constexpr CodeRow<EndReason> every_end[] = {
    {EndReason::full_depth, "full_depth", "solved to the full depth"},
    {EndReason::fold, "fold", "energy is lost at once: the body snaps, or its mesh folds"},
    {EndReason::crushed, "crushed", "a cell is crushed to less than [probe] min_jacobian of its volume"},
    {EndReason::force_limit, "force_limit", "the force exceeds [probe] max_force_N"},
    {EndReason::not_requested, "not_requested", "direction outside the hemisphere"},
    {EndReason::solver, "solver", "no equilibrium was found beyond; phynness info --failed lists the reasons"}};
const char* name(EndReason);
const char* meaning(EndReason);

/// The end of a ray.
struct RayEnd {
  EndReason reason = EndReason::full_depth;
  double depth_m = 0;        ///< up to which the ray is followed; of a fold, of a crushed cell: where it happens
  double fold_depth_m = 0;   ///< of the first fold, also if the ray goes on; 0 without a fold
  double energy_lost_J = 0;  ///< there: work of the force minus change of the stored energy
  /// True if something known ended the ray before its full depth.
  bool is_early() const { return reason != EndReason::full_depth && reason != EndReason::not_requested; }
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

/// How many values a column has: one for each ray, each increment, or each output node in each increment.
enum class ColumnOf { ray, increment, output_node };
/// Components of such a value.
enum class Tensor { scalar = 1, vector = 3, matrix = 9 };
/// One column of the record of a ray.
struct RayColumn {
  struct FieldIndex {
    std::size_t index;  ///< in Ray::fields
  };
  /// Where a Ray has the values. The type in files is that of the member, or float32.
  std::variant<std::vector<Status> Ray::*, std::vector<std::int32_t> Ray::*, std::vector<double> Ray::*,
               EndReason RayEnd::*, double RayEnd::*, FieldIndex>
      member;
  const char* name;  ///< of the dataset in /responses
  ColumnOf of;
  Tensor tensor;
  const char* unit;
  const char* description;
  bool with_tangents = false;  ///< only in databases with tangents
  bool float32 = false;        ///< in files, unless the scene asks for float64
};

/// All columns but the fields, in the order of the file. Logs have the same order, after those with one value per ray.
inline constexpr RayColumn ray_columns[] = {
    {&Ray::status, "status", ColumnOf::increment, Tensor::scalar, "1",
     "outcome of each increment; see flag_values and flag_meanings"},
    {&Ray::force, "force", ColumnOf::increment, Tensor::vector, "N",
     "force that must be applied at the probe to hold the displacement"},
    {&Ray::energy, "energy", ColumnOf::increment, Tensor::scalar, "J", "stored strain energy"},
    {&Ray::tangent, "tangent", ColumnOf::increment, Tensor::matrix, "N/m",
     "condensed tangent dF/dd, row F and column d", true},
    {&Ray::negative_pivots, "negative_pivots", ColumnOf::increment, Tensor::scalar, "1",
     "negative pivots of the tangent beyond those of the pressure; 0 is stable"},
    {&Ray::iterations, "iterations", ColumnOf::increment, Tensor::scalar, "1",
     "Newton iterations, those of cut-back attempts included"},
    {&Ray::cutbacks, "cutbacks", ColumnOf::increment, Tensor::scalar, "1", "times the step was halved"},
    {&Ray::min_jacobian, "min_jacobian", ColumnOf::increment, Tensor::scalar, "1",
     "smallest J over all quadrature points"},
    {&Ray::seconds, "seconds", ColumnOf::increment, Tensor::scalar, "s", "CPU time"},
    {&RayEnd::reason, "end_reason", ColumnOf::ray, Tensor::scalar, "1",
     "why each ray ends where it ends; see flag_values and flag_meanings"},
    {&RayEnd::depth_m, "end_depth", ColumnOf::ray, Tensor::scalar, "m", "depth up to which each ray is followed"},
    {&RayEnd::fold_depth_m, "fold_depth", ColumnOf::ray, Tensor::scalar, "m",
     "smallest depth at which a state beyond the first fold was found; 0 without a fold"},
    {&RayEnd::energy_lost_J, "energy_lost", ColumnOf::ray, Tensor::scalar, "J",
     "work of the force minus change of the stored energy at the first fold; 0 without a fold"},
    {&Ray::displacement, "displacement", ColumnOf::output_node, Tensor::vector, "m", "displacement of the output nodes",
     false, true},
};

}  // namespace phynness
