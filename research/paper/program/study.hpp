// The parts of the study of the paper.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <phynness/studies/cases.hpp>
#include <phynness/studies/report.hpp>
#include <string>

namespace phynness::cli {

/// How a study is run.
struct StudyRun {
  std::filesystem::path scenes, output;
  int ranks = 2;
  bool quick = false;
  StudySizes sizes;
};

/// Options of the study, and what it does when the line has been parsed.
void add_paper_study(CLI::App& app);

/// Everything about one case that needs a process of its own: mesh, database, models, their validation, the
/// measurements. What is there already, of the same scene, is kept.
/// @param how_far  which of all cases, and the time: asked before each stage
/// @throws Error  also (input) if the folder holds the case of another scene
void run_case(const StudyRun& run, const PaperCase& of, const std::function<std::string()>& how_far);

/// True if run_case() has ended there, for these sizes.
bool is_finished(const StudyRun& run, const PaperCase& of);

/// What run_case() left, with times taken now.
CaseResult read_case(const StudyRun& run, const PaperCase& of);

/// The scene that a case is made from, in its folder.
std::filesystem::path case_folder(const StudyRun& run, const PaperCase& of);

/// What run_case() starts, perhaps under mpirun: measures the case in a folder -> measured.json in it.
void measure_folder(const std::filesystem::path& folder);

}  // namespace phynness::cli
