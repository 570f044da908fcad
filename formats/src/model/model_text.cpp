// Reading and writing of model.txt by the grammar of models (phynness/schema/model_grammar.hpp; formats/model.md).
#include <cmath>
#include <phynness/formats/model.hpp>

#include "text/text_lines_reader.hpp"
#include "text/text_lines_writer.hpp"

namespace phynness {
namespace {

class ModelReader : public TextLinesReader {
 public:
  ModelReader(std::string_view lines, const std::string& source, const Model& model)
      : TextLinesReader(lines, source,
                        "write the model again with `phynness train`; the format is described in formats/model.md"),
        _model(model) {}
  using ModelStores::done;
  void done(RbfNetwork& network) {
    fill_centers(_model, network);
    if (!network.centers.allFinite()) refuse("a scaled center is not finite", "");
  }

 private:
  const Model& _model;
};

/// Checks that data of a model that the text does not contain follow from its numbers.
void require_consistent(const Model& model) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) TextLinesWriter::refuse(what);
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
  for (const auto& point : model.linear_points) symmetric(point.stiffness);
  for (const auto& node : model.nodes) {
    symmetric(node.linear.stiffness);
    symmetric(node.conservative.stiffness);
    for (const auto& level : node.levels) symmetric(level.conservative.stiffness);
    centers(node.force);
    centers(node.deformation);
  }
}

}  // namespace

std::string write_model_text(const Model& model) {
  require_consistent(model);
  TextLinesWriter writer(schema::model_first_line);
  schema::model(writer, model);
  return writer.finished();
}

Model read_model_text(const std::string& text, const std::string& source_name) {
  Model model;
  ModelReader reader(checked_lines(schema::model_first_line, text, source_name, "model"), source_name, model);
  schema::model(reader, model);
  reader.require_end();
  return model;
}

void fill_centers(const Model& model, RbfNetwork& net) {
  const auto n = static_cast<Eigen::Index>(net.center_displacement.size());
  net.centers.resize(n, net.input_center.size());
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = 0; k < net.input_center.size(); ++k) {
      const double value =
          k < 3 ? model.displacements(net.center_displacement[i], k) : model.output_points(net.center_output[i], k - 3);
      net.centers(i, k) = (value - net.input_center[k]) / net.input_half_range[k];
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
