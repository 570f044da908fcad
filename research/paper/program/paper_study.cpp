// Runs the paper's cases and compares the tables and figures with those of the paper.
#include <fmt/core.h>

#include <chrono>
#include <fstream>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/version.hpp>
#include <phynness/pages/report.hpp>
#include <phynness/studies/json.hpp>
#include <phynness/validation/report.hpp>
#include <sstream>
#include <thread>

#include "child_process.hpp"
#include "command_files.hpp"
#include "console.hpp"
#include "streams.hpp"
#include "study.hpp"

namespace phynness::cli {
namespace {

struct Options {
  StudyRun run;
  std::optional<std::string> cases;
  std::filesystem::path sizes_file;
};

std::string machine() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  std::string line, model = "unknown processor";
  while (std::getline(cpuinfo, line))
    if (line.starts_with("model name")) {
      model = line.substr(line.find(':') + 2);
      break;
    }
  return fmt::format("{}, {} cores", model, std::thread::hardware_concurrency());
}

/// The folder of scenes: the given folder, or that of the source.
std::filesystem::path scenes_folder(const std::filesystem::path& asked) {
  if (!asked.empty()) {
    if (!std::filesystem::is_directory(asked))
      throw input_error("the folder of scenes does not exist", asked.string(),
                        "give with --scenes the folder of liver_case1.toml ...");
    return asked;
  }
  return PHYNNESS_SCENES;
}

/// @throws Error if a word is not the name of a case
std::vector<PaperCase> chosen_cases(const std::string& words) {
  std::vector<PaperCase> chosen;
  std::stringstream in(words);
  std::string names;
  for (const auto& one : paper_cases()) names += (names.empty() ? "" : ", ") + one.id;
  if (words.empty()) throw input_error("no case is named", "--cases \"\"", "give with --cases some of " + names);
  for (std::string word; std::getline(in, word, ',');) {
    word.erase(0, word.find_first_not_of(' '));
    word.erase(word.find_last_not_of(' ') + 1);
    bool found = false;
    for (const auto& one : paper_cases())
      if (one.id == word) {
        chosen.push_back(one);
        found = true;
      }
    if (!found)
      throw input_error("the study has no such case", word.empty() ? "an empty word" : word,
                        "give with --cases some of " + names);
  }
  return chosen;
}

/// Finished cases are part of the page even if --cases does not select them.
void declare_files(const StudyRun& run) {
  for (const auto& one : paper_cases()) {
    declare_input("--scenes", run.scenes / one.scene);
    declare_output("--output", case_folder(run, one), PathKind::folder);
  }
  for (const char* name : {"paper.json", "paper.html"}) declare_output("--output", run.output / name);
}

void run_study(Options options) {
  report::require_page();
  auto& run = options.run;
  const auto start = std::chrono::steady_clock::now();
  install_stop_handler(false);
  run.scenes = scenes_folder(run.scenes);
  run.sizes = study_sizes(run.quick);
  if (!options.sizes_file.empty()) {
    std::ifstream in(options.sizes_file);
    auto sizes = nlohmann::json(run.sizes);
    const auto changes = nlohmann::json::parse(in, nullptr, false);
    if (!changes.is_object()) throw input_error("no JSON object", options.sizes_file.string(), "see StudySizes");
    sizes.update(changes);
    run.sizes = sizes.get<StudySizes>();
  }
  if (run.output.empty()) run.output = run.quick ? "out/paper-quick" : "out/paper";
  const auto cases = options.cases ? chosen_cases(*options.cases) : paper_cases();
  declare_files(run);
  std::error_code code;
  std::filesystem::create_directories(run.output, code);
  if (code)
    throw input_error("cannot make the output folder", run.output.string() + ", " + code.message(),
                      "give -o a folder that can be written");
  prepare_environment(run.ranks);

  PaperStudy study;
  study.quick = run.quick;
  study.software = software_version();
  study.machine = machine();
  std::vector<PaperCase> done;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (!std::filesystem::exists(run.scenes / cases[i].scene)) continue;
    run_case(run, cases[i], [&] {
      return fmt::format("case {} of {}, {} since the start", i + 1, cases.size(),
                         duration(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()));
    });
    done.push_back(cases[i]);
  }
  print_result("\n== times and report\n");
  for (const auto& one : paper_cases()) {
    const bool ran = std::any_of(done.begin(), done.end(), [&](const auto& d) { return d.id == one.id; });
    // A case that was finished before is part of the page even if it is not selected.
    if (ran || is_finished(run, one)) {
      study.cases.push_back(read_case(run, one));
      continue;
    }
    CaseResult missing;
    missing.of = one;
    missing.missing =
        std::filesystem::exists(run.scenes / one.scene) ? "not asked for (--cases)" : "there is no scenes/" + one.scene;
    study.cases.push_back(std::move(missing));
  }
  study.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto report = paper_report(study);
  write_text_file(run.output / "paper.json", to_json(study, report).dump(1) + "\n");
  write_text_file(run.output / "paper.html", html_page(study, report));
  for (const auto& row : report.summary) {
    print_result("{:<62}", row.front());
    for (std::size_t c = 1; c < row.size(); ++c) print_result(" | {}", row[c]);
    print_result("\n");
  }
  print_result("{} -> {}, {}\n", duration(study.seconds), (run.output / "paper.html").string(),
               (run.output / "paper.json").string());
}

}  // namespace

void add_paper_study(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_flag("--quick", options->run.quick, "coarser meshes and fewer points, for some minutes instead of an hour");
  add_path(app, "-o,--output", options->run.output, PathKind::folder,
           "folder, in which an interrupted study is resumed (default: out/paper or out/paper-quick)");
  app.add_option("--cases", options->cases, "some of 1,2,3,3-p1-p1,4 (default: all whose scene exists)");
  app.add_option("--scenes", options->run.scenes, "folder with the scenes of the cases");
  app.add_option("--ranks", options->run.ranks, "number of processes of the finite element stages (mpirun)")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  add_path(app, "--sizes", options->sizes_file, PathKind::input, "JSON file with other numbers of measurements")
      ->group("");
  auto folder = std::make_shared<std::filesystem::path>();
  auto* measure = app.add_subcommand("measure", "Measures one case; started by the study")->group("");
  add_path(*measure, "FOLDER", *folder, PathKind::folder, "folder of the case")->required();
  app.callback([options, folder, measure] {
    if (measure->parsed())
      measure_folder(*folder);
    else
      run_study(*options);
  });
}

}  // namespace phynness::cli
