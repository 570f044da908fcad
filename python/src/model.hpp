// The objects behind Model and what belongs to it: the runtime's wrapper (phynness.hpp) on arrays.
#pragma once

#include <pybind11/stl.h>
#include <phynness/phynness.hpp>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "arrays.hpp"

namespace phynness::python {

using Level = std::optional<std::int32_t>;

/// A place on the surface: what tools of the runtime have besides their displacement.
struct SurfacePoint {
  phn_tool tool{{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}};

  SurfacePoint() = default;
  SurfacePoint(const std::vector<std::int32_t>& nodes, const std::vector<double>& weights) {
    if (nodes.empty() || nodes.size() > 3 || weights.size() != nodes.size())
      throw py::value_error("a point has one to three nodes and a weight for each of them");
    std::copy(nodes.begin(), nodes.end(), tool.nodes);
    std::copy(weights.begin(), weights.end(), tool.weights);
  }
  std::size_t n() const { return static_cast<std::size_t>(std::find(tool.nodes, tool.nodes + 3, -1) - tool.nodes); }
  py::tuple nodes() const { return py::tuple(py::cast(std::vector(tool.nodes, tool.nodes + n()))); }
  py::tuple weights() const { return py::tuple(py::cast(std::vector(tool.weights, tool.weights + n()))); }
  std::string text() const {
    return "SurfacePoint(" + py::repr(nodes()).cast<std::string>() + ", " + py::repr(weights()).cast<std::string>() +
           ")";
  }
};

/// Where a tool is: at a node, or at a point of the surface.
using Place = std::variant<std::int64_t, SurfacePoint>;
phn_tool tool_at(const Place& at);

class ModelObject {
 public:
  ModelObject(const std::string& name, std::string text, py::object mesh, py::object training);
  /// @param of  a path, or bytes of a text
  static std::unique_ptr<ModelObject> open(const py::object& of);

  const phn_info& info() const { return _model.info(); }
  const rt::Model& runtime() const { return _model; }
  py::bytes text() const { return _text; }
  py::object training() const { return _training; }
  void save(const py::object& to) const;

  /// Force, energy and stiffness, of which only those that are asked for are computed.
  struct Response {
    std::optional<py::array_t<double>> force, energy, stiffness;
  };
  Response response(const Place& at, py::handle displacements, const Level& level, bool force, bool energy,
                    bool stiffness);
  py::array_t<double> deform(const Place& at, py::handle displacements, const Level& level);
  py::array_t<double> field(std::int64_t node, py::handle displacements, const std::string& name, const Level& level);
  py::array_t<double> bound(const Place& at, py::handle displacements) const;
  py::array_t<double> trained_depth(const Place& at, py::handle displacements) const;
  py::tuple nearest(py::handle x) const;

 private:
  phn_data* data(const Level& level);

  std::string _text;
  py::object _mesh, _training;
  rt::Model _model;
  rt::Data _data;  ///< made by the first call; used with the GIL held
};

/// Several tools at once, with the working memory that remembers them.
class Coupled {
 public:
  Coupled(py::object owner, const std::vector<Place>& at, py::handle displacements, const Level& level);
  /// With the GIL held, because two threads may have the same object.
  py::array_t<double> deform();

  py::array_t<double> forces;
  phn_coupled result{};

 private:
  py::object _owner;
  ModelObject& _model;
  rt::Data _data;
};

}  // namespace phynness::python
