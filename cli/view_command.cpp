#include <fmt/core.h>

#include <algorithm>
#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/pages/pages.hpp>
#include <tuple>

#include "command_files.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "streams.hpp"

namespace phynness::cli::view_command {
namespace {

struct Options {
  std::filesystem::path model, output;
  std::optional<std::filesystem::path> database, errors;
};

/// JSON without trailing digits that no picture shows: 6 significant digits are 1e-6 of a force.
std::string short_number(double x) { return fmt::format("{:.6g}", x); }

/// A stored direction of a node up to its first increment without a result, as an object of web/view/src/page_data.ts.
std::string ray_json(std::int32_t node, const Vec3& direction, const Ray& ray, const std::vector<double>& depths) {
  std::string depth, force;
  for (std::size_t i = 0; i < ray.status.size() && ray.status[i] == Status::converged; ++i) {
    const char* comma = i > 0 ? "," : "";
    depth += comma + short_number(depths[i]);
    force +=
        fmt::format("{}[{:.6g},{:.6g},{:.6g}]", comma, ray.force[3 * i], ray.force[3 * i + 1], ray.force[3 * i + 2]);
  }
  if (depth.empty()) return {};
  return fmt::format(R"({{"node":{},"direction":[{:.6g},{:.6g},{:.6g}],"depth_m":[{}],"force_N":[{}]}})", node,
                     direction[0], direction[1], direction[2], depth, force);
}

std::string rays_json(const Database& database) {
  const auto& header = database.header();
  std::string all;
  for (std::size_t a = 0; a < header.sets.active.size(); ++a)
    for (const Ray& ray : database.rays(static_cast<std::int32_t>(a))) {
      const auto& direction = header.directions[static_cast<std::size_t>(ray.direction)];
      const auto one = ray_json(header.sets.active[a], direction, ray, header.magnitudes_m);
      if (one.empty()) continue;
      if (!all.empty()) all += ",\n";
      all += one;
    }
  return "[" + all + "]";
}

Error wrong_errors(const std::filesystem::path& file, const std::string& why) {
  return input_error("the errors of the nodes cannot be read", file.string() + ": " + why,
                     "give the file that phynness validate --json wrote for this model");
}

bool is_active(const Model& model, std::int64_t node) {
  return std::any_of(model.nodes.begin(), model.nodes.end(), [&](const auto& one) { return one.node == node; });
}

/// @throws Error (input) unless the file holds the hashes of this model and its mesh, and errors of the whole model
void require_same_model(const std::filesystem::path& file, const json& whole, const LoadedModel& loaded) {
  const auto given = [&](const char* key) {
    const auto found = whole.find(key);
    return found != whole.end() && found->is_string() ? found->get<std::string>() : std::string("none");
  };
  for (const auto& [key, name, own] :
       {std::tuple{"mesh_hash", "mesh", loaded.model().mesh_hash}, {"model_hash", "model", loaded.hash()}})
    if (given(key) != own)
      throw wrong_errors(
          file, fmt::format("it belongs to another {}, {} = {}, of this model {}", name, key, given(key), own));
  const auto level = whole.value(json::json_pointer("/conditions/level"), json());
  if (level != loaded.data().level())
    throw wrong_errors(file, fmt::format("its errors are those of level {} of the model, the page shows level {}",
                                         level.dump(), loaded.data().level()));
}

/// The mean errors by node from a file of `validate --json`.
json errors_json(const std::filesystem::path& file, const LoadedModel& loaded) {
  const InputFile about{"the file of errors", "give the file that phynness validate --json wrote", 1ULL << 30};
  const auto whole = json::parse(read_input_file(file, about), nullptr, false);
  if (!whole.is_object()) throw wrong_errors(file, "it contains no JSON object");
  const auto by_node = whole.find("by_node");
  if (by_node == whole.end() || !by_node->is_object()) throw wrong_errors(file, "it has no by_node");
  require_same_model(file, whole, loaded);
  constexpr double largest = 1e6;  // times the largest response: such a file is damaged
  const auto check_error = [&](const json& node, const json& error) {
    if (!(error.is_number() && error.get<double>() >= 0 && error.get<double>() <= largest))
      throw wrong_errors(
          file, fmt::format("the error {} of node {} is no number from 0 to {:g}", error.dump(), node.dump(), largest));
  };
  json known{{"nodes", json::array()},
             {"force_error", json::array()},
             {"displacement_error", json::array()},
             {"unit", "fraction"},
             {"source", file.filename().string()}};
  const auto list = [&](const char* key) -> const json& {
    const auto found = by_node->find(key);
    if (found == by_node->end() || !found->is_array()) throw wrong_errors(file, fmt::format("by_node has no {}", key));
    return *found;
  };
  const json &nodes = list("nodes"), &force = list("force_error"), &displacement = list("displacement_error");
  for (const auto& [key, values] : by_node->items())
    if (values.size() != nodes.size())
      throw wrong_errors(file,
                         fmt::format("by_node has {} nodes, but {} numbers in {}", nodes.size(), values.size(), key));
  const auto probed = whole.value(json::json_pointer("/conditions/nodes"), json::array());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!nodes[i].is_number_integer() || !is_active(loaded.model(), nodes[i].get<std::int64_t>()))
      throw wrong_errors(file, "node " + nodes[i].dump() + " is no active node of the model");
    if (std::find(probed.begin(), probed.end(), nodes[i]) == probed.end())
      throw wrong_errors(file, "node " + nodes[i].dump() + " is none of those that it says were probed");
    if (std::find(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(i), nodes[i]) !=
        nodes.begin() + static_cast<std::ptrdiff_t>(i))
      throw wrong_errors(file, "node " + nodes[i].dump() + " is given twice");
    if (force[i].is_null() || displacement[i].is_null()) continue;  // nothing was solved there
    check_error(nodes[i], force[i]);
    check_error(nodes[i], displacement[i]);
    known["nodes"].push_back(nodes[i]);
    known["force_error"].push_back(force[i]);
    known["displacement_error"].push_back(displacement[i]);
  }
  return known;
}

