// The parts of the study of the paper that use the libraries; lab/paper/study.py runs them between commands of
// phynness.
//   phynness_paper_study measure FOLDER      measures the case in a folder, on the ranks of mpirun -> measured.json
//   phynness_paper_study time FOLDER         times and surfaces of its models -> times.json
//   phynness_paper_study page JSON HTML      a page of the blocks in a file
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/pages/report.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/studies/json.hpp>
#include <phynness/studies/measure.hpp>

#include "exit_status.hpp"

namespace {

using namespace phynness;
using nlohmann::json;
using std::filesystem::path;

constexpr int n_surface_levels = 4;  // the paper's Table 2

template <class Json = json>
Json read_json(const path& file) {
  std::ifstream in(file);
  const auto read = Json::parse(in, nullptr, false);
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
    std::optional<NamedOrgan> networks;
    if (std::filesystem::exists(folder / "networks/model.txt")) networks.emplace(folder / "networks");
    const auto measured = measure_case(
        session, read_scene(folder / "scene.toml"), database, networks ? &*networks : nullptr,
        NamedOrgan(folder / "ours"), settings.at("sizes").get<StudySizes>(), settings.at("two_tools").get<bool>(),
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

/// Rows of three numbers as lists.
template <class Matrix>
json rows(const Matrix& matrix) {
  json out = json::array();
  for (const auto& row : matrix.rowwise()) out.push_back({row[0], row[1], row[2]});
  return out;
}

/// Times of the models of a case whose networks have a surface, and its surfaces by level of subdivision.
void measure_times(const path& folder) {
  json out{{"samples", read_scene(folder / "scene.toml").training.samples}, {"surfaces", json::array()}};
  if (std::filesystem::exists(folder / "networks/model.txt")) {
    const NamedOrgan networks(folder / "networks"), ours(folder / "ours");
    if (networks.info().n_triangles > 0) {
      out["runtime"] = measure_runtime(networks, ours, n_surface_levels);
      for (int level = 0; level < n_surface_levels; ++level) {
        const auto shape = surface_at(networks, level);
        out["surfaces"].push_back({{"points", rows(shape.points)}, {"triangles", rows(shape.triangles)}});
      }
    }
  }
  write_text_file(folder / "times.json", out.dump());
}

int run(int argc, char** argv) {
  CLI::App app{"Measurements of the study of the paper (lab/study paper)"};
  path folder, page;
  auto* measuring = app.add_subcommand("measure", "measures the case in a folder");
  auto* timing = app.add_subcommand("time", "measures the times of its models");
  for (auto* command : {measuring, timing}) command->add_option("FOLDER", folder)->required();
  auto* writing = app.add_subcommand("page", "writes blocks as a page");
  writing->add_option("JSON", folder)->required();
  writing->add_option("HTML", page)->required();
  app.require_subcommand(1);
  CLI11_PARSE(app, argc, argv);
  if (measuring->parsed()) measure(folder);
  if (timing->parsed()) measure_times(folder);
  if (writing->parsed()) {
    const auto blocks = read_json<report::Json>(folder);
    write_text_file(page, report::page(blocks.at("title"), blocks.at("sections")));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return phynness::bench::exit_status(run, argc, argv); }
