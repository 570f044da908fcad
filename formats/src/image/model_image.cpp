// Conversion of a model to an image, whose layout is in runtime/include/phynness/image_layout.hpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <phynness/formats/error.hpp>
#include <phynness/formats/image.hpp>
#include <phynness/image_layout.hpp>
#include <phynness/schema/model_grammar.hpp>

#include "image_functions.hpp"
#include "image_surface.hpp"

namespace phynness {
namespace {

constexpr std::size_t largest_index = 65535;

template <class Real>
class ImageWriter {
 public:
  ImageWriter(const Model& model, const ImageOptions& options) : _model(model), _options(options) {}

  ModelImage write() {
    check_sizes();
    const bool deforms = !_options.force_only;
    _bytes.resize(sizeof(_header));
    _header.magic = image::magic;
    _header.version = image::version;
    _header.real_bytes = sizeof(Real);
    _header.family = _model.family;
    const double R = _model.max_displacement_m;
    constexpr Real largest = image::Bounds<Real>::max_displacement;
    const auto rounded = static_cast<Real>(R);
    if (!(rounded >= 1 / largest && rounded <= largest)) throw too_large("the largest displacement [m]", R);
    _header.max_displacement = rounded;
    if (_has_modes) _header.amplitude_shape = real(_model.shared.shape);
    std::vector<std::int32_t> active;
    for (const auto& node : _model.nodes) active.push_back(node.node);
    _header.active_nodes = put(active);
    _header.active_points = put(numbers(_model.nodes, &ActiveNodeModel::point));
    if (deforms) {
      _header.output_nodes = put(_model.output);
      _header.output_points = put(reals(_model.output_points));
    }
    _header.directions = put(numbers(_model.directions));
    const double unit = _has_modes ? R : 1;
    _displacements = reals(_model.displacements, [&](double value) {
      if (_has_modes && !(std::fabs(value / unit) <= image::largest_displacement))
        throw too_large("a displacement over the largest one", value / unit);
      return value / unit;
    });
    _header.displacements = put(_displacements);
    if (deforms && _has_modes) put_shared();

    std::vector<image::ActiveNode<Real>> nodes;
    for (const auto& node : _model.nodes) nodes.push_back(active_node(node));
    _header.active = put(nodes);
    _header.n_scratch = static_cast<std::uint32_t>(_n_scratch);
    put_provenance();
    if (_has_modes) set_rest(nodes);
    seal();
    return {_bytes, _options, _model.nodes.size(), deforms ? _model.output.size() : 0, _n_triangles, _n_scratch};
  }

 private:
  Error too_large(const std::string& what, double value) const {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return input_error("the model does not fit an image of " + std::string(_options.floats ? "floats" : "doubles") +
                           ": " + what + " is out of range",
                       text, _options.floats ? "export it without --float" : "train it in metres and newtons");
  }

  /// Strings that this program does not write, which may be longer, are cut.
  void put_provenance() {
    image::Provenance origin{};
    const auto text = [](const std::string& from, char(&to)[20]) { from.copy(to, sizeof to - 1); };
    const auto number = [](double from, std::uint32_t(&to)[2]) { std::memcpy(to, &from, sizeof to); };
    const auto& solved = _model.solved;
    const auto& finer = _model.finer;
    text(_model.mesh_hash, origin.mesh_hash);
    text(_model.physics_hash, origin.physics_hash);
    text(solved.is_recorded ? solved.element : finer.element, origin.element);
    text(finer.reference, origin.reference);
    number(solved.shear_modulus_Pa, origin.shear_modulus_Pa);
    number(finer.mean, origin.finer_mean);
    number(finer.p95, origin.finer_p95);
    number(finer.tool_radius_m, origin.finer_tool_radius_m);
    origin.finer_probes = finer.probes;
    origin.finer_nodes = finer.nodes;
    if (!_model.bounds.empty()) origin.bound_reference = _model.bounds[0].reference;
    origin.surface = put_surface();
    if (!_model.relaxation.empty()) {
      std::vector<double> doubles{_model.relaxation.length_m};
      for (const auto& term : _model.relaxation.terms.rowwise()) doubles.insert(doubles.end(), {term[0], term[1]});
      std::vector<std::uint32_t> halves(2 * doubles.size());
      std::memcpy(halves.data(), doubles.data(), 4 * halves.size());
      origin.relaxation = put(halves);
    }
    _header.provenance = put_bytes(&origin, sizeof origin);
  }

