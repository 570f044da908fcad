// Measurement of one case as a separate process, so that it can run under mpirun.
#include <fmt/core.h>

#include <fstream>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/studies/json.hpp>
#include <phynness/studies/measure.hpp>

#include "console.hpp"
#include "streams.hpp"
#include "study.hpp"

namespace phynness::cli {
namespace {

nlohmann::json read_json(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw input_error("a file of the study cannot be read", file.string(), "run tools/study-paper again");
  return nlohmann::json::parse(in);
}

std::filesystem::path part_file(const std::filesystem::path& folder, int rank) {
  return folder / fmt::format("measured-{}.json", rank);
}

}  // namespace

void measure_folder(const std::filesystem::path& folder) {
  install_stop_handler();
  const SolverSession session;
  session.together([&] {
    const auto settings = read_json(folder / "study.json");
    const Scene scene = read_scene(folder / "scene.toml");
    const auto database = Database::open(folder / "database.h5");
    const bool has_networks = std::filesystem::exists(folder / "networks" / "model.txt");
    std::optional<LoadedModel> networks;
    if (has_networks) networks.emplace(folder / "networks");
    const LoadedModel ours(folder / "ours");
    std::optional<Progress> progress;
    std::string doing;
    const auto measured = measure_case(
        session, scene, database, networks ? &*networks : nullptr, ours, settings.at("sizes").get<StudySizes>(),
        settings.at("two_tools").get<bool>(),
        [&](const std::string& what, std::int64_t done, std::int64_t total) {
          if (what != doing) progress.emplace(doing = what, what == "two tools" ? "pairs" : "rays");
          progress->update(done, total);
        },
        stop_requested);
    write_text_file(part_file(folder, session.rank()), nlohmann::json(measured).dump());
  });
  session.sum(0);  // all ranks have finished
  if (session.rank() != 0) return;
  std::vector<CaseMeasurements> parts;
  for (int rank = 0; rank < session.size(); ++rank)
    parts.push_back(read_json(part_file(folder, rank)).get<CaseMeasurements>());
  const auto all = merged(parts);
  nlohmann::json out{{"key", read_json(folder / "study.json").at("key")}, {"measured", all}};
  write_text_file(folder / "measured.json", out.dump());
  for (int rank = 0; rank < session.size(); ++rank) std::filesystem::remove(part_file(folder, rank));
  print_result("measured {} nodes and {} pairs of tools in {}\n", all.nodes.size(), all.pairs.size(),
               duration(all.seconds));
}

}  // namespace phynness::cli
