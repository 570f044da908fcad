// The part of model.txt that depends on the family (NETWORK and LINEAR of formats/model.md): writer and
// reader.
#include "model_response.hpp"

#include <cmath>

namespace phynness {
namespace {

// Beyond these a Gaussian is a spike or a constant in double, and r*r or its inverse could overflow in a
// float reader.
constexpr double smallest_spread = 1e-6, largest_spread = 1e6;

void write_network(ModelEmitter& w, const Model& model, const RbfNetwork& net, std::string_view key) {
  const bool deforms = key == "deformation";
  const std::size_t n = net.center_displacement.size();
  require_writable(static_cast<std::size_t>(net.weights.rows()) == n && net.weights.cols() == 3,
                   "weights do not fit the centers");
  require_writable(net.center_output.size() == (deforms ? n : 0), "center_output does not fit the centers");
  require_writable(net.spread >= smallest_spread && net.spread <= largest_spread, "spread out of range");
  require_writable(net.input_center.size() == (deforms ? 6 : 3) && net.output_center.size() == 3,
                   "wrong number of inputs or outputs");
  RbfNetwork again = net;
  fill_centers(model, again);
  require_writable(again.centers == net.centers, "centers differ from those that the indices give");

  w.word(key).integer(static_cast<std::int64_t>(n)).end();
  w.word("input_center").reals(net.input_center).end();
  w.word("input_half_range").reals(net.input_half_range).end();
  w.word("output_center").reals(net.output_center).end();
  w.word("output_half_range").reals(net.output_half_range).end();
  w.word("spread").real(net.spread).end();
  w.word("bias").reals(net.bias).end();
  for (std::size_t i = 0; i < n; ++i) {
    w.integer(net.center_displacement[i]);
    if (deforms) w.integer(net.center_output[i]);
    w.reals(net.weights.row(static_cast<Eigen::Index>(i))).end();
  }
}

void read_network(ModelLexer& lexer, const Model& model, RbfNetwork& net, std::string_view key) {
  const bool deforms = key == "deformation";
  const std::int32_t n = lexer.count_line(key);
  const Eigen::Index n_inputs = deforms ? 6 : 3;
  net.input_center = lexer.vector_line("input_center", n_inputs, false);
  net.input_half_range = lexer.vector_line("input_half_range", n_inputs, true);
  net.output_center = lexer.vector_line("output_center", 3, false);
  net.output_half_range = lexer.vector_line("output_half_range", 3, true);
  net.spread = lexer.vector_line("spread", 1, true)[0];
  if (net.spread < smallest_spread || net.spread > largest_spread)
    lexer.refuse("spread is out of range 1e-6 ... 1e6", "");
  net.bias = lexer.vector_line("bias", 3, false);
  net.weights.resize(n, 3);
  for (std::int32_t i = 0; i < n; ++i) {
    net.center_displacement.push_back(
        lexer.integer("displacement of a center", 0, model.displacements.rows() - 1));
    if (deforms)
      net.center_output.push_back(
          lexer.integer("output node of a center", 0, model.output_points.rows() - 1));
    lexer.reals("weight", net.weights.row(i));
    lexer.end_line();
  }
  fill_centers(model, net);
  if (!net.centers.allFinite()) lexer.refuse("a scaled center is not finite", "");
}

double linear_entry(ModelLexer& lexer, std::string_view what) {
  const double value = lexer.real(what);
  if (!(std::abs(value) <= largest_linear_entry)) lexer.refuse(std::string(what) + " is beyond 1e100", "");
  return value;
}

void write_linear(ModelEmitter& w, const Model& model, const LinearResponse& linear) {
  const Eigen::Matrix3d& k = linear.stiffness;
  require_writable(linear.unit_responses.rows() == static_cast<Eigen::Index>(model.output.size()),
                   "unit responses do not fit the output nodes");
  require_writable(k == k.transpose(), "stiffness is not symmetric");
  require_writable((k.array().abs() <= largest_linear_entry).all() &&
                       (linear.unit_responses.array().abs() <= largest_linear_entry).all(),
                   "a stiffness or response is not finite or beyond 1e100");
  w.word("stiffness");
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) w.real(k(i, j));
  }
  w.end();
  w.word("unit_responses").end();
  for (Eigen::Index o = 0; o < linear.unit_responses.rows(); ++o) w.reals(linear.unit_responses.row(o)).end();
}

void read_linear(ModelLexer& lexer, const Model& model, LinearResponse& linear) {
  lexer.keyword("stiffness");
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j)
      linear.stiffness(i, j) = linear.stiffness(j, i) = linear_entry(lexer, "stiffness");
  }
  lexer.end_line();
  lexer.keyword("unit_responses");
  lexer.end_line();
  linear.unit_responses.resize(static_cast<Eigen::Index>(model.output.size()), 9);
  for (Eigen::Index o = 0; o < linear.unit_responses.rows(); ++o) {
    for (int i = 0; i < 9; ++i) linear.unit_responses(o, i) = linear_entry(lexer, "unit response");
    lexer.end_line();
  }
}

}  // namespace

void fill_centers(const Model& model, RbfNetwork& net) {
  const auto n = static_cast<Eigen::Index>(net.center_displacement.size());
  net.centers.resize(n, net.input_center.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < net.input_center.size(); ++k) {
      const double value = k < 3 ? model.displacements(net.center_displacement[i], k)
                                 : model.output_points(net.center_output[i], k - 3);
      net.centers(i, k) = (value - net.input_center[k]) / net.input_half_range[k];
    }
  }
}

void write_response(ModelEmitter& w, const Model& model, const ActiveNodeModel& node) {
  if (model.family == Family::linear) return write_linear(w, model, node.linear);
  write_network(w, model, node.force, "force");
  write_network(w, model, node.deformation, "deformation");
}

void read_response(ModelLexer& lexer, const Model& model, ActiveNodeModel& node) {
  if (model.family == Family::linear) return read_linear(lexer, model, node.linear);
  read_network(lexer, model, node.force, "force");
  read_network(lexer, model, node.deformation, "deformation");
}

}  // namespace phynness