  /// @return the offset of the surface on which tools can be, where they are round; 0: none
  std::uint32_t put_surface() {
    const ImageSurface from = image_surface(_model);
    _n_triangles = from.triangle.size() / 6;
    if (_n_triangles == 0) return 0;
    image::Surface surface{};
    surface.triangle = put(from.triangle);
    surface.vertex = put(from.vertex);
    surface.point = put(reals(from.point));
    surface.begin = put(from.begin);
    surface.neighbour = put(from.neighbour);
    surface.slope = put(reals(from.slope));
    std::vector<Real> stiffnesses(6 * _model.linear_points.size());
    for (std::size_t i = 0; i < _model.linear_points.size(); ++i)
      stiffness(_model.linear_points[i].stiffness, &stiffnesses[6 * i]);
    surface.rest_point = put(numbers(_model.linear_points, &LinearPoint::point));
    surface.rest_stiffness = put(stiffnesses);
    if (!_model.bounds.empty()) {
      std::vector<std::int16_t> bound;
      std::vector<Real> scale;
      for (const auto& node : _model.nodes) {
        const ScaledTable& table = node.bounds[0];
        bound.insert(bound.end(), table.entries.data(), table.entries.data() + table.entries.size());
        scale.push_back(real(table.scale[0]));
      }
      surface.bound = put(bound);
      surface.bound_scale = put(scale);
      surface.between = put(reals(_model.bounds[0].between.transpose()));
    }
    return put_bytes(&surface, sizeof surface);
  }

  void check_sizes() const {
    const auto n_displacements = static_cast<std::size_t>(_model.displacements.rows());
    if (n_displacements > largest_index || _model.output.size() > largest_index)
      throw input_error(
          "the model is too large for an image",
          std::to_string(n_displacements) + " displacements, " + std::to_string(_model.output.size()) + " output nodes",
          "precompute with fewer increments or output nodes; an image holds up to 65535 of each");
  }

  Real real(double value) const {
    if (!(std::fabs(value) <= image::Bounds<Real>::value)) throw too_large("a coefficient", value);
    return static_cast<Real>(value);
  }
  template <class Matrix, class Change>
  std::vector<Real> reals(const Matrix& values, Change change) const {
    std::vector<Real> out;
    for (Eigen::Index r = 0; r < values.rows(); ++r)
      for (Eigen::Index c = 0; c < values.cols(); ++c) out.push_back(real(change(values(r, c))));
    return out;
  }
  template <class Matrix>
  std::vector<Real> reals(const Matrix& values) const {
    return reals(values, std::identity{});
  }
  /// The numbers of all items, in turn. @param of  gives those of an item
  template <class Items, class Of = std::identity>
  std::vector<Real> numbers(const Items& items, Of of = {}) const {
    std::vector<Real> out;
    for (const auto& item : items)
      for (const double value : std::invoke(of, item)) out.push_back(real(value));
    return out;
  }

  /// Appends values and returns their position. Equal tables of depths, weights and points are stored once.
  template <class T>
  image::Table put(const std::vector<T>& values) {
    if (values.empty()) return {0, 0};
    return {put_bytes(values.data(), values.size() * sizeof(T)), static_cast<std::uint32_t>(values.size())};
  }
  std::uint32_t put_bytes(const void* data, std::size_t size) {
    const std::size_t at = (_bytes.size() + sizeof(Real) - 1) / sizeof(Real) * sizeof(Real);
    if (size > image::largest_table - at)
      throw input_error("the image is larger than 2 GB", "", "use --force-only, --float or family modal");
    _bytes.resize(at + size);
    std::memcpy(_bytes.data() + at, data, size);
    return static_cast<std::uint32_t>(at);
  }
  image::Table put_indices(const std::vector<std::int32_t>& values) {
    if (values.size() > image::largest_count)
      throw too_large("a number of neurons", static_cast<double>(values.size()));
    return put(std::vector<std::uint16_t>(values.begin(), values.end()));
  }
  image::ScaledTable put_scaled(const ScaledTable& table) {
    if (table.cols() == 0) return {};
    const auto* entry = table.entries.data();
    return {put(reals(table.scale)), put(std::vector<std::int16_t>(entry, entry + table.entries.size()))};
  }

