// model.txt: writer and reader. The grammar is formats/model.md; the two halves below follow it section by
// section.
#include <cmath>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/model.hpp>

#include "model_emitter.hpp"
#include "model_lexer.hpp"

namespace phynness {
namespace {

constexpr std::string_view magic = "phynness-model";
constexpr std::int64_t version = 1;
// Beyond these a Gaussian is a spike or a constant in double, and r*r or its inverse could overflow in a
// float reader.
constexpr double smallest_spread = 1e-6, largest_spread = 1e6;
constexpr std::size_t checksum_line_length = sizeof("checksum 0123456789abcdef\n") - 1;

void require(bool condition, const char* what) {
  if (!condition)
    throw failure(std::string("model cannot be written: ") + what, "",
                  "this is a defect of the program that made it");
}

void write_network(ModelEmitter& w, const Model& model, const RbfNetwork& net, std::string_view key) {
  const bool deforms = key == "deformation";
  const std::size_t n = net.center_displacement.size();
  require(static_cast<std::size_t>(net.weights.rows()) == n && net.weights.cols() == 3,
          "weights do not fit the centers");
  require(net.center_output.size() == (deforms ? n : 0), "center_output does not fit the centers");
  require(net.spread >= smallest_spread && net.spread <= largest_spread, "spread out of range");
  require(net.input_center.size() == (deforms ? 6 : 3) && net.output_center.size() == 3,
          "wrong number of inputs or outputs");
  RbfNetwork again = net;
  fill_centers(model, again);
  require(again.centers == net.centers, "centers differ from those that the indices give");

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

std::string text_line(ModelLexer& lexer, std::string_view key) {
  lexer.keyword(key);
  std::string value = lexer.rest_of_line();
  lexer.end_line();
  return value;
}

template <class Row>
void read_reals(ModelLexer& lexer, std::string_view what, Row&& row) {
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(row.size()); ++i) row[i] = lexer.real(what);
}

Eigen::VectorXd read_vector(ModelLexer& lexer, std::string_view key, Eigen::Index n, bool positive) {
  Eigen::VectorXd values(n);
  lexer.keyword(key);
  read_reals(lexer, key, values);
  if (positive && !(values.array() > 0).all()) lexer.refuse(std::string(key) + " must be positive", "");
  lexer.end_line();
  return values;
}

std::int32_t read_count(ModelLexer& lexer, std::string_view key, std::int64_t low = 0) {
  lexer.keyword(key);
  const std::int32_t n = lexer.count(key, low);
  lexer.end_line();
  return n;
}

std::int32_t read_node(ModelLexer& lexer, const Model& model, std::int32_t& previous) {
  const std::int32_t node = lexer.integer("node number", 0, model.n_mesh_nodes - 1);
  if (node <= previous) lexer.refuse("node numbers must ascend", std::to_string(node));
  return previous = node;
}

void read_network(ModelLexer& lexer, const Model& model, RbfNetwork& net, std::string_view key) {
  const bool deforms = key == "deformation";
  const std::int32_t n = read_count(lexer, key);
  const Eigen::Index n_inputs = deforms ? 6 : 3;
  net.input_center = read_vector(lexer, "input_center", n_inputs, false);
  net.input_half_range = read_vector(lexer, "input_half_range", n_inputs, true);
  net.output_center = read_vector(lexer, "output_center", 3, false);
  net.output_half_range = read_vector(lexer, "output_half_range", 3, true);
  net.spread = read_vector(lexer, "spread", 1, true)[0];
  if (net.spread < smallest_spread || net.spread > largest_spread)
    lexer.refuse("spread is out of range 1e-6 ... 1e6", "");
  net.bias = read_vector(lexer, "bias", 3, false);
  net.weights.resize(n, 3);
  for (std::int32_t i = 0; i < n; ++i) {
    net.center_displacement.push_back(
        lexer.integer("displacement of a center", 0, model.displacements.rows() - 1));
    if (deforms)
      net.center_output.push_back(
          lexer.integer("output node of a center", 0, model.output_points.rows() - 1));
    read_reals(lexer, "weight", net.weights.row(i));
    lexer.end_line();
  }
  fill_centers(model, net);
  if (!net.centers.allFinite()) lexer.refuse("a scaled center is not finite", "");
}

/// The text between first and last line, checked for magic, version, completeness and checksum in this order.
std::string_view checked_body(std::string_view text, const std::string& source) {
  const std::string first = std::string(magic) + " " + std::to_string(version) + "\n";
  const auto refuse = [&](const char* what, std::string value, const char* remedy) {
    throw input_error(source + ": " + what, std::move(value), remedy);
  };
  if (text.substr(0, first.size()) != first) {
    if (!text.empty() && text.size() < first.size() && first.compare(0, text.size(), text) == 0) {
      refuse("model file is truncated", std::to_string(text.size()) + " bytes", "copy it again");
    }
    if (text.substr(0, magic.size() + 1) != std::string(magic) + " ") {
      refuse("not a phynness model", std::string(text.substr(0, 20)),
             "name a model.txt or the directory that holds it");
    }
    const std::string line(text.substr(0, std::min(text.find('\n'), std::size_t{40})));
    if (!line.empty() && line.back() == '\r') {
      refuse("line endings of the model file were changed", "CR LF", "copy it again in binary mode");
    }
    refuse("model file has another version", line,
           "train again with this version, or use the version that wrote it");
  }
  if (text.size() < first.size() + checksum_line_length || text.back() != '\n' ||
      text.substr(text.size() - checksum_line_length, 9) != "checksum ") {
    refuse("model file is truncated",
           std::to_string(text.size()) + " bytes without a checksum line at the end", "copy it again");
  }
  const std::size_t end = text.size() - checksum_line_length;
  Fnv1a64 hash;
  hash.add(text.substr(0, end));
  const std::string_view stored = text.substr(end + 9, 16);
  if (stored != hash.hex()) {
    refuse("model file is corrupted: its checksum differs",
           std::string(stored) + " stored, " + hash.hex() + " computed",
           "copy it again; it cannot be edited by hand");
  }
  return text.substr(0, end);
}

void read_active_node(ModelLexer& lexer, const Model& model, ActiveNodeModel& node, std::int32_t& previous) {
  lexer.keyword("node");
  node.node = read_node(lexer, model, previous);
  lexer.end_line();
  lexer.keyword("point");
  read_reals(lexer, "point", node.point);
  lexer.end_line();
  const std::int32_t n_prescribed = read_count(lexer, "prescribed", 1);
  std::int32_t previous_prescribed = -1;
  for (std::int32_t i = 0; i < n_prescribed; ++i) {
    node.prescribed.push_back(read_node(lexer, model, previous_prescribed));
    node.prescribed_weight.push_back(lexer.real("weight of a prescribed node"));
    if (!(std::abs(node.prescribed_weight.back()) <= 1))
      lexer.refuse("weight of a prescribed node is beyond 1", "");
    lexer.end_line();
  }
  lexer.keyword("incomplete");
  node.n_incomplete = lexer.integer("incomplete", 0, static_cast<std::int64_t>(model.directions.size()));
  lexer.end_line();
  lexer.keyword("trained_depth");
  lexer.end_line();
  for (std::size_t i = 0; i < model.directions.size(); ++i) {
    node.trained_depth_m.push_back(lexer.real("trained depth"));
    if (node.trained_depth_m.back() < 0) lexer.refuse("trained depth is negative", "");
    lexer.end_line();
  }
  read_network(lexer, model, node.force, "force");
  read_network(lexer, model, node.deformation, "deformation");
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

std::string write_model_text(const Model& model) {
  require(model.family == Family::rbfn, "only the family rbfn has a text format so far");
  require(model.output_points.rows() == static_cast<Eigen::Index>(model.output.size()),
          "output_points does not fit output");
  require(!model.directions.empty() && model.displacements.rows() > 0 &&
              model.displacements.rows() % static_cast<Eigen::Index>(model.directions.size()) == 0,
          "displacements are not directions x increments");
  ModelEmitter w;
  w.word(magic).integer(version).end();
  w.word("family").word("rbfn").end();
  w.text("title", model.title);
  w.text("software", model.software_version);
  w.text("mesh_hash", model.mesh_hash);
  w.text("physics_hash", model.physics_hash);
  w.word("max_displacement_m").real(model.max_displacement_m).end();
  w.word("mesh_nodes").integer(model.n_mesh_nodes).end();
  w.word("directions").integer(static_cast<std::int64_t>(model.directions.size())).end();
  for (const Vec3& e : model.directions) w.reals(e).end();
  w.word("displacements").integer(model.displacements.rows()).end();
  for (Eigen::Index i = 0; i < model.displacements.rows(); ++i) w.reals(model.displacements.row(i)).end();
  w.word("fixed").integer(static_cast<std::int64_t>(model.fixed.size())).end();
  for (const std::int32_t node : model.fixed) w.integer(node).end();
  w.word("output").integer(static_cast<std::int64_t>(model.output.size())).end();
  for (std::size_t i = 0; i < model.output.size(); ++i) {
    w.integer(model.output[i]).reals(model.output_points.row(static_cast<Eigen::Index>(i))).end();
  }
  w.word("active").integer(static_cast<std::int64_t>(model.nodes.size())).end();
  for (const ActiveNodeModel& node : model.nodes) {
    require(node.prescribed.size() == node.prescribed_weight.size(),
            "prescribed_weight does not fit prescribed");
    require(node.trained_depth_m.size() == model.directions.size(),
            "trained_depth_m does not fit directions");
    w.word("node").integer(node.node).end();
    w.word("point").reals(node.point).end();
    w.word("prescribed").integer(static_cast<std::int64_t>(node.prescribed.size())).end();
    for (std::size_t i = 0; i < node.prescribed.size(); ++i) {
      w.integer(node.prescribed[i]).real(node.prescribed_weight[i]).end();
    }
    w.word("incomplete").integer(node.n_incomplete).end();
    w.word("trained_depth").end();
    for (const double depth : node.trained_depth_m) w.real(depth).end();
    write_network(w, model, node.force, "force");
    write_network(w, model, node.deformation, "deformation");
  }
  Fnv1a64 hash;
  hash.add(w.out());
  w.word("checksum").word(hash.hex()).end();
  return std::move(w.out());
}

Model read_model_text(const std::string& text, const std::string& source_name) {
  ModelLexer lexer(checked_body(text, source_name), source_name);
  Model model;
  lexer.keyword(magic);
  lexer.integer("version", version, version);
  lexer.end_line();
  const std::string family = text_line(lexer, "family");
  if (family != "rbfn") lexer.refuse("family of the model is not known to this version", family);
  model.title = text_line(lexer, "title");
  model.software_version = text_line(lexer, "software");
  model.mesh_hash = text_line(lexer, "mesh_hash");
  model.physics_hash = text_line(lexer, "physics_hash");
  model.max_displacement_m = read_vector(lexer, "max_displacement_m", 1, true)[0];
  lexer.keyword("mesh_nodes");
  model.n_mesh_nodes = lexer.integer("mesh_nodes", 1, std::numeric_limits<std::int32_t>::max());
  lexer.end_line();
  model.directions.resize(read_count(lexer, "directions", 1));
  for (Vec3& e : model.directions) {
    read_reals(lexer, "direction", e);
    lexer.end_line();
  }
  const std::int32_t n_displacements = read_count(lexer, "displacements", 1);
  if (n_displacements % static_cast<std::int32_t>(model.directions.size()) != 0) {
    lexer.refuse("displacements must be a multiple of directions", std::to_string(n_displacements));
  }
  model.displacements.resize(n_displacements, 3);
  for (std::int32_t i = 0; i < n_displacements; ++i) {
    read_reals(lexer, "displacement", model.displacements.row(i));
    lexer.end_line();
  }
  model.fixed.resize(read_count(lexer, "fixed"));
  std::int32_t previous = -1;
  for (std::int32_t& node : model.fixed) {
    node = read_node(lexer, model, previous);
    lexer.end_line();
  }
  model.output.resize(read_count(lexer, "output"));
  model.output_points.resize(static_cast<Eigen::Index>(model.output.size()), 3);
  previous = -1;
  for (std::size_t i = 0; i < model.output.size(); ++i) {
    model.output[i] = read_node(lexer, model, previous);
    read_reals(lexer, "coordinate", model.output_points.row(static_cast<Eigen::Index>(i)));
    lexer.end_line();
  }
  const std::int32_t n_active = read_count(lexer, "active");
  previous = -1;
  for (std::int32_t i = 0; i < n_active; ++i)
    read_active_node(lexer, model, model.nodes.emplace_back(), previous);
  if (!lexer.at_end()) lexer.refuse("text after the last active node", "");
  return model;
}

}  // namespace phynness
