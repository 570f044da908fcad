// A reduced body loaded into the runtime (phynness_body.h), with the memory that it needs.
#pragma once

#include <phynness/phynness_body.h>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/selector.hpp>
#include <string>
#include <vector>

namespace phynness {

struct BodyResponse {
  int status = PHN_OK;                         ///< PHN_OK or warnings
  std::vector<Vec3> force_N;                   ///< per tool
  std::vector<std::optional<double>> bound_N;  ///< of their errors, where there is one
  Points displacement_m;                       ///< of the nodes of the body's surface
  phn_body_report pressed{};                   ///< of the last call of the runtime
};

/// Must not be used by several threads at the same time.
class LoadedBody {
 public:
  /// Loads a body.txt.
  /// @throws Error (input) if the file is missing or the runtime refuses it
  explicit LoadedBody(const std::filesystem::path& file);
  /// @param name  for messages
  LoadedBody(std::string text, std::string name);

  const phn_body_contents& info() const { return _info; }
  const std::string& name() const { return _name; }
  /// The content of body.txt.
  const std::string& text() const { return _text; }
  bool has_bounds() const;
  /// Bytes of the body, and of a state of up to `max_tools` tools, in the runtime's memory.
  std::size_t memory_bytes() const { return _body_memory.size(); }
  std::size_t state_bytes(std::int32_t max_tools) const;
  /// @param of  "the model NAME". @throws Error (input) with both names if that has another mesh
  void require_mesh(const std::string& mesh_hash, const std::string& of) const;
  /// Back to rest.
  void reset();
  /// At most `steps` steps from the present deformation.
  /// @throws Error (input) if the runtime refuses the tools
  BodyResponse press(const std::vector<phn_tool>& tools, std::int32_t steps);
  /// From rest to `tools` in equal increments of the displacement. @param steps  of each, at most
  BodyResponse press_from_rest(const std::vector<phn_tool>& tools, int increments, std::int32_t steps);

 private:
  std::string _name, _text;
  std::vector<std::byte> _body_memory, _state_memory;
  const phn_body* _body = nullptr;
  phn_body_state* _state = nullptr;
  phn_body_contents _info{};
};

}  // namespace phynness
