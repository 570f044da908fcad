// Reading and writing of model.txt by the grammar of models (phynness/schema/model_grammar.hpp; formats/model.md).
#include <algorithm>
#include <cmath>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/model.hpp>

#include "model_reader.hpp"
#include "model_writer.hpp"

namespace phynness {
namespace {

/// The text between first and last line.
std::string_view checked_body(std::string_view text, const std::string& source) {
  std::size_t length = text.size(), wrong_byte = 0;
  const int status = schema::check_envelope(text.data(), length, wrong_byte);
  if (status == PHN_OK) return text.substr(0, length);
  const auto refuse = [&](const char* what, std::string value, const char* remedy) {
    throw input_error(source + ": " + what, std::move(value), remedy);
  };
  if (status == PHN_ERROR_NOT_A_MODEL)
    refuse("not a phynness model", std::string(text.substr(0, 20)), "give a model.txt or a model directory");
  if (status == PHN_ERROR_VERSION) {
    const std::string line(text.substr(0, std::min(text.find('\n'), std::size_t{40})));
    if (!line.empty() && line.back() == '\r')
      refuse("the line endings of the model file were changed", "CR LF", "copy it again in binary mode");
    refuse("the model file has another version", line,
           "train again with this version, or use the version that wrote it");
  }
  if (status == PHN_ERROR_TRUNCATED)
    refuse("the model file is truncated", std::to_string(text.size()) + " bytes without a checksum line at the end",
           "copy it again");
  Fnv1a64 hash;
  const std::size_t end = text.size() - schema::checksum_line_length;
  hash.add(text.substr(0, end));
  refuse("the model file is corrupted: its checksum is wrong",
         std::string(text.substr(end + 9, 16)) + " instead of " + hash.hex(),
         "copy it again; it cannot be edited by hand");
  return {};
}

/// Checks that data of a model that the text does not contain follow from its numbers.
void require_consistent(const Model& model) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) ModelWriter::refuse(what);
  };
  require(model.levels.empty() || schema::traits(model.family).has_levels, "levels in a family that has none");
  require(model.bounds.empty() || !schema::traits(model.family).proportional, "bounds in a family that is exact");
  require(model.fields.empty() || schema::traits(model.family).has_modes, "fields in a family that has none");
  const auto symmetric = [&](const Eigen::Matrix3d& k) {
    require(k.hasNaN() || k == k.transpose(), "stiffness is not symmetric");
  };
  const auto centers = [&](const RbfNetwork& net) {
    if (net.input_center.size() == 0) return;
    RbfNetwork again = net;
    fill_centers(model, again);
    require(again.centers.rows() == net.centers.rows() && again.centers.cols() == net.centers.cols() &&
                again.centers == net.centers,
            "centers differ from those that the indices give");
  };
  for (const auto& node : model.nodes) {
    symmetric(node.linear.stiffness);
    symmetric(node.conservative.stiffness);
    for (const auto& level : node.levels) symmetric(level.conservative.stiffness);
    centers(node.force);
    centers(node.deformation);
  }
}

}  // namespace

void ModelReader::family(Family& family) {
  const auto found = _in.rest_of_line();
  const std::string_view word{found.begin, found.length()};
  for (std::uint32_t f = 0; f < schema::n_families; ++f)
    if (word == schema::family_words[f]) {
      family = static_cast<Family>(f);
      return;
    }
  refuse("the family of the model is unknown to this version", word);
}

std::string write_model_text(const Model& model) {
  require_consistent(model);
  ModelWriter writer;
  writer.out() = schema::model_first_line;
  schema::model(writer, model);
  Fnv1a64 hash;
  hash.add(writer.out());
  return std::move(writer.out()) + "checksum " + hash.hex() + "\n";
}

Model read_model_text(const std::string& text, const std::string& source_name) {
  Model model;
  ModelReader reader(checked_body(text, source_name), source_name, model);
  schema::model(reader, model);
  reader.require_end();
  return model;
}

void fill_centers(const Model& model, RbfNetwork& net) {
  const auto n = static_cast<Eigen::Index>(net.center_displacement.size());
  net.centers.resize(n, net.input_center.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < net.input_center.size(); ++k) {
      const double value =
          k < 3 ? model.displacements(net.center_displacement[i], k) : model.output_points(net.center_output[i], k - 3);
      net.centers(i, k) = (value - net.input_center[k]) / net.input_half_range[k];
    }
  }
}

ScaledTable scaled_table(const Eigen::MatrixXd& values) {
  ScaledTable table;
  table.scale = Eigen::VectorXd::Zero(values.cols());
  table.entries.setZero(values.rows(), values.cols());
  for (Eigen::Index c = 0; c < values.cols() && values.rows() > 0; ++c) {
    const double largest = values.col(c).cwiseAbs().maxCoeff();
    table.scale[c] = largest / schema::largest_table_entry;
    if (!(table.scale[c] > 0)) continue;
    for (Eigen::Index r = 0; r < values.rows(); ++r)
      table.entries(r, c) = static_cast<std::int16_t>(std::lround(values(r, c) / table.scale[c]));
  }
  return table;
}

}  // namespace phynness
