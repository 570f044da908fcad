// The part of model.txt that depends on the family (NETWORK and LINEAR of formats/model.md): writer and
// reader.
#include "model_response.hpp"

#include <cmath>

namespace phynness {
namespace {

// Beyond these a Gaussian is a spike or a constant in double, and r*r or its inverse could overflow in a
// float reader.
constexpr double smallest_spread = 1e-6, largest_spread = 1e6;
constexpr int largest_integer = 32767;

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

void write_stiffness(ModelEmitter& w, const Eigen::Matrix3d& k) {
  w.word("stiffness");
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) w.real(k(i, j));
  }
  w.end();
}

void read_stiffness(ModelLexer& lexer, Eigen::Matrix3d& k) {
  lexer.keyword("stiffness");
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) k(i, j) = k(j, i) = linear_entry(lexer, "stiffness");
  }
  lexer.end_line();
}

void write_linear(ModelEmitter& w, const Model& model, const LinearResponse& linear) {
  const Eigen::Matrix3d& k = linear.stiffness;
  require_writable(linear.unit_responses.rows() == static_cast<Eigen::Index>(model.output.size()),
                   "unit responses do not fit the output nodes");
  require_writable(k == k.transpose(), "stiffness is not symmetric");
  require_writable((k.array().abs() <= largest_linear_entry).all() &&
                       (linear.unit_responses.array().abs() <= largest_linear_entry).all(),
                   "a stiffness or response is not finite or beyond 1e100");
  write_stiffness(w, k);
  w.word("unit_responses").end();
  for (Eigen::Index o = 0; o < linear.unit_responses.rows(); ++o) w.reals(linear.unit_responses.row(o)).end();
}

void read_linear(ModelLexer& lexer, const Model& model, LinearResponse& linear) {
  read_stiffness(lexer, linear.stiffness);
  lexer.keyword("unit_responses");
  lexer.end_line();
  linear.unit_responses.resize(static_cast<Eigen::Index>(model.output.size()), 9);
  for (Eigen::Index o = 0; o < linear.unit_responses.rows(); ++o) {
    for (int i = 0; i < 9; ++i) linear.unit_responses(o, i) = linear_entry(lexer, "unit response");
    lexer.end_line();
  }
}

double shape_line(ModelLexer& lexer) {
  const double shape = lexer.vector_line("shape", 1, true)[0];
  if (shape < smallest_spread || shape > largest_spread)
    lexer.refuse("shape is out of range 1e-6 ... 1e6", "");
  return shape;
}

}  // namespace

void write_conservative(ModelEmitter& w, const Model& model, const ConservativeNetwork& force) {
  require_writable(force.coefficients.rows() == static_cast<Eigen::Index>(force.centers.size()),
                   "coefficients do not fit the centers");
  require_writable(force.shape >= smallest_spread && force.shape <= largest_spread, "shape out of range");
  require_writable(force.stiffness == force.stiffness.transpose(), "stiffness is not symmetric");
  require_writable((force.stiffness.array().abs() <= largest_linear_entry).all() &&
                       (force.coefficients.array().abs() <= largest_linear_entry).all(),
                   "a stiffness or coefficient is not finite or beyond 1e100");
  w.word("force").integer(static_cast<std::int64_t>(force.centers.size())).end();
  w.word("shape").real(force.shape).end();
  write_stiffness(w, force.stiffness);
  for (std::size_t i = 0; i < force.centers.size(); ++i) {
    require_writable(force.centers[i] >= 0 && force.centers[i] < model.displacements.rows(),
                     "no such center");
    w.integer(force.centers[i]).reals(force.coefficients.row(static_cast<Eigen::Index>(i))).end();
  }
}

void read_conservative(ModelLexer& lexer, const Model& model, ConservativeNetwork& force) {
  const std::int32_t n = lexer.count_line("force");
  force.shape = shape_line(lexer);
  read_stiffness(lexer, force.stiffness);
  force.coefficients.resize(n, 3);
  for (std::int32_t i = 0; i < n; ++i) {
    force.centers.push_back(lexer.integer("displacement of a center", 0, model.displacements.rows() - 1));
    for (int k = 0; k < 3; ++k) force.coefficients(i, k) = linear_entry(lexer, "coefficient");
    lexer.end_line();
  }
}

void write_table(ModelEmitter& w, std::string_view key, const ScaledTable& table) {
  require_writable(table.scale.size() == table.cols(), "scales do not fit the columns of a table");
  require_writable((table.scale.array() >= 0).all() &&
                       (table.scale.array() * largest_integer <= largest_table_value).all(),
                   "a scale is negative or too large");
  require_writable((table.entries.array() >= -largest_integer).all(), "an entry is below -32767");
  w.word(key).reals(table.scale).end();
  for (Eigen::Index r = 0; r < table.rows() && table.cols() > 0; ++r) {
    for (Eigen::Index c = 0; c < table.cols(); ++c) w.integer(table.entries(r, c));
    w.end();
  }
}

ScaledTable read_table(ModelLexer& lexer, std::string_view key, Eigen::Index rows, Eigen::Index cols) {
  ScaledTable table;
  lexer.keyword(key);
  table.scale.resize(cols);
  lexer.reals("scale", table.scale);
  if (!(table.scale.array() >= 0).all() ||
      !(table.scale.array() * largest_integer <= largest_table_value).all())
    lexer.refuse("scale is negative or too large", key);
  lexer.end_line();
  lexer.require_room(key, rows * cols);
  table.entries.resize(rows, cols);
  for (Eigen::Index r = 0; r < rows && cols > 0; ++r) {
    for (Eigen::Index c = 0; c < cols; ++c)
      table.entries(r, c) =
          static_cast<std::int16_t>(lexer.integer("table entry", -largest_integer, largest_integer));
    lexer.end_line();
  }
  return table;
}

