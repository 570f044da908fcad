// phn_image_open. It checks identity, size and checksum, that every table lies inside of the image and every index
// inside of its table, that every number is within bounds for which sums are finite, and that the working memory is
// the one that the responses need.
#include "image/image.hpp"

// The following code runs once and is optimized for size. It consists of comparisons only.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC push_options
#pragma GCC optimize("Os")
#endif

using namespace PHN_IMAGES;

namespace {

namespace image = phynness::image;
namespace schema = phynness::schema;

class ImageCheck {
 public:
  explicit ImageCheck(const Header& image) : _image(image) {}

  int status() {
    header();
    if (!_good) return PHN_ERROR_RANGE;
    const auto* node = at<ActiveNode>(_image, _image.active);
    for (uint32_t i = 0; i < _image.active.n && _good; ++i) active(node[i]);
    // A larger number is refused, too: its size in bytes would wrap around where size_t has 32 bits.
    require(_image.n_scratch == _n_scratch);
    return _good ? PHN_OK : PHN_ERROR_RANGE;
  }

 private:
  void require(bool condition) { _good = _good && condition; }
  /// Records the working memory of a deformation. @param n  Reals; bounded by the largest counts
  void require_scratch(uint32_t n) {
    if (_n_scratch < n) _n_scratch = n;
  }

  /// Whether n values of T lie inside of the image.
  template <class T>
  bool inside(uint32_t offset, uint32_t n) const {
    return offset % alignof(T) == 0 && offset <= _image.bytes && n <= (_image.bytes - offset) / sizeof(T);
  }
  /// Checks a table of n x per values.
  template <class T>
  void table(image::Table found, uint32_t n, uint32_t per = 1) {
    require(n <= image::largest_table / per && found.n == n * per && inside<T>(found.at, found.n));
  }
  void indices(image::Table found, uint32_t below) {
    require(inside<uint16_t>(found.at, found.n));
    if (!_good) return;
    const auto* index = at<uint16_t>(_image, found);
    for (uint32_t i = 0; i < found.n; ++i) require(index[i] < below);
  }
  void ascending(image::Table found) {
    require(inside<int32_t>(found.at, found.n));
    if (!_good) return;
    const auto* node = at<int32_t>(_image, found);
    for (uint32_t i = 1; i < found.n; ++i) require(node[i] > node[i - 1]);
  }
  /// Checks |value| <= bound, which is false for NaN. The bits are compared as integers, of doubles only the upper
  /// halves, which is fast without a floating-point unit.
  void within(const Real* value, uint32_t n, double bound) {
    constexpr uint32_t n_words = sizeof(Real) / sizeof(uint32_t);
    const auto size = [](const Real* at) {
      uint32_t word[n_words];
      __builtin_memcpy(word, at, sizeof word);
      return word[n_words - 1] & 0x7fffffff;
    };
    const Real most = Real(bound);
    const uint32_t largest = size(&most);
    for (uint32_t i = 0; i < n; ++i) require(size(value + i) <= largest);
  }
  /// Checks a table of n x per numbers.
  void reals(image::Table found, uint32_t n, uint32_t per = 1, double bound = image::Bounds<Real>::value) {
    table<Real>(found, n, per);
    if (_good) within(at<Real>(_image, found), found.n, bound);
  }
  void shape(Real value) { require(value >= Real(1 / image::largest_shape) && value <= Real(image::largest_shape)); }
  void scaled(const image::ScaledTable& found, uint32_t n_rows, uint32_t n_columns) {
    require(n_columns <= image::largest_mode_count);
    reals(found.scale, n_columns, 1, image::largest_scale);
    require(n_columns == 0 || n_rows <= image::largest_table / n_columns);
    table<int16_t>(found.entry, n_rows * n_columns);
  }

  void header() {
    ascending(_image.active_nodes);
    reals(_image.active_points, _image.active_nodes.n, 3);
    table<ActiveNode>(_image.active, _image.active_nodes.n);
    ascending(_image.output_nodes);
    reals(_image.output_points, _image.output_nodes.n, 3);
    reals(_image.directions, _image.directions.n / 3, 3);
    _n_displacements = _image.displacements.n / 3;
    const bool modal = traits(_image).has_modes;
    reals(_image.displacements, _n_displacements, 3, modal ? image::largest_displacement : image::Bounds<Real>::value);
    indices(_image.amplitude_center, _n_displacements);
    require(_image.amplitude_center.n <= image::largest_count);
    reals(_image.amplitude_at_rest, _image.amplitude_center.n, 1, image::largest_at_rest);
    scaled(_image.modes, 3 * _image.output_nodes.n, _image.modes.scale.n);
    constexpr Real largest = image::Bounds<Real>::max_displacement;
    require(_image.max_displacement >= 1 / largest && _image.max_displacement <= largest);
    if (modal) shape(_image.amplitude_shape);
    provenance();
  }

