#include <fmt/core.h>

#include <phynness/formats/error.hpp>
#include <phynness/validation/loaded_model.hpp>

#include "commands.hpp"

namespace phynness::cli {
namespace {

struct Options {
  std::filesystem::path model;
  std::string tools = "paper";
  ToolOptions tool;
};

void run(const Options& options) {
  options.tool.refuse_overwriting_inputs(options.model / "model.txt");
  options.tool.refuse_overwriting_inputs(options.model / "mesh.txt");
  const auto displacements = options.tool.parsed_displacements();
  if (options.tools == "coupled" && options.tool.nodes.size() > 1)
    throw input_error("this version couples no tools", "--tools coupled",
                      "use --tools paper: weights (15)-(16), no force");
  const LoadedModel model(options.model);
  const auto response = model.respond(options.tool.nodes, displacements);
  if (response.displacement_m.rows() == 0 && options.tool.deformation_csv)
    throw input_error("this model has forces only", "--deformation " + options.tool.deformation_csv->string(),
                      "train it with [training] modes of 1 or more");
  if (response.status > 0) fmt::print(stderr, "warning: {}\n", phn_status_message(response.status));
  ToolResult result{response.force_N, response.energy_J, response.displacement_m, model.model().output, {}};
  for (Eigen::Index f = 0; f < response.fields.cols(); ++f) {
    const auto& field = model.model().fields[static_cast<std::size_t>(f)];
    const auto known = field_named(field.name);
    result.fields.push_back(
        {field.name, field.unit, known ? column(*known) : field.name, response.fields.col(f)});
  }
  report_tools(options.tool, displacements, model.mesh(), result,
               {{"status", response.status}, {"family", name(model.model().family)}});
}

}  // namespace

void add_eval_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("eval", "Force and deformation from a model, as the runtime gives them");
  command->add_option("MODEL_DIR", options->model, "directory with model.txt and mesh.txt")->required();
  options->tool.add_to(*command);
  command
      ->add_option("--tools", options->tools,
                   "several tools: paper = weights (15)-(16) (coupled: later versions)")
      ->check(CLI::IsMember({"coupled", "paper"}));
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli
