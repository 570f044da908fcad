// Time against numbers of neurons, centers and nodes with straight lines fitted to it, and a comparison with the limits
// of the processor. Usage: phynness_cost_lines [--plot FILE.html] [--json FILE]
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/pages/report.hpp>
#include <string>
#include <vector>

#include "exit_status.hpp"
#include "machine_limits.hpp"
#include "timed_model.hpp"

namespace {

using namespace phynness;

class Timed : public bench::TimedModel {
 public:
  explicit Timed(const Model& model) : TimedModel(write_model_text(model)) {}
  double force_ns() { return 1e3 * force_us(); }
  double prepared_us() {
    bench::check(data.prepare(node(0)));
    return deformation_us(node(0));
  }
};

/// Times of the runtime and, in family rbfn, of the plain loop.
struct Series {
  std::string name, axis, unit;
  std::vector<double> n, time, plain;

  /// Least squares with relative weights: constant and slope.
  std::array<double, 2> line() const {
    double s = 0, sx = 0, sxx = 0, sy = 0, sxy = 0;
    for (std::size_t i = 0; i < n.size(); ++i) {
      const double w = 1 / (time[i] * time[i]);
      s += w;
      sx += w * n[i];
      sxx += w * n[i] * n[i];
      sy += w * time[i];
      sxy += w * n[i] * time[i];
    }
    const double slope = (s * sxy - sx * sy) / (s * sxx - sx * sx);
    return {(sy - slope * sx) / s, slope};
  }
  double departure() const {
    const auto [constant, slope] = line();
    double largest = 0;
    for (std::size_t i = 0; i < n.size(); ++i)
      largest = std::max(largest, std::abs((constant + slope * n[i]) / time[i] - 1));
    return largest;
  }
  void print() const {
    const auto [constant, slope] = line();
    std::printf("%s\n", name.c_str());
    for (std::size_t i = 0; i < n.size(); ++i) {
      std::printf("  %6.0f %s %12.3f %s", n[i], axis.c_str(), time[i], unit.c_str());
      if (!plain.empty()) std::printf("   plain loop %12.3f, %.1f times", plain[i], plain[i] / time[i]);
      std::printf("\n");
    }
    std::printf("  line: %.3g + %.4g n %s, largest deviation %.0f %%\n", constant, slope, unit.c_str(),
                100 * departure());
    std::fflush(stdout);
  }
};

constexpr int n_own = 16, n_shared = 64, n_near = 30, n_centers = 78, n_neurons = 200, n_force_neurons = 100;

std::vector<Series> measure() {
  std::vector<Series> all;
  const std::vector<int> neurons = {16, 32, 64, 128, 256, 512}, nodes = {60, 122, 243, 486};
  const auto finish = [&](Series series) {
    series.print();
    all.push_back(std::move(series));
  };
  {
    Series force{"force, family rbfn", "neurons", "ns", {}, {}, {}};
    Series field{fmt::format("deformation of {} nodes, family rbfn", bench::n_output), "neurons", "us", {}, {}, {}};
    for (const int n : neurons) {
      Timed loaded(bench::networks_model(n, n, 1));
      force.n.push_back(n);
      force.time.push_back(loaded.force_ns());
      force.plain.push_back(1e3 * bench::plain_force_us(n));
      field.n.push_back(n);
      field.time.push_back(loaded.prepared_us());
      field.plain.push_back(bench::plain_deformation_us(n, bench::n_output));
    }
    finish(std::move(force));
    finish(std::move(field));
  }
  {
    Series field{fmt::format("deformation, family rbfn, {} neurons", n_neurons), "nodes", "us", {}, {}, {}};
    for (const int n : nodes) {
      field.n.push_back(n);
      field.time.push_back(Timed(bench::networks_model(n_neurons, n_neurons, 1, n)).prepared_us());
      field.plain.push_back(bench::plain_deformation_us(n_neurons, static_cast<std::size_t>(n)));
    }
    finish(std::move(field));
  }
  {
    Series force{"force, family modal", "centers", "ns", {}, {}, {}};
    // The additional center is at rest. With fewer than 32 centers a different kernel is used, with a different line.
    for (const int n : {47, 79, 111, 143}) {
      force.n.push_back(n + 1);
      force.time.push_back(Timed(bench::modal_model(n, n_shared, n_own, n_centers, n_near, 1)).force_ns());
    }
    finish(std::move(force));
  }
  {
    Series field{fmt::format("deformation, family modal, {} modes", n_own), "nodes", "us", {}, {}, {}};
    for (const int n : nodes) {
      field.n.push_back(n);
      field.time.push_back(
          Timed(bench::modal_model(n_centers, n_shared, n_own, n_centers, n_near, 1, n)).prepared_us());
    }
    finish(std::move(field));
  }
  return all;
}

/// Numbers of additions, multiplications, divisions and roots, without those for the choice of neurons.
struct Work {
  std::string what;
  double time_us, flops, bytes;
  bool single;
};

nlohmann::json compare_with_limits() {
  const bench::MachineLimits limits = bench::machine_limits();
  std::printf("this core: %.0f GFlop/s in double, %.0f in float, multiplications and additions not fused\n",
              limits.double_gflops, limits.float_gflops);
  Timed networks(bench::networks_model(n_force_neurons, n_neurons, 1));
  Timed modal(bench::modal_model(n_centers, n_shared, n_own, n_centers, n_near, 1));
  // A Gaussian needs 8 operations for the distance, 37 for its exponential (18 in float, where it is a power of two)
  // and 6 for three sums. A center of a force needs 9 for the distance, 2 for root and division, and 18 for the rest.
  const bool single = modal.model.info().precision_bits == 32;
  const double gaussian = single ? 26 : 45, bytes = single ? 4 : 8;
  constexpr double sums = 6, center = 29;
  constexpr double nodes = bench::n_output;
  const std::vector<Work> works = {
      {fmt::format("force, {} neurons", n_force_neurons), 1e-3 * networks.force_ns(),
       n_force_neurons * (gaussian + sums), n_force_neurons * 6 * bytes, single},
      {fmt::format("deformation {} x {}, rbfn", bench::n_output, n_neurons), networks.prepared_us(),
       nodes * n_neurons * sums + n_neurons * gaussian, nodes * n_neurons * bytes, single},
      {fmt::format("force, {} centers, modal", n_centers), 1e-3 * modal.force_ns(), (n_centers + 1) * center,
       (n_centers + 1) * 6 * bytes, single},
      {fmt::format("deformation {}, {} modes", bench::n_output, n_own), modal.prepared_us(),
       nodes * 3 * n_own * 2 + n_centers * (11 + 2 * n_own), nodes * 3 * n_own * 4, true}};
  std::printf("  %-28s %9s %9s %12s %16s\n", "", "us", "kflop", "of the peak", "of reading it");
  nlohmann::json json;
  json["double_gflops"] = limits.double_gflops;
  json["float_gflops"] = limits.float_gflops;
  for (const Work& work : works) {
    const double peak = work.single ? limits.float_gflops : limits.double_gflops;
    const double rate = bench::read_rate(static_cast<std::size_t>(work.bytes));
    const double arithmetic = 1e-3 * work.flops / peak, reading = 1e-3 * work.bytes / rate;
    std::printf("  %-28s %9.3f %9.1f %10.0f %% %7.0f %% of %.0f GB/s\n", work.what.c_str(), work.time_us,
                1e-3 * work.flops, 100 * arithmetic / work.time_us, 100 * reading / work.time_us, rate);
    json[work.what] = {
        {"us", work.time_us}, {"of_arithmetic", arithmetic / work.time_us}, {"of_reading", reading / work.time_us}};
  }
  return json;
}

void plot(const std::string& file, const std::vector<Series>& all) {
  report::Json charts = report::Json::array();
  for (const Series& series : all) {
    const auto [constant, slope] = series.line();
    report::Curve measured{"measured", "points", 0, {}}, line{"line", "line", 1, {{0, constant}}};
    for (std::size_t k = 0; k < series.n.size(); ++k) {
      measured.at.emplace_back(series.n[k], series.time[k]);
      line.at.emplace_back(series.n[k], constant + slope * series.n[k]);
    }
    charts.push_back(report::chart(series.name, series.axis, series.unit, {line, measured}));
  }
  write_text_file(file, report::page("Time of the runtime", {report::section("", {{{"charts", charts}}})}));
}

int run(int argc, char** argv) {
  CLI::App app("Time of the runtime against neurons, centers and nodes, and the limits of this core");
  std::string plot_file, json_file;
  app.add_option("--plot", plot_file, "draw the lines (HTML)");
  app.add_option("--json", json_file, "write the figures for machines");
  CLI11_PARSE(app, argc, argv);
  if (!plot_file.empty()) report::require_page();
  std::printf("one core, medians of processor time; arbitrary coefficients\n");
  const auto all = measure();
  auto json = compare_with_limits();
  for (const Series& series : all)
    json["lines"][series.name] = {{"n", series.n},
                                  {"time", series.time},
                                  {"unit", series.unit},
                                  {"plain", series.plain},
                                  {"departure", series.departure()}};
  if (!plot_file.empty()) plot(plot_file, all);
  if (!json_file.empty()) {
    std::ofstream out(json_file);
    out << json.dump(1) << '\n';
    if (!out.flush()) throw failure("writing failed", json_file, "look at the disk and the rights");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return bench::exit_status(run, argc, argv); }
