// A model or a body in the runtime (phynness.hpp), with errors that contain the file name.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/formats/selector.hpp>
#include <phynness/phynness.hpp>
#include <span>
#include <string>
#include <vector>

namespace phynness {

struct OrganResponse {
  std::vector<std::optional<Vec3>> force_N;  ///< per tool; empty if the method defines no force
  std::optional<double> energy_J;  ///< stored energy; in family rbfn the work along the straight path from rest
  Points displacement_m;   ///< at the model's output nodes or the body's nodes; empty for a model of forces only
  Eigen::MatrixXd fields;  ///< n_output x n_fields, in their units; empty without fields or for several tools
  int status = PHN_OK;     ///< PHN_OK or warnings
  OrganReport report;      ///< report of the solve
  /// Bound of each force error, if it is known; without elements if there are no bounds.
  std::vector<std::optional<double>> bound_N;
};

/// The remedy for several round tools.
inline constexpr const char* several_round_tools =
    "give --body the reduced body that phynness run makes of a scene with tools = 2 to 8 in [probe], of the elements "
    "p1-p1 and es-p1-p1";

phn_tool tool_at(const SurfacePoint& place, const Vec3& displacement_m);
inline phn_tool tool_at(std::int32_t node, const Vec3& displacement_m) {
  return phn_tool_at(node, displacement_m.data());
}

/// An Organ of a model or of a body. Must not be used by several threads at the same time.
class NamedOrgan {
 public:
  /// Loads a model directory. Until model() is called, only the runtime parses the text.
  /// @throws Error (input) if a file is missing or invalid, or if mesh.txt does not belong to model.txt
  explicit NamedOrgan(const std::filesystem::path& dir);
  /// Loads a model from memory. @param name  name in messages
  NamedOrgan(Model model, Mesh mesh, const std::string& name);
  /// Loads a body.txt, or its text. @param steps  upper limit of Newton steps in each increment
  static NamedOrgan body(const std::filesystem::path& file, std::int32_t steps = 600);
  static NamedOrgan body(std::string text, std::string name, std::int32_t steps = 600);
  /// Loads a body.txt with the mesh of this model.
  NamedOrgan body_on_same_mesh(const std::filesystem::path& file, std::int32_t steps = 600) const;

  Organ& organ() const { return _organ; }
  const phn_info& info() const { return _organ.info(); }
  const phn_body_contents& body_info() const { return _organ.body_info(); }
  /// The path of model.txt, or of body.txt.
  const std::string& name() const { return _name; }
  /// Its content.
  const std::string& text() const { return _text; }
  /// The checksum in its last line, which results of validations contain.
  std::string hash() const;
  /// The coefficients of a model, parsed from its text at the first call.
  const Model& model() const;
  const Mesh& mesh() const { return _mesh; }
  std::size_t mesh_text_bytes() const { return _mesh_text_bytes; }
  std::span<const std::int32_t> active_nodes() const { return {info().active_nodes, std::size_t(info().n_active)}; }
  std::span<const std::int32_t> output_nodes() const { return {info().output_nodes, std::size_t(info().n_output)}; }

  /// @param what  "the body FILE". @throws Error (input) with both names if the model has another mesh or physics
  void require_same(const std::string& what, const std::string& mesh_hash, const std::string& physics_hash,
                    const char* remedy = "make it with phynness reduce of the database of this model") const;
  /// Whether the model has bounds, and the full level is set, for which they hold.
  bool has_bounds() const;
  /// Whether the model has round tools; it then answers one tool.
  bool has_round_tools() const { return !model().nodes.empty() && model().nodes.front().moves_mean; }
  /// Sets the level of later calls; initially the full level. @throws Error (input) if the model has no such level
  void set_level(std::int32_t level);
  bool is_of_full_level() const { return level() + 1 == info().n_levels; }
  std::int32_t level() const { return _level.value_or(info().n_levels - 1); }

  /// Force [N] of a single tool.
  /// @throws Error (input) if `node` is not active; the message names the nearest active nodes
  Vec3 force(std::int32_t node, const Vec3& displacement_m) const;
  /// Depth [m] of the trained range in the direction of `displacement_m` (formats/model.md, Range).
  double trained_depth(std::int32_t node, const Vec3& displacement_m) const;
  /// Bound [N] of the force error; empty outside the trained range or if the model has no bounds.
  std::optional<double> error_bound(std::int32_t node, const Vec3& displacement_m) const;
  /// Response to tools anywhere on the surface. A body starts from its present state.
  /// @throws Error (input) if a node of a tool is neither active nor fixed, if the model has forces only, or if there
  /// are several round tools
  OrganResponse hold(const std::vector<phn_tool>& tools) const;
  /// Response to `tools` after equal increments of the displacement from rest.
  OrganResponse hold_from_rest(const std::vector<phn_tool>& tools, int increments) const;
  /// Response of a model to tools at nodes. For several tools this is the method of the paper, without forces: their
  /// fields are averaged with the weights (15)-(16). @pre there is a tool. @throws Error (input) for several round
  /// tools
  OrganResponse blend(const std::vector<std::int32_t>& nodes, const std::vector<Vec3>& displacement_m) const;

 private:
  NamedOrgan(std::string name, std::string text) : _name(std::move(name)), _text(std::move(text)) {}
  void load(std::int32_t steps);
  void check(int status, std::int32_t node) const;
  /// Throws the error of a status of several tools.
  void check(int status, const std::vector<phn_tool>& tools) const;

  std::string _name, _text;
  std::size_t _mesh_text_bytes = 0;
  mutable std::optional<Model> _model;
  Mesh _mesh;
  bool _is_body = false;
  mutable Organ _organ;
  std::optional<std::int32_t> _level;
};

}  // namespace phynness
