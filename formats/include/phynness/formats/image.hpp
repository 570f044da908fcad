// A model for devices: an image (formats/image.md), C source that contains it, and golden queries for tests of devices.
#pragma once

#include <phynness/phynness_image.h>
#include <cstddef>
#include <cstdint>
#include <phynness/formats/model.hpp>
#include <phynness/phynness.hpp>
#include <string>
#include <vector>

namespace phynness {

struct ImageOptions {
  bool force_only = false;  ///< without deformation
  bool floats = false;      ///< store and compute in float
};

struct ModelImage {
  std::vector<std::byte> bytes;  ///< aligned as phn_image_open needs them
  ImageOptions options;
  std::size_t n_active = 0, n_output = 0;
  std::size_t n_triangles = 0;  ///< on which a tool can be; 0: at nodes only
  std::size_t n_scratch = 0;    ///< numbers that a deformation needs besides its result

  std::size_t real_bytes() const { return options.floats ? sizeof(float) : sizeof(double); }
  /// Bytes for a deformation: scratch and result. A force needs no memory.
  std::size_t ram_bytes() const { return real_bytes() * (n_scratch + 3 * n_output); }
};

/// @throws Error if the model is too large for the layout or a number is too large for a float
ModelImage model_image(const Model& model, const ImageOptions& options);

/// What an image says of itself.
struct ImageContents {
  bool floats = false;
  std::int32_t n_active = 0, n_output = 0;
  phn_provenance provenance{};  ///< its strings belong to the image
  phn_relaxation relaxation{};
};
/// @param words  the image, aligned. @param bytes  of its file. @param source  its name in messages
/// @throws Error (input) if it is no image, or damaged
ImageContents read_image(const std::vector<std::uint64_t>& words, std::size_t bytes, const std::string& source);

/// A tool with the responses of the runtime in double and of the image.
struct GoldenQuery {
  std::int32_t node = -1;  ///< -1: the tool is at the place that the image finds for the point
  Vec3 point_m{0, 0, 0};
  Vec3 displacement_m{0, 0, 0};
  std::int32_t triangle = -1;  ///< of the place, as are the weights
  Vec3 weights{0, 0, 0};
  int status = 0;  ///< of the force of the image
  Vec3 force_N{0, 0, 0}, image_force_N{0, 0, 0};
  double bound_N = PHN_NO_BOUND, image_bound_N = PHN_IMAGE_NO_BOUND;
  std::int32_t output = 0;  ///< a position in the list of output nodes, which varies from query to query
  Vec3 deformation_m{0, 0, 0}, image_deformation_m{0, 0, 0};  ///< of that node; 0 between nodes and with forces only
};

struct GoldenQueries {
  std::vector<GoldenQuery> query;
  std::size_t n_measured = 0;  ///< queries from which the deviations are, at least 256 at nodes
  /// Largest difference between image and runtime, over the largest component of all responses.
  double force_deviation = 0, deformation_deviation = 0;
};

/// `n` queries at all active nodes in turn: rest, both directions along each axis, then random directions and depths
/// inside the trained range. Every fourth query is outside of it, up to a factor of 1.43, and every sixteenth has a
/// factor of 3. On the surface of an image there are a quarter as many between nodes, too. The queries are
/// reproducible. Displacements and points are numbers that the image can represent.
/// @param organ  the same model in the runtime
GoldenQueries golden_queries(const Model& model, Organ& organ, const ModelImage& image, std::size_t n);

struct CSource {
  std::string header, source;
};
/// NAME.h and NAME.c: the image as a const array, and its sizes as constants of the preprocessor.
/// @param name  a C identifier
CSource c_source(const ModelImage& image, const Model& model, const std::string& name);
/// NAME_golden.h and NAME_golden.c.
CSource c_source(const GoldenQueries& queries, const Model& model, const std::string& name);

}  // namespace phynness