  void put_shared() {
    const auto& shared = _model.shared;
    std::vector<Real> at_rest;
    // The same operations as in modal_field at x = 0.
    const Real s2 = _header.amplitude_shape * _header.amplitude_shape, q = std::sqrt(s2);
    for (const auto row : shared.centers) {
      const Real* c = &_displacements[3 * static_cast<std::size_t>(row)];
      at_rest.push_back(std::sqrt((c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) + s2) - q);
    }
    _header.amplitude_center = put_indices(shared.centers);
    _header.amplitude_at_rest = put(at_rest);
    _header.modes = put_scaled(shared.modes);
  }

  image::ActiveNode<Real> active_node(const ActiveNodeModel& node) {
    image::ActiveNode<Real> out{};
    if (!_options.force_only) {
      std::vector<std::uint16_t> positions;
      std::vector<Real> weights;
      for (std::size_t i = 0; i < node.prescribed.size() && !node.moves_mean; ++i) {
        const auto found = std::lower_bound(_model.output.begin(), _model.output.end(), node.prescribed[i]);
        if (found == _model.output.end() || *found != node.prescribed[i]) continue;
        positions.push_back(static_cast<std::uint16_t>(found - _model.output.begin()));
        weights.push_back(real(node.prescribed_weight[i]));
      }
      out.prescribed = put(positions);
      out.prescribed_weight = put(weights);
    }
    // Successive nodes often have the same trained depths.
    if (node.trained_depth_m != _depth) {
      _depth = node.trained_depth_m;
      _depth_table = put(numbers(std::array{_depth}));
    }
    out.trained_depth = _depth_table;
    out.incomplete = node.n_incomplete > 0 ? 1 : 0;
    schema::with_grammar(_model.family, [&](auto family) { out.response = response(family, node); });
    return out;
  }

  template <int n_inputs>
  image::Network<Real, n_inputs> network(const RbfNetwork& from) {
    image::Network<Real, n_inputs> net{};
    net.displacement = put_indices(from.center_displacement);
    net.output = put_indices(from.center_output);
    // Gaussians use powers of two, and weights have the unit of the output.
    for (int k = 0; k < n_inputs; ++k)
      net.factor[k] = real(std::sqrt(1 / std::log(2.0)) / (from.spread * from.input_half_range[k]));
    const Eigen::MatrixXd weights = from.weights * from.output_half_range.asDiagonal();
    net.weight = put(reals(weights));
    for (int k = 0; k < 3; ++k)
      net.constant[k] = real(from.output_center[k] + from.output_half_range[k] * from.bias[k]);
    return net;
  }
  std::uint32_t response(schema::RbfnGrammar, const ActiveNodeModel& node) {
    image::RbfnResponse<Real> out{};
    out.force = network<3>(node.force);
    if (!_options.force_only) {
      out.deformation = network<6>(node.deformation);
      _n_scratch = std::max(_n_scratch, node.deformation.center_output.size());
    }
    return put_bytes(&out, sizeof out);
  }

  void stiffness(const Eigen::Matrix3d& from, Real* k) const {
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) *k++ = real(from(i, j));
  }
  std::uint32_t response(schema::LinearGrammar, const ActiveNodeModel& node) {
    const LinearResponse& from = node.linear;
    image::LinearResponse<Real> out{};
    stiffness(from.stiffness, out.stiffness);
    if (!_options.force_only) out.unit_responses = put(reals(from.unit_responses));
    return put_bytes(&out, sizeof out);
  }