  void provenance() {
    require(inside<image::Provenance>(_image.provenance, 1));
    if (!_good) return;
    const auto& origin = *at<image::Provenance>(_image, _image.provenance);
    const char* const texts[] = {origin.mesh_hash, origin.physics_hash, origin.element, origin.reference};
    for (const char* text : texts) require(text[sizeof origin.element - 1] == 0);
    const uint32_t* const numbers[] = {origin.shear_modulus_Pa, origin.finer_mean, origin.finer_p95,
                                       origin.finer_tool_radius_m};
    for (const uint32_t* number : numbers) require(number[1] < 0x7ff00000);  // not negative, infinite or NaN
    require(origin.bound_reference >= 0 && origin.bound_reference <= schema::n_bound_references);
    // The radius and two numbers for each term, as halves of doubles.
    const uint32_t n = origin.relaxation.n;
    require(n == 0 || (n % 4 == 2 && n > 2 && n <= 2 + 4 * schema::largest_relaxation_count));
    require(inside<uint32_t>(origin.relaxation.at, n));
    if (!_good) return;
    const auto* halves = at<uint32_t>(_image, origin.relaxation);
    for (uint32_t i = 1; i < n; i += 2) require(halves[i] < 0x7ff00000);
    if (origin.surface == 0) return;
    require(inside<image::Surface>(origin.surface, 1));
    if (_good) surface(*surface_of(_image));
  }

  void surface(const image::Surface& surface) {
    const uint32_t n_active = _image.active_nodes.n, n_triangles = surface.triangle.n / 6, n = surface.vertex.n;
    const bool bounded = surface.bound.n > 0;
    require(n_active > 0 && n_triangles > 0 && _image.directions.n > 0);
    require(!bounded || (_n_displacements >= _image.directions.n / 3 && !traits(_image).proportional));
    if (!_good) return;
    table<uint16_t>(surface.triangle, n_triangles, 6);
    table<image::VertexCorners>(surface.vertex, n);
    reals(surface.point, n, 3);
    const uint32_t n_linear = surface.rest_point.n / 3, n_points = n_active + n_linear;
    require(n_linear <= image::largest_count);
    if (!_good) return;
    reals(surface.rest_point, n_linear, 3);
    reals(surface.rest_stiffness, n_linear, 6);
    table<uint32_t>(surface.begin, n_points + 1);
    indices(surface.neighbour, n_points);
    reals(surface.slope, surface.neighbour.n, 3);
    table<int16_t>(surface.bound, bounded ? _n_displacements : 0, n_active);
    reals(surface.bound_scale, bounded ? n_active : 0);
    reals(surface.between, bounded ? schema::n_coupled_terms : 0, 1, image::largest_exponent);
    if (!_good) return;
    const auto* triangle = at<uint16_t>(_image, surface.triangle);
    for (uint32_t i = 0; i < 6 * n_triangles; ++i)
      require(i % 6 < 3 ? triangle[i] < n : triangle[i] < n_triangles || triangle[i] == image::none);
    const auto* vertex = at<image::VertexCorners>(_image, surface.vertex);
    for (uint32_t v = 0; v < n; ++v)
      for (const uint16_t active : vertex[v].active) require(active < n_points || vertex[v].active[0] == image::none);
    const auto* begin = at<uint32_t>(_image, surface.begin);
    for (uint32_t i = 0; i < n_points; ++i)
      require(begin[i] <= begin[i + 1] && begin[i + 1] - begin[i] <= image::most_neighbours);
    require(begin[n_points] == surface.neighbour.n);
  }

  template <int n_inputs>
  void network(const image::Network<Real, n_inputs>& net, uint32_t n_outputs) {
    indices(net.displacement, _n_displacements);
    require(net.displacement.n <= image::largest_count);
    reals(net.weight, net.displacement.n, 3);
    within(net.factor, n_inputs, image::Bounds<Real>::value);
    within(net.constant, 3, image::Bounds<Real>::value);
    if (n_inputs == 3) return;
    indices(net.output, n_outputs);
    require(net.output.n == net.displacement.n);
    require_scratch(net.displacement.n);
  }

