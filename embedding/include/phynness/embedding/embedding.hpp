// A model for devices: an image (formats/image.md), C source that holds it, and answers to compare with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <phynness/formats/model.hpp>
#include <string>
#include <vector>

namespace phynness {

class LoadedModel;

struct ImageOptions {
  bool force_only = false;  ///< leave the deformation out
  bool floats = false;      ///< store and compute in float
};

struct ModelImage {
  std::vector<std::byte> bytes;
  ImageOptions options;
  std::size_t n_active = 0, n_output = 0;
  std::size_t n_scratch = 0;  ///< numbers that a deformation needs besides its result

  std::size_t real_bytes() const { return options.floats ? sizeof(float) : sizeof(double); }
  /// For deformations: scratch and result. A force needs none.
  std::size_t ram_bytes() const { return real_bytes() * (n_scratch + 3 * n_output); }
};

/// @throws Error if the model is too large for the layout or a number too large for a float
ModelImage model_image(const Model& model, const ImageOptions& options);

/// A question to a model, what the runtime answers in double and what the image does.
struct GoldenQuery {
  std::int32_t node = 0;
  Vec3 displacement_m{0, 0, 0};
  Vec3 force_N{0, 0, 0}, image_force_N{0, 0, 0};
  int status = 0;                                             ///< of the image's force
  std::int32_t output = 0;                                    ///< a position among the output nodes; it changes
  Vec3 deformation_m{0, 0, 0}, image_deformation_m{0, 0, 0};  ///< of that node; 0 if there are forces only
};

struct GoldenQueries {
  std::vector<GoldenQuery> query;
  /// Largest difference between image and runtime, over the largest component of all answers.
  double force_deviation = 0, deformation_deviation = 0;
};

/// `n` queries: in turn all active nodes; rest, both ways along each axis, then directions and depths at
/// random inside the trained range, every fourth beyond it up to 1.43 times, every sixteenth at 3 times.
/// Repeatable. Displacements are numbers that the image can hold.
GoldenQueries golden_queries(const LoadedModel& model, const ModelImage& image, std::size_t n);

struct CSource {
  std::string header, source;
};
/// NAME.h and NAME.c: the image as a const array, and what it needs as constants of the preprocessor.
/// @param name  an identifier of C
CSource c_source(const ModelImage& image, const Model& model, const std::string& name);
/// NAME_golden.h and NAME_golden.c.
CSource c_source(const GoldenQueries& queries, const Model& model, const std::string& name);

}  // namespace phynness
