// The paper's cases, each given by a scene. A case is available if its scene exists.
#pragma once

#include <phynness/studies/measurements.hpp>
#include <string>
#include <vector>

namespace phynness {

struct PaperCase {
  std::string id;  ///< identifier in --cases, and name of the folder
  std::string title;
  std::string scene;    ///< file in the folder of scenes
  std::string element;  ///< replaces that of the scene; empty: not changed
  bool linear = false;  ///< three unit responses instead of networks
  bool two_tools = false;
  bool liver = true;  ///< column of Table 1
};
const std::vector<PaperCase>& paper_cases();

/// The text of the scene that a study solves: that of the distribution with another element, and with `quick` with a
/// coarser mesh and fewer increments. Comments are kept. @throws Error if a key that is to be changed is missing
std::string case_scene(const PaperCase& of, std::string text, bool quick);

StudySizes study_sizes(bool quick);
/// Description of what is reduced in a quick study.
std::string quick_words();

}  // namespace phynness
