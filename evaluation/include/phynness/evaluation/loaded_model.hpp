// A model in the runtime's hands, with memory of its own: what eval, validate, tune, export and bench call.
#pragma once

#include <filesystem>
#include <optional>
#include <phynness/formats/model.hpp>
#include <phynness/phynness.hpp>
#include <vector>

namespace phynness {

struct ModelResponse {
  std::vector<std::optional<Vec3>> force_N;  ///< per tool; empty where the method defines none
  std::optional<double>
      energy_J;            ///< stored; family rbfn has none: work of the force along the straight path from rest
  Points displacement_m;   ///< n_output x 3; empty if the model has forces only
  Eigen::MatrixXd fields;  ///< n_output x n_fields, in their units; empty if the model has none, or for several tools
  int status = PHN_OK;     ///< phn_* status, warnings only
  phn_coupled coupled{};   ///< what coupled tools left over
};

/// Not for several threads at once.
class LoadedModel {
 public:
  /// Only the runtime reads the model's text, until model() is called.
  /// @throws Error if the directory, its files or their match is unsound
  explicit LoadedModel(const std::filesystem::path& dir, std::int32_t max_tools = 16);
  /// The same of a model that need not be in files; `name` is for messages.
  LoadedModel(Model model, Mesh mesh, const std::string& name, std::int32_t max_tools = 16);

  /// What the model was trained to: its coefficients, read from its text at the first call.
  const Model& model() const;
  const Mesh& mesh() const { return _mesh; }
  /// Bytes of model.txt, mesh.txt, and of the model in the runtime's memory.
  std::size_t text_bytes() const { return _text.size(); }
  std::size_t mesh_text_bytes() const { return _mesh_text_bytes; }
  std::size_t memory_bytes() const { return _runtime.bytes(); }
  const rt::Model& runtime() const { return _runtime; }
  rt::Data& data() const { return _data; }

  /// Sets the level of all that is asked from now on; the full one before.
  /// @throws Error (input) if the model has no such level
  void set_level(std::int32_t level);

  /// Force of one tool alone.
  /// @throws Error naming the nearest active nodes if `node` is not active
  Vec3 force(std::int32_t node, const Vec3& displacement_m) const;
  /// Distance to the nearest trained displacement over the fill distance of these.
  double trained_distance(std::int32_t node, const Vec3& displacement_m) const;
  /// Deep into the trained range of the exploratory direction nearest to `displacement_m` [m].
  double trained_depth(std::int32_t node, const Vec3& displacement_m) const;
  /// Tools anywhere on the surface, coupled.
  /// @throws Error if a tool's nodes can neither be touched nor are fixed, or the model has forces only
  ModelResponse couple(const std::vector<phn_tool>& tools) const;
  /// Several tools with the paper's weights (15)-(16).
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
  std::int32_t _max_tools = 0;
};

}  // namespace phynness
