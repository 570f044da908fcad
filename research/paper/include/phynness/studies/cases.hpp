// The paper's cases: a scene each. A case is there as soon as its scene is.
#pragma once

#include <phynness/studies/measurements.hpp>
#include <string>
#include <vector>

namespace phynness {

struct PaperCase {
  std::string id;  ///< as --cases names it, and the folder's name
  std::string title;
  std::string scene;    ///< file in the folder of scenes
  std::string element;  ///< the scene's is changed to it; empty: as it stands
  bool linear = false;  ///< three unit responses instead of networks
  bool two_tools = false;
  bool liver = true;  ///< which column of Table 1
};
const std::vector<PaperCase>& paper_cases();

/// The scene that a study solves: the shipped one, the element changed, and with `quick` a coarser mesh and
/// fewer increments. Comments stay. @throws Error if a key to change is not there
std::string case_scene(const PaperCase& of, std::string text, bool quick);

StudySizes study_sizes(bool quick);
/// What is less in a quick study, in words.
std::string quick_words();

}  // namespace phynness
