// A model loaded into the runtime, with the memory that it needs, for the commands eval, validate, tune, export and
// bench.
#pragma once

#include <filesystem>
#include <optional>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/phynness.hpp>
#include <vector>

namespace phynness {

struct ModelResponse {
  std::vector<std::optional<Vec3>> force_N;  ///< per tool; empty if the method defines no force
  std::optional<double>
      energy_J;            ///< stored energy; in family rbfn the work of the force along the straight path from rest
  Points displacement_m;   ///< n_output x 3; empty if the model has forces only
  Eigen::MatrixXd fields;  ///< n_output x n_fields, in their units; empty for a model without fields or several tools
  int status = PHN_OK;     ///< status of the runtime: PHN_OK or warnings
  phn_coupled coupled{};   ///< residual and energy of coupled tools
  /// Bounds of the errors of coupled forces, where there is one; without elements if the model has none.
  std::vector<std::optional<double>> bound_N;
};

/// What to do for several round tools.
inline constexpr const char* several_round_tools =
    "give --body the reduced body that phynness run makes of a scene with tools = 2 to 8 in [probe], of the elements "
    "p1-p1 and es-p1-p1";

phn_tool tool_at(const SurfacePoint& place, const Vec3& displacement_m);

/// Must not be used by several threads at the same time.
class LoadedModel {
 public:
  /// Loads a model directory. Until model() is called, only the runtime parses the text.
  /// @throws Error (input) if a file is missing or invalid, or if mesh.txt does not belong to model.txt
  explicit LoadedModel(const std::filesystem::path& dir);
  /// Loads a model that is not in files. @param name  for messages
  LoadedModel(Model model, Mesh mesh, const std::string& name);

  /// The coefficients of the model, parsed from its text at the first call.
  const Model& model() const;
  const Mesh& mesh() const { return _mesh; }
  /// The content of model.txt.
  const std::string& text() const { return _text; }
  /// The checksum in the last line of model.txt: results of validations hold it.
  std::string hash() const;
  /// Bytes of model.txt, of mesh.txt, and of the model in the runtime's memory.
  std::size_t text_bytes() const { return _text.size(); }
  std::size_t mesh_text_bytes() const { return _mesh_text_bytes; }
  std::size_t memory_bytes() const { return _runtime.bytes(); }
  const rt::Model& runtime() const { return _runtime; }
  rt::Data& data() const { return _data; }

  /// @param what  "the body FILE". @throws Error (input) with both names if the model has another mesh or physics
  void require_same(const std::string& what, const std::string& mesh_hash, const std::string& physics_hash,
                    const char* remedy = "make it with phynness reduce of the database of this model") const;

  /// Sets the level of later calls; initially the full level.
  /// @throws Error (input) if the model has no such level
  void set_level(std::int32_t level);
  std::int32_t level() const { return _level.value_or(_runtime.n_levels() - 1); }

  /// Force [N] of a single tool.
  /// @throws Error (input) if `node` is not active; the message names the nearest active nodes
  Vec3 force(std::int32_t node, const Vec3& displacement_m) const;
  /// Depth [m] of the trained range in the direction of `displacement_m` (formats/model.md, Range).
  double trained_depth(std::int32_t node, const Vec3& displacement_m) const;
  /// Whether `phynness calibrate` has added bounds to the model, and the full level is set, of which they are.
  bool has_bounds() const;
  /// Bound [N] of the error of the force; none outside of the trained range or if the model has no bounds.
  std::optional<double> error_bound(std::int32_t node, const Vec3& displacement_m) const;
  /// Whether tools are round: such a model answers one tool.
  bool has_round_tools() const { return !model().nodes.empty() && model().nodes.front().moves_mean; }
  /// Response to coupled tools anywhere on the surface.
  /// @throws Error (input) if a node of a tool is neither active nor fixed, if the model has forces only, or if there
  /// are several round tools
  ModelResponse couple(const std::vector<phn_tool>& tools) const;
  /// Response to several tools at nodes with the paper's weights (15)-(16). @throws Error (input) for round tools
  ModelResponse respond(const std::vector<std::int32_t>& nodes, const std::vector<Vec3>& displacement_m) const;

 private:
  void load();
  void check(int status, std::int32_t node) const;

  std::string _name, _text;
  std::size_t _mesh_text_bytes = 0;
  mutable std::optional<Model> _model;
  Mesh _mesh;
  rt::Model _runtime;
  mutable rt::Data _data;
  std::optional<std::int32_t> _level;
};

}  // namespace phynness