std::string page_json(const Options& options, const LoadedModel& loaded) {
  const auto text = [](const std::string& words) {
    return json(words).dump(-1, ' ', false, json::error_handler_t::replace);
  };
  std::string page = R"({"format":"phynness view 1","model":)" + text(loaded.text());
  if (options.errors) page += ",\n\"validation\":" + errors_json(*options.errors, loaded).dump();
  if (options.database) {
    const auto database = Database::open(*options.database);
    const auto& header = database.header();
    if (header.mesh_hash != loaded.model().mesh_hash)
      throw input_error(
          "the database belongs to another mesh than the model",
          options.database->string() + ": hash " + header.mesh_hash + ", model " + loaded.model().mesh_hash,
          "give the database from which the model was trained");
    page += ",\n\"scene_title\":" + text(header.scene_name) + ",\n\"rays\":" + rays_json(database);
  }
  return page + "}";
}

void run(const Options& options) {
  const auto page = embedded_page("view.html");
  if (!page) throw input_error("this build has no page", "phynness view", missing_pages_remedy());
  const LoadedModel loaded(options.model);
  if (loaded.model().surface.rows() == 0)
    throw input_error("the model has no surface, and nothing can be drawn", options.model.string(),
                      "train it again with output nodes, so that model.txt contains triangles");
  const auto whole = page_with_data(*page, page_json(options, loaded));
  write_text_file(options.output, whole);
  print_result("{}: {}, of which {} are the page and its runtime\n", options.output.string(),
               bytes(static_cast<double>(whole.size())), bytes(static_cast<double>(page->size())));
  print_result("Open it in a browser. It needs no network and no server.\n");
}

}  // namespace

void add(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand(
      "view",
      "Write a page on which the model can be touched: one HTML file with the model and the runtime inside, which any\n"
      "browser opens without a network");
  add_path(*command, "MODEL_DIR", options->model, InputKind::whole, "directory with model.txt and mesh.txt")
      ->required();
  add_path(*command, "--database", options->database, InputKind::whole,
           "database.h5 of the model; the page then shows the stored finite element forces beside the model's");
  add_path(*command, "--errors", options->errors, InputKind::whole,
           "file of validate --json; the page then shows the errors on the surface");
  add_path(*command, "-o,--output", options->output, OutputKind::file, "HTML file to write")->required();
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli::view_command
