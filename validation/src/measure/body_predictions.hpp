// What a reduced body answers where a model is validated, at the nodes that both know.
#pragma once

#include <algorithm>
#include <phynness/validation/named_organ.hpp>

namespace phynness {

class BodyPredictions {
 public:
  /// @param increments  from rest to a displacement
  BodyPredictions(const NamedOrgan& body, const NamedOrgan& model, int increments)
      : _body(body), _increments(increments) {
    const auto& output = model.model().output;
    const auto& info = body.body_info();
    for (std::size_t o = 0; o < output.size(); ++o) {
      const auto* at = std::lower_bound(info.nodes, info.nodes + info.n_nodes, output[o]);
      if (at == info.nodes + info.n_nodes || *at != output[o]) continue;
      _shared_output.push_back(static_cast<Eigen::Index>(o));
      _shared_nodes.push_back(at - info.nodes);
    }
  }

  /// Displacements are those of the shared nodes.
  OrganResponse at(const std::vector<phn_tool>& tools) const {
    OrganResponse said = _body.hold_from_rest(tools, _increments);
    said.displacement_m = Points(said.displacement_m(_shared_nodes, Eigen::all));
    return said;
  }
  /// Rows of the shared nodes, of the rows of the model's output nodes.
  Points shared(const Points& of_output) const { return of_output(_shared_output, Eigen::all); }
  std::vector<char> shared(const std::vector<char>& of_output) const {
    std::vector<char> result;
    for (const auto o : _shared_output) result.push_back(of_output[static_cast<std::size_t>(o)]);
    return result;
  }

 private:
  const NamedOrgan& _body;
  int _increments;
  std::vector<Eigen::Index> _shared_output, _shared_nodes;
};

}  // namespace phynness
