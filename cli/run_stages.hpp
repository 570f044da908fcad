// Which stages of `phynness run` an earlier run has finished, so that --resume makes only those again whose keys of the
// scene, or whose input, have changed.
#pragma once

#include <filesystem>
#include <map>
#include <phynness/formats/scene.hpp>
#include <string>

namespace phynness::cli {

class RunStages {
 public:
  /// @param same_rays  false if the database does not have all rays of the scene yet
  RunStages(const std::filesystem::path& folder, const Scene& scene, bool same_rays);

  /// Whether an earlier run has finished the stage, and nothing that it depends on has changed.
  bool has(const std::string& stage) const;
  /// Forgets a stage and those after it, and removes their files, so that what is in the folder belongs together.
  void redo(const std::string& stage);
  void finished(const std::string& stage);

 private:
  void write() const;

  std::filesystem::path _folder;
  std::map<std::string, std::string> _wanted, _finished;  ///< hash by stage
};

/// Of stages.json, in the folder of a run.
inline constexpr const char* begin_of_stages = "{\n  \"stages\": ";

}  // namespace phynness::cli
