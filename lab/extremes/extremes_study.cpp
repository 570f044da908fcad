// Behaviour at extreme parameters: docs/extremes.md. Usage: tools/study-extremes [SECTION ...]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "exit_status.hpp"
#include "sections.hpp"

namespace {

using namespace phynness;
using namespace phynness::extremes;

const std::vector<std::pair<std::string, void (*)(const SolverSession&)>> sections = {
    {"incompressibility", incompressibility},
    {"displacements", displacements},
    {"origin", origin},
    {"slivers", slivers},
    {"rest", rest},
    {"far-models", far_models},
    {"extrapolation", extrapolation},
    {"missing", missing},
    {"float32", floats},
    {"overfitting", overfitting},
    {"tools", tools}};

int run(int argc, char** argv) {
  std::vector<std::string> wanted, names;
  for (const auto& [section, work] : sections) names.push_back(section);
  CLI::App app{"Behaviour at extreme parameters (docs/extremes.md)"};
  app.add_option("SECTION", wanted, "tables to compute (default: all)")->check(CLI::IsMember(names));
  CLI11_PARSE(app, argc, argv);
  const SolverSession session;
  for (const auto& [section, work] : sections)
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), section) != wanted.end()) {
      work(session);
      std::fflush(stdout);
    }
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return phynness::bench::exit_status(run, argc, argv); }
