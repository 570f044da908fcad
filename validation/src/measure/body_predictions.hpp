// Predictions of a reduced body at the nodes that it has in common with a model.
#pragma once

#include <algorithm>
#include <phynness/validation/named_organ.hpp>

namespace phynness {

class BodyPredictor {
 public:
  /// @param increments  number of increments from rest to a displacement
  BodyPredictor(const NamedOrgan& body, const NamedOrgan& model, int increments)
      : _body(body), _increments(increments) {
    const auto& output = model.model().output;
    const auto& info = body.body_info();
    for (std::size_t o = 0; o < output.size(); ++o) {
      const auto* at = std::lower_bound(info.nodes, info.nodes + info.n_nodes, output[o]);
      if (at == info.nodes + info.n_nodes || *at != output[o]) continue;
      _common_output.push_back(static_cast<Eigen::Index>(o));
      _common_nodes.push_back(at - info.nodes);
    }
  }

  /// The response with the displacements of the common nodes.
  OrganResponse at(const std::vector<phn_tool>& tools) const {
    OrganResponse response = _body.hold_from_rest(tools, _increments);
    response.displacement_m = Points(response.displacement_m(_common_nodes, Eigen::all));
    return response;
  }
  /// Selects the rows of the common nodes from those of the model's output nodes.
  Points common_rows(const Points& of_output) const { return of_output(_common_output, Eigen::all); }
  std::vector<char> common_rows(const std::vector<char>& of_output) const {
    std::vector<char> result;
    for (const auto o : _common_output) result.push_back(of_output[static_cast<std::size_t>(o)]);
    return result;
  }

 private:
  const NamedOrgan& _body;
  int _increments;
  std::vector<Eigen::Index> _common_output, _common_nodes;
};

}  // namespace phynness
