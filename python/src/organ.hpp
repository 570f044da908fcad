// The runtime's wrapper (phynness.hpp) behind Model and Organ, with the texts from which a copy is made.
#pragma once

#include <phynness/phynness.hpp>

#include <memory>
#include <optional>
#include <string>

#include "arrays.hpp"

namespace phynness::python {

using Level = std::optional<std::int32_t>;

/// The text of a model.txt or body.txt: the bytes, or the content of the file at a path.
struct NamedText {
  std::string name, text;
};

/// @throws phynness.Error that names the text and the line of its first error
Organ organ_of(const NamedText& model, const NamedText& body, std::int32_t max_tools, std::int32_t steps);

/// The places nearest to one or n points x: a SurfacePoint or a list of them.
py::object nearest_places(const Organ& organ, py::handle x);

/// Evaluates all tools; Ctrl-C ends them.
/// @param evaluate  of a row and its tool, returns a status
template <class Evaluate>
void for_each(Tools& tools, Evaluate&& evaluate) {
  Tally tally;
  for (py::ssize_t i = 0; i < tools.size(); ++i) {
    if (!tally.add(i, evaluate(i, tools.get(i)))) break;
    if (i % (1 << 14) == (1 << 14) - 1 && PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
  tally.report([&](py::ssize_t i) { return tools.name(i); }, tools.size());
}

/// A trained model of one tool. Used with the GIL held.
class ModelObject {
 public:
  using OfModule = void;
  ModelObject(NamedText named, py::object mesh, py::object training);

  const phn_info& info() const { return organ.info(); }
  /// The organ at a level; none: the full one.
  Organ& at(const Level& level);

  std::string text;
  py::object mesh, training;  ///< bytes of mesh.txt, or None; figures of train, or None
  Organ organ;
};

}  // namespace phynness::python
