#include "pairs.hpp"

#include <phynness/phynness_body.h>

#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>

#include "sampling.hpp"
#include "threads.hpp"

namespace phynness::reduced {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr int increments = 4, steps_of_increment = 100;
constexpr double part_of_depth = 0.5;

void require(int status) {
  if (status < 0)
    throw failure("the body of the pairs cannot be evaluated", phn_status_message(status), "please report this");
}

/// Uniform on the sphere.
Vector3d direction(SplitMix64& random) {
  for (;;) {
    Vector3d x;
    for (Index k = 0; k < 3; ++k) x[k] = static_cast<double>(random.next() >> 11) * 0x1p-52 - 1;
    const double size = x.norm();
    if (size <= 1 && size > 0.01) return x / size;
  }
}

class Pressed {
 public:
  explicit Pressed(const std::string& text) {
    std::size_t bytes = 0;
    require(phn_body_size(text.data(), text.size(), &bytes, nullptr));
    _memory.resize(bytes);
    require(phn_body_init(_memory.data(), bytes, text.data(), text.size(), &_body, nullptr));
    require(phn_body_describe(_body, &_info));
    require(phn_body_state_size(_body, 2, &_state_bytes));
  }

  /// The increments that settle. @param d  displacements of the tools at the end
  MatrixXd fields(const std::array<std::int32_t, 2>& nodes, const std::array<Vector3d, 2>& d) const {
    std::vector<std::byte> memory(_state_bytes);
    phn_body_state* state = nullptr;
    require(phn_body_state_init(memory.data(), memory.size(), _body, 2, &state));
    MatrixXd out(3 * _info.n_nodes, increments);
    Points u(_info.n_nodes, 3);
    Index count = 0;
    for (int i = 1; i <= increments; ++i) {
      std::array<phn_tool, 2> tools;
      for (std::size_t t = 0; t < 2; ++t) {
        tools[t] = {{nodes[t], -1, -1}, {1, 0, 0}, {}};
        for (Index k = 0; k < 3; ++k) tools[t].displacement[k] = d[t][k] * i / increments;
      }
      double forces[6];
      const int status = phn_body_press(_body, state, 2, tools.data(), steps_of_increment, forces, nullptr);
      if (status < 0 || (status & PHN_WARNING_UNSETTLED) != 0) break;
      require(phn_body_deform(_body, state, u.data()));
      out.col(count++) = u.reshaped();
    }
    return out.leftCols(count);
  }

 private:
  std::vector<std::byte> _memory;
  std::size_t _state_bytes = 0;
  const phn_body* _body = nullptr;
  phn_body_info _info{};
};

}  // namespace

MatrixXd fields_of_pairs(const ReducedBody& body, const std::vector<std::int32_t>& active, bool inward, int pairs,
                         std::uint64_t seed, int threads, const std::function<void()>& done) {
  const Pressed pressed(write_body_text(body));
  const Points normals = node_normals(body.points, body.surface);
  std::vector<MatrixXd> of_pairs(static_cast<std::size_t>(pairs));
  for_each_index(pairs, threads, [&](std::int32_t p) {
    SplitMix64 random(node_seed(seed, p));
    const auto two = draw_without_replacement(active.size(), 2, random);
    std::array<std::int32_t, 2> nodes;
    std::array<Vector3d, 2> d;
    for (std::size_t t = 0; t < 2; ++t) {
      nodes[t] = active[static_cast<std::size_t>(two[t])];
      d[t] = part_of_depth * body.depth_m * direction(random);
      if (inward && normals.row(nodes[t]).dot(d[t]) > 0) d[t] = -d[t];
    }
    of_pairs[static_cast<std::size_t>(p)] = pressed.fields(nodes, d);
    done();
  });
  Index n = 0;
  for (const auto& fields : of_pairs) n += fields.cols();
  MatrixXd out(3 * body.points.rows(), n);
  n = 0;
  for (const auto& fields : of_pairs) {
    out.middleCols(n, fields.cols()) = fields;
    n += fields.cols();
  }
  return out;
}

}  // namespace phynness::reduced
