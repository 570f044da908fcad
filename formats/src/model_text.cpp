// model.txt: writer and reader. The grammar is formats/model.md; the two halves below follow it section by
// section; model_response.cpp holds what depends on the family.
#include <algorithm>
#include <cmath>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/model.hpp>

#include "model_emitter.hpp"
#include "model_lexer.hpp"
#include "model_response.hpp"

namespace phynness {
namespace {

constexpr std::string_view magic = "phynness-model";
constexpr std::int64_t version = 2;
constexpr std::size_t checksum_line_length = sizeof("checksum 0123456789abcdef\n") - 1;

std::string text_line(ModelLexer& lexer, std::string_view key) {
  lexer.keyword(key);
  std::string value = lexer.rest_of_line();
  lexer.end_line();
  return value;
}

std::int32_t read_node(ModelLexer& lexer, const Model& model, std::int32_t& previous) {
  const std::int32_t node = lexer.integer("node number", 0, model.n_mesh_nodes - 1);
  if (node <= previous) lexer.refuse("node numbers must ascend", std::to_string(node));
  return previous = node;
}

/// Whether the model knows where the node is.
bool has_place(const Model& model, std::int32_t node) {
  return std::binary_search(model.output.begin(), model.output.end(), node) ||
         std::binary_search(model.fixed.begin(), model.fixed.end(), node);
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

template <class Point>
void read_point(ModelLexer& lexer, std::string_view what, Point&& point) {
  lexer.reals(what, point);
  for (int k = 0; k < 3; ++k) {
    if (!(std::abs(point[k]) <= largest_coordinate)) lexer.refuse(std::string(what) + " is beyond 1e30 m", "");
  }
}

void read_active_node(ModelLexer& lexer, const Model& model, ActiveNodeModel& node, std::int32_t& previous) {
  lexer.keyword("node");
  node.node = read_node(lexer, model, previous);
  lexer.end_line();
  lexer.keyword("point");
  read_point(lexer, "point", node.point);
  lexer.end_line();
  const std::int32_t n_prescribed = lexer.count_line("prescribed", 1);
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
  read_response(lexer, model, node);
  read_level_responses(lexer, model, node);
}

}  // namespace

std::string write_model_text(const Model& model) {
  require_writable(model.output_points.rows() == static_cast<Eigen::Index>(model.output.size()),
                   "output_points does not fit output");
  require_writable(model.fixed_points.rows() == static_cast<Eigen::Index>(model.fixed.size()),
                   "fixed_points does not fit fixed");
  const auto far = [](const auto& points) { return (points.array().abs() > largest_coordinate).any(); };
  require_writable(!far(model.output_points) && !far(model.fixed_points), "a coordinate is beyond 1e30 m");
  require_writable(!model.directions.empty() && model.displacements.rows() > 0 &&
                       model.displacements.rows() % static_cast<Eigen::Index>(model.directions.size()) == 0,
                   "displacements are not directions x increments");
  ModelEmitter w;
  w.word(magic).integer(version).end();
  w.word("family").word(name(model.family)).end();
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
  for (std::size_t i = 0; i < model.fixed.size(); ++i)
    w.integer(model.fixed[i]).reals(model.fixed_points.row(static_cast<Eigen::Index>(i))).end();
  w.word("output").integer(static_cast<std::int64_t>(model.output.size())).end();
  for (std::size_t i = 0; i < model.output.size(); ++i) {
    w.integer(model.output[i]).reals(model.output_points.row(static_cast<Eigen::Index>(i))).end();
  }
  w.word("surface").integer(model.surface.rows()).end();
  for (Eigen::Index t = 0; t < model.surface.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      require_writable(has_place(model, model.surface(t, k)), "a corner of the surface is neither output nor fixed");
      w.integer(model.surface(t, k));
    }
    w.end();
  }
  write_shared(w, model);
  write_fields(w, model);
  write_levels(w, model);
  w.word("active").integer(static_cast<std::int64_t>(model.nodes.size())).end();
  for (const ActiveNodeModel& node : model.nodes) {
    require_writable(node.prescribed.size() == node.prescribed_weight.size(),
                     "prescribed_weight does not fit prescribed");
    require_writable(node.trained_depth_m.size() == model.directions.size(),
                     "trained_depth_m does not fit directions");
    w.word("node").integer(node.node).end();
    require_writable(!far(Eigen::Map<const Eigen::Vector3d>(node.point.data())), "a point is beyond 1e30 m");
    w.word("point").reals(node.point).end();
    w.word("prescribed").integer(static_cast<std::int64_t>(node.prescribed.size())).end();
    for (std::size_t i = 0; i < node.prescribed.size(); ++i) {
      w.integer(node.prescribed[i]).real(node.prescribed_weight[i]).end();
    }
    w.word("incomplete").integer(node.n_incomplete).end();
    w.word("trained_depth").end();
    for (const double depth : node.trained_depth_m) w.real(depth).end();
    write_response(w, model, node);
    write_level_responses(w, model, node);
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
  if (family == name(Family::linear)) {
    model.family = Family::linear;
  } else if (family == name(Family::modal)) {
    model.family = Family::modal;
  } else if (family != name(Family::rbfn)) {
    lexer.refuse("family of the model is not known to this version", family);
  }
  model.title = text_line(lexer, "title");
  model.software_version = text_line(lexer, "software");
  model.mesh_hash = text_line(lexer, "mesh_hash");
  model.physics_hash = text_line(lexer, "physics_hash");
  model.max_displacement_m = lexer.vector_line("max_displacement_m", 1, true)[0];
  lexer.keyword("mesh_nodes");
  model.n_mesh_nodes = lexer.integer("mesh_nodes", 1, std::numeric_limits<std::int32_t>::max());
  lexer.end_line();
  model.directions.resize(lexer.count_line("directions", 1));
  for (Vec3& e : model.directions) {
    lexer.reals("direction", e);
    lexer.end_line();
  }
  const std::int32_t n_displacements = lexer.count_line("displacements", 1);
  if (n_displacements % static_cast<std::int32_t>(model.directions.size()) != 0) {
    lexer.refuse("displacements must be a multiple of directions", std::to_string(n_displacements));
  }
  model.displacements.resize(n_displacements, 3);
  for (std::int32_t i = 0; i < n_displacements; ++i) {
    lexer.reals("displacement", model.displacements.row(i));
    lexer.end_line();
  }
  model.fixed.resize(lexer.count_line("fixed"));
  std::int32_t previous = -1;
  model.fixed_points.resize(static_cast<Eigen::Index>(model.fixed.size()), 3);
  for (std::size_t i = 0; i < model.fixed.size(); ++i) {
    model.fixed[i] = read_node(lexer, model, previous);
    read_point(lexer, "coordinate", model.fixed_points.row(static_cast<Eigen::Index>(i)));
    lexer.end_line();
  }
  model.output.resize(lexer.count_line("output"));
  model.output_points.resize(static_cast<Eigen::Index>(model.output.size()), 3);
  previous = -1;
  for (std::size_t i = 0; i < model.output.size(); ++i) {
    model.output[i] = read_node(lexer, model, previous);
    read_point(lexer, "coordinate", model.output_points.row(static_cast<Eigen::Index>(i)));
    lexer.end_line();
  }
  model.surface.resize(lexer.count_line("surface"), 3);
  for (Eigen::Index t = 0; t < model.surface.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t node = lexer.integer("corner", 0, model.n_mesh_nodes - 1);
      if (!has_place(model, node))
        lexer.refuse("a corner of the surface is neither output nor fixed", std::to_string(node));
      model.surface(t, k) = node;
    }
    lexer.end_line();
  }
  read_shared(lexer, model);
  read_fields(lexer, model);
  read_levels(lexer, model);
  const std::int32_t n_active = lexer.count_line("active");
  previous = -1;
  for (std::int32_t i = 0; i < n_active; ++i)
    read_active_node(lexer, model, model.nodes.emplace_back(), previous);
  if (!lexer.at_end()) lexer.refuse("text after the last active node", "");
  return model;
}

}  // namespace phynness
