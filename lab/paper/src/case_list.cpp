#include <fmt/core.h>

#include <phynness/formats/error.hpp>
#include <phynness/studies/cases.hpp>

namespace phynness {
namespace {

constexpr const char *quick_nodes = "150", *quick_drain_nodes = "70";
constexpr const char* quick_increments = "4";

/// Replaces the value of a key in a section and keeps comments. Returns false if the key is missing.
bool set_key(std::string& text, const std::string& section, const std::string& key, const std::string& value) {
  bool inside = false;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    if (line.starts_with("[")) inside = line.starts_with("[" + section + "]");
    if (inside && line.starts_with(key) && line.find_first_not_of(" \t", key.size()) == line.find('=')) {
      const auto comment = line.find('#');
      text.replace(at, end - at,
                   key + " = " + value + (comment == std::string::npos ? "" : "  " + line.substr(comment)));
      return true;
    }
    at = end + 1;
  }
  return false;
}

}  // namespace

const std::vector<PaperCase>& paper_cases() {
  static const std::vector<PaperCase> cases{
      {"1", "Case 1: liver, linear", "liver_case1.toml", "", true, false, true},
      {"2", "Case 2: liver, St. Venant-Kirchhoff", "liver_case2.toml", "", false, false, true},
      {"3", "Case 3: liver, neo-Hookean", "liver_case3.toml", "", false, true, true},
      {"3-p1-p1", "Case 3 without locking (p1-p1)", "liver_case3.toml", "p1-p1", false, true, true},
      {"4", "Case 4: Penrose drain, Mooney-Rivlin", "penrose_case4.toml", "", false, false, false}};
  return cases;
}

std::string case_scene(const PaperCase& of, std::string text, bool quick) {
  if (!of.element.empty() && !set_key(text, "solver", "element", '"' + of.element + '"'))
    throw input_error("a scene of the study names no element", of.scene, "give [solver] an element");
  if (quick) {
    set_key(text, "mesh", "target_nodes", of.liver ? quick_nodes : quick_drain_nodes);
    if (!of.linear) set_key(text, "probe", "increments", quick_increments);
  }
  return text;
}

StudySizes study_sizes(bool quick) {
  StudySizes sizes;
  if (!quick) return sizes;
  sizes.nodes = 5;
  sizes.probes_per_node = 8;
  sizes.neurons = {20, 50, 100, 200, 300};
  sizes.spreads = {0.375, 0.5, 0.75, 1.0, 1.5};
  sizes.samples = {500, 1000, 2000, 4000, 6000};
  sizes.force_neurons = {10, 20, 30, 40, 50, 60, 70, 80, 90};
  sizes.test_pairs = 1000;
  sizes.tool_pairs = 12;
  return sizes;
}

std::string quick_words() {
  const auto few = study_sizes(true), all = study_sizes(false);
  return fmt::format(
      "meshes of about {} nodes (drain: {}) and {} increments instead of the scenes', {} nodes with {} random "
      "directions each instead of {} with {}, {} sizes of networks instead of {}, {} test pairs instead of {}, {} "
      "pairs "
      "of tools instead of {}",
      quick_nodes, quick_drain_nodes, quick_increments, few.nodes, few.probes_per_node, all.nodes, all.probes_per_node,
      few.neurons.size(), all.neurons.size(), few.test_pairs, all.test_pairs, few.tool_pairs, all.tool_pairs);
}

}  // namespace phynness