void write_modes(ModelEmitter& w, std::string_view key, const ModesShape& shape,
                 const ModalDeformation& modal) {
  const auto n_modes = modal.weights.cols(), n_near = static_cast<Eigen::Index>(modal.near.size());
  require_writable(n_modes <= largest_mode_count, "too many modes");
  require_writable(modal.mixing.cols() == n_modes && modal.near_modes.cols() == n_modes,
                   "tables differ in their number of modes");
  require_writable(modal.weights.rows() == shape.n_basis && modal.mixing.rows() == shape.n_shared &&
                       modal.near_modes.rows() == shape.components * n_near,
                   "tables do not fit the shared modes, centers or near nodes");
  w.word(key).integer(n_modes).end();
  write_table(w, "weights", modal.weights);
  write_table(w, "mixing", modal.mixing);
  w.word("near").integer(n_near).end();
  for (const auto position : modal.near) w.integer(position).end();
  write_table(w, "near_modes", modal.near_modes);
}

void read_modes(ModelLexer& lexer, std::string_view key, const ModesShape& shape, Eigen::Index n_output,
                ModalDeformation& modal) {
  lexer.keyword(key);
  const auto n_modes = lexer.integer("modes", 0, largest_mode_count);
  lexer.end_line();
  modal.weights = read_table(lexer, "weights", shape.n_basis, n_modes);
  modal.mixing = read_table(lexer, "mixing", shape.n_shared, n_modes);
  modal.near.resize(lexer.count_line("near"));
  std::int32_t previous = -1;
  for (auto& position : modal.near) {
    position = lexer.integer("near node", 0, n_output - 1);
    if (position <= previous) lexer.refuse("near nodes must ascend", std::to_string(position));
    previous = position;
    lexer.end_line();
  }
  modal.near_modes = read_table(lexer, "near_modes",
                                shape.components * static_cast<Eigen::Index>(modal.near.size()), n_modes);
}

namespace {

/// Of a deformation.
ModesShape modes_shape(const Model& model) {
  return {static_cast<Eigen::Index>(model.shared.centers.size()) + 3, model.shared.modes.cols(), 3};
}

}  // namespace

ScaledTable scaled_table(const Eigen::MatrixXd& values) {
  ScaledTable table;
  table.scale = Eigen::VectorXd::Zero(values.cols());
  table.entries.setZero(values.rows(), values.cols());
  for (Eigen::Index c = 0; c < values.cols() && values.rows() > 0; ++c) {
    const double largest = values.col(c).cwiseAbs().maxCoeff();
    table.scale[c] = largest / largest_integer;
    if (!(table.scale[c] > 0)) continue;
    for (Eigen::Index r = 0; r < values.rows(); ++r)
      table.entries(r, c) = static_cast<std::int16_t>(std::lround(values(r, c) / table.scale[c]));
  }
  return table;
}

void write_shared(ModelEmitter& w, const Model& model) {
  if (model.family != Family::modal) return;
  const SharedModes& shared = model.shared;
  require_writable(shared.modes.rows() == 3 * static_cast<Eigen::Index>(model.output.size()) &&
                       shared.modes.cols() <= largest_mode_count,
                   "shared modes do not fit the output nodes, or are too many");
  require_writable(shared.shape >= smallest_spread && shared.shape <= largest_spread, "shape out of range");
  w.word("shared_modes").integer(shared.modes.cols()).end();
  write_table(w, "modes", shared.modes);
  w.word("amplitude_centers").integer(static_cast<std::int64_t>(shared.centers.size())).end();
  w.word("shape").real(shared.shape).end();
  for (const auto center : shared.centers) w.integer(center).end();
}

void read_shared(ModelLexer& lexer, Model& model) {
  if (model.family != Family::modal) return;
  lexer.keyword("shared_modes");
  const auto n_modes = lexer.integer("modes", 0, largest_mode_count);
  lexer.end_line();
  model.shared.modes =
      read_table(lexer, "modes", 3 * static_cast<Eigen::Index>(model.output.size()), n_modes);
  model.shared.centers.resize(lexer.count_line("amplitude_centers"));
  model.shared.shape = shape_line(lexer);
  for (auto& center : model.shared.centers) {
    center = lexer.integer("displacement of a center", 0, model.displacements.rows() - 1);
    lexer.end_line();
  }
}

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
  if (model.family == Family::modal) {
    write_conservative(w, model, node.conservative);
    write_modes(w, "deformation", modes_shape(model), node.modal);
    return write_node_fields(w, model, node);
  }
  write_network(w, model, node.force, "force");
  write_network(w, model, node.deformation, "deformation");
}

void read_response(ModelLexer& lexer, const Model& model, ActiveNodeModel& node) {
  if (model.family == Family::linear) return read_linear(lexer, model, node.linear);
  if (model.family == Family::modal) {
    read_conservative(lexer, model, node.conservative);
    read_modes(lexer, "deformation", modes_shape(model), model.output_points.rows(), node.modal);
    return read_node_fields(lexer, model, node);
  }
  read_network(lexer, model, node.force, "force");
  read_network(lexer, model, node.deformation, "deformation");
}

}  // namespace phynness
