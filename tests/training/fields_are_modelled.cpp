// Claims: family modal models the fields of a database: it reproduces the training data, is accurate between the
// directions, and has the kink of a norm or the flat minimum of a quadratic form at rest, because of the terms that are
// even in the displacement. Other families have no fields.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/training/training.hpp>

#include "../messages.hpp"
#include "small_responses.hpp"

namespace phynness::test {
namespace {

/// A norm and a quadratic form in d that depend on place and, a little, on the sign of d, as fields of a body do.
double value(const DatabaseHeader& header, int field, std::int32_t active, int o, const Eigen::Vector3d& d) {
  const Eigen::Vector3d touched = header.mesh.nodes.row(header.sets.active[static_cast<std::size_t>(active)]);
  const Eigen::Vector3d x = header.mesh.nodes.row(o).transpose() - touched;
  const double near = 1 / (1 + x.squaredNorm() / 4e-4);
  const Eigen::Vector3d e = x.normalized().array().isNaN().select(Eigen::Vector3d(0, 0, 1), x.normalized());
  const double form = (d.squaredNorm() + 3 * std::pow(e.dot(d), 2)) * (1 + 10 * d[2]);
  return field == 0 ? 5e4 * near * std::sqrt(form) : 2e6 * near * near * form;
}

DatabaseHeader header_with_fields() {
  auto header = small_header(8);
  header.fields = {Field::von_mises_stress, Field::energy_density};
  return header;
}

ResponseSource with_fields(const DatabaseHeader& header) {
  auto source = source_of(header);
  source.rays = [&header](std::int32_t active) {
    auto rays = small_rays(header, active);
    for (std::size_t k = 0; k < rays.size(); ++k)
      for (int f = 0; f < 2; ++f) {
        auto& values = rays[k].fields.emplace_back();
        for (const double magnitude : header.magnitudes_m)
          for (int o = 0; o < n_nodes; ++o)
            values.push_back(
                value(header, f, active, o, magnitude * Eigen::Vector3d::Map(header.directions[k].data())));
      }
    return rays;
  };
  return source;
}

/// At x = d / R.
Eigen::VectorXd evaluate(const Model& model, const ActiveNodeModel& node, std::size_t f, const Eigen::Vector3d& x) {
  const auto& field = model.fields[f];
  return (field.scale * modal_values(model, field.modes, node.fields[f], x, field.degree)).cwiseMax(0);
}

/// Mean over nodes, active nodes and the given displacements of |model - field|, over the field's largest
/// value there.
double error(const Model& model, const DatabaseHeader& header, std::size_t f, const std::vector<Eigen::Vector3d>& ds) {
  double sum = 0;
  int n = 0;
  for (std::size_t at = 0; at < model.nodes.size(); ++at) {
    std::int32_t active = 0;
    while (header.sets.active[static_cast<std::size_t>(active)] != model.nodes[at].node) ++active;
    double largest = 0, of_node = 0;
    for (const auto& d : ds) {
      const auto said = evaluate(model, model.nodes[at], f, d / model.max_displacement_m);
      for (int o = 0; o < n_nodes; ++o) {
        const double expected = value(header, static_cast<int>(f), active, o, d);
        largest = std::max(largest, expected);
        of_node += std::abs(said[o] - expected) / n_nodes;
      }
    }
    sum += of_node / largest / static_cast<double>(ds.size());
    ++n;
  }
  return sum / n;
}

std::vector<Eigen::Vector3d> between_the_directions(double depth) {
  return {depth * Eigen::Vector3d(0.3, 0.2, -0.9).normalized(), depth * Eigen::Vector3d(-0.7, 0.1, 0.4).normalized(),
          depth * Eigen::Vector3d(0.1, -0.8, 0.3).normalized(), depth * Eigen::Vector3d(0.5, 0.9, 0.2).normalized()};
}

TEST(ModalFields, RepeatTheFieldsAndKeepTheirShapeAtRest) {
  const auto header = header_with_fields();
  TrainingReport report;
  const Model model = train(with_fields(header), modal_spec(), report);
  ASSERT_EQ(model.fields.size(), 2u);
  ASSERT_EQ(report.modal.fields.size(), 2u);
  std::vector<Eigen::Vector3d> trained;
  for (Eigen::Index i = 0; i < model.displacements.rows(); ++i)
    trained.push_back(model.displacements.row(i).transpose());
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_EQ(model.fields[f].name, name(header.fields[f]));
    EXPECT_EQ(model.fields[f].degree, degree(header.fields[f]));
    const auto& q = report.modal.fields[f];
    const double mean = error(model, header, f, trained);
    // What it says bounds what it does, by the triangle inequality: cutting at 0 only helps.
    EXPECT_LE(mean, (q.truncation + q.regression) * (1 + 1e-9));
    EXPECT_LT(mean, 0.01);
    EXPECT_LT(error(model, header, f, between_the_directions(0.009)), 0.01);
    // Far inside the first increment (a thirtieth of it) there are no data: the even terms carry the degree.
    // The asymmetry of the fields is 0.1 % there; what is asked is a fifth of the largest value at that very
    // depth, which a function without them misses by all of it: see below.
    EXPECT_LT(error(model, header, f, between_the_directions(1e-4)), 0.2) << f;
  }
}

TEST(ModalFields, NeedTermsThatAreEven) {
  // The same modes with amplitudes that have kernels and linear terms only, on a norm.
  const auto header = header_with_fields();
  const auto tables = training_tables(header);
  const auto rays = with_fields(header).rays(1);
  TrainingReport report;
  const Model model = train(with_fields(header), modal_spec(), report);
  for (const int f : {0, 1}) {
    const auto values = field_modes(tables, rays, static_cast<std::size_t>(f), 1, 12);
    const SharedModes shared{scaled_table(shared_basis({values}, 12, 1)), model.shared.centers, model.shared.shape};
    const auto with = fit_modal(tables, shared, values, 0, f + 1), without = fit_modal(tables, shared, values, 0);
    EXPECT_LT(with.regression_error, 0.5 * without.regression_error) << f;
  }
}

TEST(ModalFields, DoNotDependOnThreads) {
  const auto header = header_with_fields();
  TrainingReport report;
  const auto one = write_model_text(train(with_fields(header), modal_spec(), report, {}, 1));
  EXPECT_EQ(write_model_text(train(with_fields(header), modal_spec(), report, {}, 3)), one);
}

TEST(ModalFields, AreAbsentElsewhere) {
  const auto header = header_with_fields();
  TrainingReport report;
  EXPECT_TRUE(train(with_fields(header), small_spec(), report).fields.empty());
  auto forces_only = modal_spec();
  forces_only.modes = 0;
  const Model model = train(with_fields(header), forces_only, report);
  EXPECT_TRUE(model.fields.empty());
  EXPECT_TRUE(model.nodes.front().fields.empty());
}

TEST(ModalFields, ThatAreNotFiniteAreRefused) {
  const auto header = header_with_fields();
  auto source = with_fields(header);
  const auto good = source.rays;
  source.rays = [&](std::int32_t active) {
    auto rays = good(active);
    rays[3].fields[1][7] = std::numeric_limits<double>::quiet_NaN();
    return rays;
  };
  TrainingReport report;
  expect_names(error_of([&] { train(source, modal_spec(), report); }), {"field that is not finite"});
}

}  // namespace
}  // namespace phynness::test
