#include <algorithm>
#include <phynness/formats/image.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/training/families.hpp>
#include <phynness/validation/named_organ.hpp>

#include "commands.hpp"

namespace phynness::cli::export_command {
namespace {

/// Of a force and its bound on a Cortex-M; tests/embedded/firmware_agrees_with_the_host.sh measures that it is enough.
constexpr std::size_t most_stack_bytes = 3072;

struct Options {
  std::filesystem::path model, output;
  std::string name = "model";
  ImageOptions image;
  std::size_t golden = 0;
  OptionalPath json_file;
};

void check_name(const std::string& name) {
  constexpr std::size_t longest = 48;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto fits = [&](char c) { return c == '_' || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c); };
  if (name.empty() || name.size() > longest || is_digit(name[0]) || !std::ranges::all_of(name, fits))
    throw input_error(
        fmt::format("a name in C must consist of at most {} letters, digits and _, and not start with a digit",
                    longest),
        "--name " + name, "give for example --name liver");
}

json golden_json(const GoldenQueries& queries) {
  json all = json::array();
  for (const auto& q : queries.query)
    all.push_back(record("node", q.node, "point", q.point_m, "displacement", q.displacement_m, "force", q.force_N,
                         "image_force", q.image_force_N, "status", q.status, "output", q.output, "deformation",
                         q.deformation_m, "image_deformation", q.image_deformation_m));
  return all;
}

void run(const Options& options) {
  check_name(options.name);
  std::error_code code;
  if (std::filesystem::equivalent(options.output, options.model, code))
    throw input_error("--output is the folder of the model itself", options.output.string(), "give another folder");
  for (const auto* suffix : {".h", ".c", ".bin", "_golden.h", "_golden.c"})
    declare_output("--output", options.output / (options.name + suffix));
  const NamedOrgan loaded(options.model);
  const Model& model = loaded.model();
  ImageOptions kind = options.image;
  const bool deforms = !schema::traits(model.family).has_modes || sizes_of(model).modes > 0;
  kind.force_only = kind.force_only || model.output.empty() || !deforms;
  const ModelImage image = model_image(model, kind);
  const auto queries = golden_queries(loaded.model(), loaded.organ(), image, options.golden);
  make_folder(options.output);
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
  const json figures =
      record("family", name(model.family), "name", options.name, "real_bytes", image.real_bytes(), "image_bytes",
             image.bytes.size(), "ram_bytes", image.ram_bytes(), "active", image.n_active, "output", image.n_output,
             "triangles", image.n_triangles, "force_deviation", queries.force_deviation, "deformation_deviation",
             queries.deformation_deviation, "golden", golden_json(queries));
  write_each({[&] { write_text_files(files); }, [&] { write_json(options.json_file, figures); }});
  print_result("{}: family {}, {} active nodes, {}, {}\n", (options.output / options.name).string(), name(model.family),
               image.n_active, kind.force_only ? "forces only" : fmt::format("{} output nodes", image.n_output),
               kind.floats ? "float" : "double");
  if (image.n_triangles > 0) print_result("a tool at any place on {} triangles\n", image.n_triangles);
  print_result("flash {}; RAM {}less than {} of stack\n", bytes(image.bytes.size()),
               kind.force_only ? "" : bytes(image.ram_bytes()) + " for a deformation, ", bytes(most_stack_bytes));
  print_result("largest difference from the runtime: {:.2g} of the largest force", queries.force_deviation);
  if (!kind.force_only) print_result(" and {:.2g} of the largest displacement", queries.deformation_deviation);
  print_result(" at {} queries\n", queries.n_measured);
  if (!model.fields.empty())
    message("note: the model's fields are omitted; images contain force and deformation only\n");
  const double deviation = std::max(queries.force_deviation, kind.force_only ? 0 : queries.deformation_deviation);
  if (deviation > 1e-3)
    message(
        "warning: large terms of this model cancel each other: the image differs by {:.2g} of the largest response\n"
        "  remedy: {}train it with --family modal or smaller spreads\n",
        deviation, kind.floats ? "export it without --float, or " : "");
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] = add_command(
      app, "export",
      "Write a model as C source (NAME.h, NAME.c) and as a binary file (NAME.bin). A device evaluates it in flash\n"
      "memory with the functions of phynness/phynness_image.h; sizes are constants in NAME.h",
      run);
  add_model(command, options.model);
  add_output(command, options.output, PathKind::folder, "directory for the files; it is made if it does not exist");
  command.add_option("--name", options.name, "name of the files and the symbols (default: model)");
  command.add_flag("--force-only", options.image.force_only,
                   "omit the deformation, which takes most of the flash memory");
  command.add_flag("--float", options.image.floats,
                   "use float numbers: half the flash memory, for processors without double precision");
  add_count(command, "--golden", options.golden, 0, 100000,
            "also write NAME_golden.h and .c: this number of queries with results of the runtime in double, "
            "to check a device");
  add_json(command, options.json_file, "write sizes and golden queries as JSON");
}

}  // namespace phynness::cli::export_command
