#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <phynness/embedding/embedding.hpp>
#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/training/families.hpp>

#include "command_files.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "streams.hpp"

namespace phynness::cli::export_command {
namespace {

/// Queries that say how far an image is from the model, written or not.
constexpr std::size_t least_queries = 256;

struct Options {
  std::filesystem::path model, output;
  std::string name = "model";
  bool force_only = false, floats = false;
  std::size_t golden = 0;
  std::optional<std::filesystem::path> json_file;
};

void check_name(const std::string& name) {
  bool good = !name.empty() && !std::isdigit(static_cast<unsigned char>(name[0]));
  for (const char c : name)
    good = good && (c == '_' || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'));
  if (!good) throw input_error("a name in C consists of letters, digits and _", "--name " + name, "--name liver");
}

void check_output(const Options& options) {
  std::error_code code;
  if (std::filesystem::exists(options.output) && !std::filesystem::is_directory(options.output))
    throw input_error("the output is no directory", options.output.string(), "name a directory; it is made if absent");
  std::filesystem::create_directories(options.output, code);
  if (code)
    throw input_error("the output directory cannot be made", options.output.string() + ": " + code.message(),
                      "name a directory where you may write");
}

json golden_json(const GoldenQueries& queries, std::size_t n) {
  json all = json::array();
  for (std::size_t i = 0; i < n; ++i) {
    const auto& q = queries.query[i];
    all.push_back({{"node", q.node},
                   {"displacement", q.displacement_m},
                   {"force", q.force_N},
                   {"image_force", q.image_force_N},
                   {"status", q.status},
                   {"output", q.output},
                   {"deformation", q.deformation_m},
                   {"image_deformation", q.image_deformation_m}});
  }
  return all;
}

void run(const Options& options) {
  check_name(options.name);
  for (const auto* suffix : {".h", ".c", ".bin", "_golden.h", "_golden.c"})
    declare_output("--output", options.output / (options.name + suffix));
  if (options.json_file) {
    const auto folder = std::filesystem::absolute(*options.json_file).parent_path();
    if (!std::filesystem::is_directory(folder))
      throw input_error("there is no such folder", folder.string(), "make it first, or name another with --json");
  }
  const LoadedModel loaded(options.model);
  const Model& model = loaded.model();
  const bool deforms = !options.force_only && operations(model.family).has_deformation(model);
  const ModelImage image = model_image(model, {!deforms, options.floats});
  auto queries = golden_queries(loaded, image, std::max(options.golden, least_queries));
  const double force_deviation = queries.force_deviation, deformation_deviation = queries.deformation_deviation;
  const std::size_t n_measured = queries.query.size();
  queries.query.resize(options.golden);
  check_output(options);
  std::vector<std::pair<std::filesystem::path, std::string>> files;
  const auto write = [&](const std::string& suffix, const std::string& text) {
    files.emplace_back(options.output / (options.name + suffix), text);
  };
  const CSource source = c_source(image, model, options.name);
  write(".h", source.header);
  write(".c", source.source);
  write(".bin", std::string(reinterpret_cast<const char*>(image.bytes.data()), image.bytes.size()));
  if (options.golden > 0) {
    const CSource golden = c_source(queries, model, options.name);
    write("_golden.h", golden.header);
    write("_golden.c", golden.source);
  }
  write_text_files(files);
  print_result("{}: family {}, {} active nodes, {}, {}\n", (options.output / options.name).string(), name(model.family),
               image.n_active, deforms ? fmt::format("{} output nodes", image.n_output) : std::string("forces only"),
               options.floats ? "float" : "double");
  print_result("flash {}; RAM {} for a deformation, none for a force\n", bytes(static_cast<double>(image.bytes.size())),
               bytes(static_cast<double>(image.ram_bytes())));
  print_result("differs from the runtime by {:.2g} of the largest force", force_deviation);
  if (deforms) print_result(" and {:.2g} of the largest displacement", deformation_deviation);
  print_result(" at {} queries\n", n_measured);
  if (!model.fields.empty()) message("note: the model's fields are left out; images hold force and deformation\n");
  const double deviation = deforms ? std::max(force_deviation, deformation_deviation) : force_deviation;
  if (deviation > 1e-3)
    message(
        "warning: this model's terms cancel by too much: the image differs by {:.2g} of the largest answer\n"
        "  remedy: {}train it with --family modal or a smaller --spread\n",
        deviation, options.floats ? "export it without --float, or " : "");
  write_json(options.json_file, {{"family", name(model.family)},
                                 {"name", options.name},
                                 {"real_bytes", image.real_bytes()},
                                 {"image_bytes", image.bytes.size()},
                                 {"ram_bytes", image.ram_bytes()},
                                 {"active", image.n_active},
                                 {"output", image.n_output},
                                 {"force_deviation", force_deviation},
                                 {"deformation_deviation", deformation_deviation},
                                 {"golden", golden_json(queries, options.golden)}});
}

}  // namespace

void add(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand(
      "export",
      "Write a model as C source (NAME.h, NAME.c) and as a file (NAME.bin) that a device evaluates\n"
      "in place, in flash, with the functions of phynness/phynness_image.h; sizes are constants in NAME.h");
  add_path(*command, "MODEL_DIR", options->model, InputKind::whole, "directory with model.txt and mesh.txt")
      ->required();
  add_path(*command, "-o,--output", options->output, OutputKind::folder, "directory for the files; made if absent")
      ->required();
  command->add_option("--name", options->name, "of files and symbols; default: model");
  command->add_flag("--force-only", options->force_only, "leave the deformation out: far less flash");
  command->add_flag("--float", options->floats,
                    "numbers in float: half the flash, for processors without double precision");
  command
      ->add_option("--golden", options->golden,
                   "also write NAME_golden.h and .c: so many queries with the runtime's answers in double, "
                   "to compare a device with")
      ->check(CLI::Range(0, 100000));
  add_path(*command, "--json", options->json_file, OutputKind::file, "write sizes and golden queries for machines");
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli::export_command
