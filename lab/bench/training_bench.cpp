// Training time of the networks of the paper's liver (Table 1 there: 280 s each, including data extraction). Usage:
// phynness_training_bench [--json FILE] [--threads N] [--nodes N]
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <phynness/training/node_training.hpp>
#include <phynness/training/training.hpp>
#include <string>
#include <thread>

#include "generated_responses.hpp"
#include "textbook_training.hpp"

namespace {

using namespace phynness;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Eigen::MatrixXd scaled(const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd result = columns;
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const double low = columns.col(k).minCoeff(), high = columns.col(k).maxCoeff();
    result.col(k) = ((columns.col(k).array() - (low + high) / 2) / ((high - low) / 2)).matrix();
  }
  return result;
}

/// One deformation and one force network by the textbook loop; returns seconds on one core.
double textbook_seconds(const TrainingTables& tables, const std::vector<Ray>& rays, std::int32_t node,
                        const TrainingSpec& spec, double& mse) {
  const auto inputs_of = [](const NetworkPoints& points) {
    Eigen::MatrixXd inputs(points.outputs.rows(), points.n_inputs());
    for (Eigen::Index p = 0; p < inputs.rows(); ++p) {
      inputs.row(p).head(3) = points.displacements.row(points.displacement[p]);
      if (!points.place.empty()) inputs.row(p).tail(3) = points.places.row(points.place[p]);
    }
    return inputs;
  };
  const auto start = std::chrono::steady_clock::now();
  const NetworkPoints deformation = deformation_points(tables, rays, {{node}, {1.0}}, node, spec.samples, spec.seed);
  mse = bench::textbook_training(scaled(inputs_of(deformation)), scaled(deformation.outputs), spec.deformation_neurons,
                                 spec.deformation_spread);
  const NetworkPoints force = force_points(tables, rays);
  bench::textbook_training(scaled(inputs_of(force)), scaled(force.outputs), spec.force_neurons, spec.force_spread);
  return seconds_since(start);
}

}  // namespace

int main(int argc, char** argv) {
  std::string json;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  int n_active = bench::n_nodes;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (i + 1 < argc && option == "--json") {
      json = argv[++i];
    } else if (i + 1 < argc && option == "--threads") {
      threads = std::atoi(argv[++i]);
    } else if (i + 1 < argc && option == "--nodes") {
      n_active = std::min(std::max(std::atoi(argv[++i]), 1), n_active);
    } else {
      std::fprintf(stderr, "usage: %s [--json FILE] [--threads N] [--nodes N]\n", argv[0]);
      return 2;
    }
  }
  DatabaseHeader header = bench::liver_sized_header();
  const auto all = static_cast<double>(bench::n_nodes);
  header.sets.active.resize(n_active);
  header.sets.tools = single_nodes(header.sets.active);
  TrainingSpec spec;
  spec.family = Family::rbfn;
  spec.force_spread = 1.4;
  const ResponseSource source{&header, [&](std::int32_t a) { return bench::rays(header, a); }, {}, "generated"};

  TrainingReport report;
  const Model model = train(source, spec, report, {}, threads);
  const double seconds = report.seconds * all / n_active;
  const double text_mb = static_cast<double>(write_model_text(model).size()) / 1e6 * all / n_active;

  const TrainingTables tables = training_tables(header);
  constexpr int n_textbook = 4;
  double textbook = 0, textbook_mse = 0;
  for (int i = 0; i < n_textbook; ++i) {
    const std::int32_t active = i * n_active / n_textbook;
    double mse = 0;
    textbook +=
        textbook_seconds(tables, bench::rays(header, active), header.sets.active[active], spec, mse) / n_textbook;
    textbook_mse += mse / n_textbook;
  }
  // Networks are independent, so that the textbook loop is assumed to use the same threads at full efficiency.
  const double textbook_all = textbook * all / threads;

  std::printf("training, %d active nodes%s, %d threads\n", n_active,
              n_active < bench::n_nodes ? " (extrapolated to 486)" : "", threads);
  std::printf(
      "  data: generated Kelvin-like nonlinear fields in memory (no file read), 26 directions x 6 "
      "increments,\n"
      "        %d output nodes, %d samples; %d deformation and %d force neurons per node\n",
      bench::n_nodes - 1, spec.samples, spec.deformation_neurons, spec.force_neurons);
  std::printf("  %-46s %10.2f s\n", "486 nodes, both networks", seconds);
  std::printf("  %-46s %10.2f s   (measured for %d nodes in one thread: %.0f ms per node; extrapolated)\n",
              "textbook loop on the same threads", textbook_all, n_textbook, 1e3 * textbook);
  std::printf("  %-46s %10.1f\n", "ratio", textbook_all / seconds);
  std::printf("  %-46s %10.2e (textbook %.2e)\n", "mean deformation MSE, scaled", report.mean_deformation_mse,
              textbook_mse);
  std::printf("  %-46s %10.2f MB\n", "model.txt", text_mb);

  if (!json.empty()) {
    std::ofstream out(json);
    out << "{\"seconds_486_networks_200_neurons\": " << seconds
        << ", \"seconds_486_networks_textbook_extrapolated\": " << textbook_all
        << ", \"ratio_to_textbook\": " << textbook_all / seconds << ", \"threads\": " << threads
        << ", \"nodes_measured\": " << n_active << ", \"deformation_neurons\": " << spec.deformation_neurons
        << ", \"force_neurons\": " << spec.force_neurons << ", \"samples\": " << spec.samples
        << ", \"mean_deformation_mse\": " << report.mean_deformation_mse << ", \"model_text_MB\": " << text_mb << "}\n";
    if (!out) {
      std::fprintf(stderr, "writing failed: %s\n", json.c_str());
      return 1;
    }
  }
  return 0;
}
