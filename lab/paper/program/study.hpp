// The parts of the study of the paper.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <phynness/studies/cases.hpp>
#include <phynness/studies/report.hpp>
#include <string>

namespace phynness::cli {

/// Settings of a study.
struct StudyRun {
  std::filesystem::path scenes, output;
  int ranks = 2;
  bool quick = false;
  StudySizes sizes;
};

/// Adds the options of the study, and the function that runs it after the command line was parsed.
void add_paper_study(CLI::App& app);

/// Runs all stages of a case that need their own process: mesh, database, models, their validation, measurements.
/// Results of the same scene that exist already are kept.
/// @param how_far  returns the number of the case and the time; called before each stage
/// @throws Error  also (input) if the folder contains a case of another scene
void run_case(const StudyRun& run, const PaperCase& of, const std::function<std::string()>& how_far);

/// True if run_case() has finished in this folder with these sizes.
bool is_finished(const StudyRun& run, const PaperCase& of);

/// The results of run_case(), with times measured now.
CaseResult read_case(const StudyRun& run, const PaperCase& of);

/// The folder of a case, with its scene.
std::filesystem::path case_folder(const StudyRun& run, const PaperCase& of);

/// Measures the case in a folder and writes measured.json there; run_case() starts it, with mpirun if there are several
/// ranks.
void measure_folder(const std::filesystem::path& folder);

}  // namespace phynness::cli
