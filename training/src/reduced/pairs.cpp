#include "parts.hpp"

#include <phynness/phynness.h>
#include <phynness/phynness_body.h>

#include <cstddef>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>
#include <string>

#include "sampling.hpp"
#include "threads.hpp"

namespace phynness::reduced {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr int increments = 4, steps_of_increment = 100;
constexpr double part_of_depth = 0.5;

/// Uniform on the sphere.
Vector3d direction(SplitMix64& random) {
  for (;;) {
    Vector3d x;
    for (Index k = 0; k < 3; ++k) x[k] = static_cast<double>(random.next() >> 11) * 0x1p-52 - 1;
    const double size = x.norm();
    if (size <= 1 && size > 0.01) return x / size;
  }
}

/// A body in the runtime.
class LoadedBody {
 public:
  explicit LoadedBody(const std::string& text) {
    std::size_t bytes = 0;
    require(phn_body_size(text.data(), text.size(), &bytes, nullptr));
    _memory.resize(bytes);
    require(phn_body_init(_memory.data(), bytes, text.data(), text.size(), &_body, nullptr));
    require(phn_body_state_size(_body, PHN_MOST_COUPLED, &bytes));
    _state_memory.resize(bytes);
  }

  /// Displacements from rest to `tools`: the fields of the increments that settle.
  /// @param n  nodes of its surface
  MatrixXd press(const std::vector<phn_tool>& tools, Index n) {
    phn_body_state* state = nullptr;
    require(phn_body_state_init(_state_memory.data(), _state_memory.size(), _body, PHN_MOST_COUPLED, &state));
    MatrixXd fields(3 * n, increments);
    Points displacement(n, 3);
    std::vector<double> forces(3 * tools.size());
    for (int i = 1; i <= increments; ++i) {
      auto part = tools;
      for (phn_tool& tool : part)
        for (double& d : tool.displacement) d = d * i / increments;
      phn_body_report pressed;
      const int status = phn_body_force(_body, state, static_cast<std::int32_t>(part.size()), part.data(),
                                        steps_of_increment, forces.data(), &pressed);
      require(status);
      if ((status & PHN_WARNING_UNSETTLED) != 0) return fields.leftCols(i - 1);
      require(phn_body_deform(_body, state, displacement.data()));
      fields.col(i - 1) = displacement.reshaped();
    }
    return fields;
  }

 private:
  static void require(int status) {
    if (status < 0)
      throw failure("the runtime refuses the body of the pairs", phn_status_message(status),
                    "please report this defect");
  }

  std::vector<std::byte> _memory, _state_memory;
  const phn_body* _body = nullptr;
};

}  // namespace

MatrixXd fields_of_pairs(const ReducedBody& body, const std::vector<std::int32_t>& active, bool inward, int pairs,
                         std::uint64_t seed, int threads, const std::function<void()>& done) {
  const std::string text = write_body_text(body);
  const Points normals = node_normals(body.points, body.surface);
  std::vector<MatrixXd> of_pairs(static_cast<std::size_t>(pairs));
  for_each_index(threads, threads, [&](std::int32_t first) {
    LoadedBody loaded(text);
    for (std::int32_t p = first; p < pairs; p += threads) {
      SplitMix64 random(node_seed(seed, p));
      std::vector<phn_tool> tools;
      for (const std::int32_t a : draw_without_replacement(active.size(), 2, random)) {
        const std::int32_t node = active[static_cast<std::size_t>(a)];
        Vector3d d = part_of_depth * body.depth_m * direction(random);
        if (inward && normals.row(node).dot(d) > 0) d = -d;
        tools.push_back({{node, -1, -1}, {1, 0, 0}, {d[0], d[1], d[2]}});
      }
      of_pairs[static_cast<std::size_t>(p)] = loaded.press(tools, body.points.rows());
      done();
    }
  });
  return side_by_side(std::move(of_pairs), 3 * body.points.rows());
}

}  // namespace phynness::reduced
