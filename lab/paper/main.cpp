// The parts of the study of the paper that use the libraries; lab/paper/study.py runs them between commands of
// phynness.
//   phynness_paper_study measure FOLDER             measures the case in a folder, on the ranks of mpirun ->
//   measured.json phynness_paper_study report STUDY.json FOLDER   measures times and writes paper.json and paper.html
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/studies/json.hpp>
#include <phynness/studies/measure.hpp>

#include "exit_status.hpp"

namespace {

using namespace phynness;
using nlohmann::json;
using std::filesystem::path;

constexpr int n_surface_levels = 4;  // the paper's Table 2

json read_json(const path& file) {
  std::ifstream in(file);
  const auto read = json::parse(in, nullptr, false);
  if (read.is_discarded())
    throw input_error("a file of the study cannot be read", file.string(), "remove it and run the study again");
  return read;
}

void measure(const path& folder) {
  const SolverSession session;
  const auto part = [&](int rank) { return folder / ("measured-" + std::to_string(rank) + ".json"); };
  session.together([&] {
    const auto settings = read_json(folder / "study.json");
    const auto database = Database::open(folder / "database.h5");
    std::optional<LoadedModel> networks;
    if (std::filesystem::exists(folder / "networks/model.txt")) networks.emplace(folder / "networks");
    const auto measured = measure_case(
        session, read_scene(folder / "scene.toml"), database, networks ? &*networks : nullptr,
        LoadedModel(folder / "ours"), settings.at("sizes").get<StudySizes>(), settings.at("two_tools").get<bool>(),
        [](const std::string& what, auto done, auto total) {
          std::fprintf(stderr, "\r%s: %ld of %ld ", what.c_str(), static_cast<long>(done), static_cast<long>(total));
        });
    write_text_file(part(session.rank()), json(measured).dump());
  });
  session.sum(0);  // all ranks have finished
  if (session.rank() != 0) return;
  std::vector<CaseMeasurements> parts;
  for (int rank = 0; rank < session.size(); ++rank) parts.push_back(read_json(part(rank)).get<CaseMeasurements>());
  write_text_file(folder / "measured.json", json(merged(parts)).dump());
  for (int rank = 0; rank < session.size(); ++rank) std::filesystem::remove(part(rank));
}

void add_measurements(CaseResult& result, const path& folder) {
  result.measured = read_json(folder / "measured.json").get<CaseMeasurements>();
  result.facts.samples = read_scene(folder / "scene.toml").training.samples;
  result.ours_errors = read_json(folder / "validate-ours.json");
  if (result.of.linear) return;
  result.networks_errors = read_json(folder / "validate-networks.json");
  const LoadedModel networks(folder / "networks"), ours(folder / "ours");
  if (networks.runtime().triangles().empty()) return;
  result.times = measure_runtime(networks, ours, n_surface_levels);
  for (int level = 0; level < n_surface_levels; ++level) result.surfaces.push_back(surface_at(networks, level));
}

void write_report(const path& file, const path& folder) {
  const auto in = read_json(file);
  PaperStudy study;
  in.at("less_than_full").get_to(study.less_than_full);
  in.at("software").get_to(study.software);
  in.at("machine").get_to(study.machine);
  in.at("seconds").get_to(study.seconds);
  for (const auto& entry : in.at("cases")) {
    auto& result = study.cases.emplace_back();
    entry.at("of").get_to(result.of);
    result.missing = entry.value("missing", "");
    if (!result.missing.empty()) continue;
    entry.at("facts").get_to(result.facts);
    add_measurements(result, folder / ("case-" + result.of.id));
  }
  const auto report = paper_report(study);
  write_text_file(folder / "paper.json", to_json(study, report).dump(1) + "\n");
  write_text_file(folder / "paper.html", html_page(study, report));
  for (const auto& row : report.summary) {
    std::printf("%-62s", row.front().c_str());
    for (std::size_t c = 1; c < row.size(); ++c) std::printf(" | %s", row[c].c_str());
    std::printf("\n");
  }
}

int run(int argc, char** argv) {
  CLI::App app{"Measurements and report of the study of the paper (lab/study paper)"};
  path folder, file;
  auto* measuring = app.add_subcommand("measure", "measures the case in a folder");
  measuring->add_option("FOLDER", folder)->required();
  auto* reporting = app.add_subcommand("report", "writes paper.json and paper.html into a folder");
  reporting->add_option("STUDY", file)->required();
  reporting->add_option("FOLDER", folder)->required();
  app.require_subcommand(1);
  CLI11_PARSE(app, argc, argv);
  if (measuring->parsed())
    measure(folder);
  else
    write_report(file, folder);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return phynness::bench::exit_status(run, argc, argv); }
