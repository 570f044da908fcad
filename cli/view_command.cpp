#include <phynness/formats/input_file.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/pages/pages.hpp>
#include <phynness/validation/named_organ.hpp>
#include <tuple>

#include "commands.hpp"

namespace phynness::cli::view_command {
namespace {

struct Options {
  std::filesystem::path model, output;
  OptionalPath database, errors, body;
};

/// Rounds to six significant digits, which are sufficient for a picture.
double rounded(double x) {
  double y = x;
  parse_number(fmt::format("{:.6g}", x), y);
  return y;
}
Vec3 rounded(const Vec3& v) { return {rounded(v[0]), rounded(v[1]), rounded(v[2])}; }

/// Every stored ray up to its first unsolved increment, in the format of web/view/src/page_data.ts.
json rays_json(const Database& database) {
  const auto& header = database.header();
  json all = json::array();
  for (std::size_t a = 0; a < header.sets.active.size(); ++a)
    for (const Ray& ray : database.rays(static_cast<std::int32_t>(a))) {
      std::vector<double> depth_m;
      std::vector<Vec3> force_N;
      for (std::size_t i = 0; i < ray.status.size(); ++i) {
        if (ray.status[i] != Status::converged) break;
        depth_m.push_back(rounded(header.magnitudes_m[i]));
        force_N.push_back(rounded(Vec3{ray.force[3 * i], ray.force[3 * i + 1], ray.force[3 * i + 2]}));
      }
      if (depth_m.empty()) continue;
      const auto& direction = header.directions[static_cast<std::size_t>(ray.direction)];
      all.push_back(record("node", header.sets.active[a], "direction", rounded(direction), "depth_m", depth_m,
                           "force_N", force_N));
    }
  return all;
}

Error error_of_file(const std::filesystem::path& file, const std::string& why) {
  return input_error("the errors of the nodes cannot be read", file.string() + ": " + why,
                     "give the file that phynness validate --json wrote for this model");
}

/// @throws Error (input) unless the file holds the hashes of this model and its mesh, and errors of the whole model
void require_same_model(const std::filesystem::path& file, const json& whole, const NamedOrgan& loaded) {
  for (const auto& [key, name, own] :
       {std::tuple{"mesh_hash", "mesh", loaded.model().mesh_hash}, {"model_hash", "model", loaded.hash()}}) {
    const auto found = whole.value(key, json());
    const auto stored_hash = found.is_string() ? found.get<std::string>() : "none";
    if (stored_hash != own)
      throw error_of_file(
          file, fmt::format("it belongs to another {}, {} = {}, of this model {}", name, key, stored_hash, own));
  }
  const auto level = whole.value(json::json_pointer("/conditions/level"), json());
  if (level != loaded.level())
    throw error_of_file(file, fmt::format("its errors are those of level {} of the model, the page shows level {}",
                                          level.dump(), loaded.level()));
}

/// Reads the mean errors of the nodes from a file of `validate --json`.
json errors_json(const std::filesystem::path& file, const NamedOrgan& loaded) {
  const InputFile about{"the file of errors", "give the file that phynness validate --json wrote", 1ULL << 30};
  const auto whole = json::parse(read_input_file(file, about), nullptr, false);
  if (!whole.is_object()) throw error_of_file(file, "it contains no JSON object");
  const auto by_node = whole.find("by_node");
  if (by_node == whole.end() || !by_node->is_object()) throw error_of_file(file, "it has no by_node");
  require_same_model(file, whole, loaded);
  json mean_errors{{"nodes", json::array()}, {"force_error", json::array()}, {"displacement_error", json::array()}};
  try {
    for (std::size_t i = 0; i < by_node->at("nodes").size(); ++i) {
      if (by_node->at("force_error").at(i).is_null() || by_node->at("displacement_error").at(i).is_null()) continue;
      mean_errors["nodes"].push_back(by_node->at("nodes").at(i).get<std::int32_t>());
      for (const char* key : {"force_error", "displacement_error"})
        mean_errors[key].push_back(by_node->at(key).at(i).get<double>());
    }
  } catch (const json::exception& error) {
    throw error_of_file(file, problem_of(error));
  }
  return mean_errors;
}

std::string page_json(const Options& options, const NamedOrgan& loaded, const std::optional<NamedOrgan>& body) {
  json page = record("format", "phynness view 1", "model", loaded.text());
  if (body) page["body"] = body->text();
  if (options.errors) page["validation"] = errors_json(*options.errors, loaded);
  if (options.database) {
    const auto database = Database::open(*options.database);
    const auto& mesh_hash = database.header().mesh_hash;
    if (mesh_hash != loaded.model().mesh_hash)
      throw input_error("the database belongs to another mesh than the model",
                        options.database->string() + ": hash " + mesh_hash + ", model " + loaded.model().mesh_hash,
                        "give the database from which the model was trained");
    page["rays"] = rays_json(database);
  }
  return page.dump(-1, ' ', false, json::error_handler_t::replace);
}

void run(const Options& options) {
  const auto page = embedded_page();
  if (page.empty()) throw input_error("this build has no page", "phynness view", missing_pages_remedy());
  const NamedOrgan loaded(options.model);
  std::optional<NamedOrgan> body;
  if (options.body) body = loaded.body_on_same_mesh(*options.body);
  if (loaded.model().surface.rows() == 0)
    throw input_error("the model has no surface, and nothing can be drawn", options.model.string(),
                      "train it again with output nodes, so that model.txt contains triangles");
  const auto whole = page_with_data(page, page_json(options, loaded, body));
  write_text_file(options.output, whole);
  print_result("{}: {}, of which {} are the page and its runtime\n", options.output.string(), bytes(whole.size()),
               bytes(page.size()));
  print_result("Open it in a browser. It needs no network and no server.\n");
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] = add_command(
      app, "view",
      "Write a page on which the model can be touched: one HTML file with the model and the runtime inside, which any\n"
      "browser opens without a network",
      run);
  add_model(command, options.model);
  add_path(command, "--database", options.database, PathKind::input,
           "database.h5 of the model; the page then shows the stored finite element forces beside the model's");
  add_path(command, "--errors", options.errors, PathKind::input,
           "file of validate --json; the page then shows the errors on the surface");
  add_path(command, "--body", options.body, PathKind::input,
           "body.txt of reduce, which then answers two tools, and spheres");
  add_output(command, options.output, PathKind::file, "HTML file to write");
}

}  // namespace phynness::cli::view_command