  std::uint32_t response(schema::ModalGrammar, const ActiveNodeModel& node) {
    image::ModalResponse<Real> out{};
    const auto& force = node.conservative;
    out.center = put_indices(force.centers);
    const auto coefficients = reals(force.coefficients);
    out.coefficient = put(coefficients);
    for (std::size_t i = 0; i < coefficients.size(); ++i) out.total[i % 3] += coefficients[i];
    out.shape = real(force.shape);
    stiffness(force.stiffness, out.stiffness);
    const auto& modal = node.modal;
    const auto m = static_cast<std::size_t>(modal.weights.cols());
    if (!_options.force_only && m > 0) {
      out.weights = put_scaled(modal.weights);
      out.mixing = put_scaled(modal.mixing);
      out.near = put_indices(modal.near);
      out.near_modes = put_scaled(modal.near_modes);
      const auto n_shared = static_cast<std::size_t>(_model.shared.modes.cols());
      _n_scratch = std::max(_n_scratch, _model.shared.centers.size() + 3 + n_shared + 2 * m);
    }
    return put_bytes(&out, sizeof out);
  }

  /// Computes the residual of rounding at rest by the functions that evaluate images. With R = 1 the results are not
  /// rounded afterwards.
  void set_rest(const std::vector<image::ActiveNode<Real>>& nodes) {
    const Real R = _header.max_displacement;
    _header.max_displacement = 1;
    seal();
    using Functions = Image<Real>;
    const typename Functions::Type* opened = nullptr;
    const int status = Functions::open(_bytes.data(), _bytes.size(), &opened);
    if (status != PHN_OK)
      throw failure("the loader refuses the exported image", phn_status_message(status),
                    "this is a defect; please report it");
    const Real rest[3] = {0, 0, 0};
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      Real force[3], energy = 0;
      const auto tool = Functions::tool_at(_model.nodes[i].node, rest);
      Functions::force(opened, &tool, force);
      Functions::energy(opened, &tool, &energy);
      image::ModalResponse<Real> response;
      std::byte* at = _bytes.data() + nodes[i].response;
      std::memcpy(&response, at, sizeof response);
      for (int k = 0; k < 3; ++k) response.force_at_rest[k] = -force[k];
      response.energy_at_rest = -energy;
      std::memcpy(at, &response, sizeof response);
    }
    _header.max_displacement = R;
  }

  /// Writes header, size and checksum.
  void seal() {
    _bytes.resize((_bytes.size() + 7) / 8 * 8);
    _header.bytes = static_cast<std::uint32_t>(_bytes.size());
    std::memcpy(_bytes.data(), &_header, sizeof _header);
    const auto* words = reinterpret_cast<const std::uint32_t*>(_bytes.data());
    _header.checksum = image::checksum(words + image::n_unchecked_words, _bytes.size() / 4 - image::n_unchecked_words);
    std::memcpy(_bytes.data(), &_header, sizeof _header);
  }
  const Model& _model;
  const bool _has_modes = schema::traits(_model.family).has_modes;
  const ImageOptions& _options;
  std::vector<std::byte> _bytes;
  image::Header<Real> _header{};
  std::vector<Real> _displacements;
  std::vector<double> _depth;
  image::Table _depth_table{};
  std::size_t _n_triangles = 0, _n_scratch = 0;
};

}  // namespace

ImageContents read_image(const std::vector<std::uint64_t>& words, std::size_t bytes, const std::string& source) {
  ImageContents contents;
  const auto read = [&](auto real) {
    using Functions = Image<decltype(real)>;
    const typename Functions::Type* image = nullptr;
    const int status = Functions::open(words.data(), bytes, &image);
    typename Functions::Contents said;
    if (Functions::info(image, &said) == PHN_OK)
      contents = {sizeof real == sizeof(float), said.n_active, said.n_output, said.provenance, said.relaxation};
    return status;
  };
  int status = read(double{});
  if (status == PHN_ERROR_IMAGE_OF_FLOATS) status = read(float{});
  if (status != PHN_OK)
    throw input_error("the image is refused: " + std::string(phn_status_message(status)), source,
                      "write it again with phynness export");
  return contents;
}

ModelImage model_image(const Model& model, const ImageOptions& options) {
  return options.floats ? ImageWriter<float>(model, options).write() : ImageWriter<double>(model, options).write();
}

}  // namespace phynness