  void response(const RbfnResponse& rbfn) {
    network(rbfn.force, 0);
    network(rbfn.deformation, _image.output_nodes.n);
  }
  void response(const LinearResponse& linear) {
    within(linear.stiffness, 6, image::Bounds<Real>::value);
    reals(linear.unit_responses, _image.output_nodes.n, 9);
  }
  void response(const ModalResponse& modal) {
    indices(modal.center, _n_displacements);
    require(modal.center.n <= image::largest_count);
    reals(modal.coefficient, modal.center.n, 3);
    shape(modal.shape);
    constexpr double value = image::Bounds<Real>::value;
    within(modal.stiffness, 6, value);
    within(modal.total, 3, image::largest_total * value);
    within(modal.force_at_rest, 3, image::largest_force_at_rest * value);
    within(&modal.energy_at_rest, 1, image::largest_energy_at_rest * value);
    const uint32_t m = modal.weights.scale.n, n_centers = _image.amplitude_center.n, n_shared = _image.modes.scale.n;
    scaled(modal.weights, n_centers + 3, m);
    scaled(modal.mixing, n_shared, m);
    indices(modal.near, _image.output_nodes.n);
    scaled(modal.near_modes, 3 * modal.near.n, m);
    if (m > 0) require_scratch(n_centers + 3 + n_shared + 2 * m);
  }
  template <class Response>
  void response_of(const Response* type, uint32_t offset) {
    require(inside<Response>(offset, 1));
    if (_good) response(response_at(_image, offset, type));
  }

  void active(const ActiveNode& node) {
    indices(node.prescribed, _image.output_nodes.n);
    reals(node.prescribed_weight, node.prescribed.n);
    reals(node.trained_depth, _image.directions.n / 3);
    if (!_good) return;
    const Real* depth = at<Real>(_image, node.trained_depth);
    for (uint32_t i = 0; i < node.trained_depth.n; ++i) require(depth[i] >= 0);
    with_response_type(_image.family, [&](const auto* type) { response_of(type, node.response); });
  }

  const Header& _image;
  uint32_t _n_displacements = 0, _n_scratch = 0;
  bool _good = true;
};

int check(const void* memory, size_t bytes) {
  if (memory == nullptr || reinterpret_cast<uintptr_t>(memory) % alignof(Header) != 0) return PHN_ERROR_ARGUMENT;
  const auto& image = *static_cast<const Header*>(memory);
  if (bytes < sizeof(uint32_t) || image.magic != image::magic) return PHN_ERROR_NOT_A_MODEL;
  if (bytes < sizeof(image)) return PHN_ERROR_TRUNCATED;
  if (image.version != image::version) return PHN_ERROR_VERSION;
  constexpr size_t other_real_bytes = sizeof(float) + sizeof(double) - sizeof(Real);
  if (image.real_bytes == other_real_bytes)
    return sizeof(Real) == sizeof(float) ? PHN_ERROR_IMAGE_OF_DOUBLES : PHN_ERROR_IMAGE_OF_FLOATS;
  if (image.real_bytes != sizeof(Real)) return PHN_ERROR_CHECKSUM;
  if (image.bytes > bytes || image.bytes < sizeof(image) || image.bytes % 4 != 0 || image.bytes > image::largest_table)
    return PHN_ERROR_TRUNCATED;
  const auto* word = static_cast<const uint32_t*>(memory) + image::n_unchecked_words;
  if (image::checksum(word, image.bytes / 4 - image::n_unchecked_words) != image.checksum) return PHN_ERROR_CHECKSUM;
  if (static_cast<uint32_t>(image.family) >= schema::n_families) return PHN_ERROR_FAMILY;
  return ImageCheck(image).status();
}

}  // namespace

extern "C" int phn_image_open(const void* memory, size_t bytes, const phn_image** image) {
  if (image == nullptr) return PHN_ERROR_ARGUMENT;
  const int status = overlap(memory, bytes, image, sizeof *image) ? PHN_ERROR_OVERLAP : check(memory, bytes);
  *image = status == PHN_OK ? static_cast<const phn_image*>(memory) : nullptr;
  return status;
}

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC pop_options
#endif
