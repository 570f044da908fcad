// Model texts for a test in another language, and the results of the program's readers for the texts of that test.
// Usage: model_texts write FOLDER    a small model of every family, with and without levels and fields, and other sizes
//        model_texts judge FILE      FILE: texts, each after a line with its number of bytes. Prints for each text
//                                    the results of the host's and the runtime's reader, `yes` or `no`, in a line
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <phynness/formats/error.hpp>
#include <phynness/formats/model.hpp>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// Two active nodes, the second with a patch; the first moves its mean.
Model of_two_nodes(Model model) {
  model.nodes = {model.nodes[0], model.nodes[2]};
  model.nodes[0].moves_mean = true;
  return model;
}

Model fewer_field_modes() {
  Model model = of_two_nodes(small_field_model());
  ModalDeformation& bare = model.nodes[1].fields[0];
  for (ScaledTable* table : {&bare.weights, &bare.mixing, &bare.near_modes})
    *table = scaled_table(Eigen::MatrixXd(table->rows(), 0));
  return model;
}

void write_all(const std::filesystem::path& folder) {
  const auto write = [&](const char* name, const Model& model) {
    std::ofstream(folder / name, std::ios::binary) << write_model_text(model);
  };
  const Model networks = of_two_nodes(small_model(3, 2)), modes = of_two_nodes(small_modal_model(2, 2, 2, 2));
  write("rbfn", networks);
  write("rbfn-levels", with_levels(networks));
  write("linear", of_two_nodes(small_linear_model()));
  write("modal", modes);
  write("modal-levels", with_levels(modes));
  write("modal-fields", fewer_field_modes());
  write("modal-fields-levels", with_levels(fewer_field_modes(), 2));
  write("modal-forces-only", of_two_nodes(small_modal_model(0, 2, 0, 0)));
  write("rbfn-empty", small_model(0, 0));
  write("rbfn-eight-levels", with_levels(small_model(), 8));
  write("modal-empty", small_modal_model(0, 0, 0, 0));
  write("modal-bounds", with_bounds(modes));
  Model measured = with_bounds(networks);
  measured.finer = {true, "p1-p1", "taylor-hood", 12, 0.03, 0.25, 0.5, 300, 13};
  measured.finer.has_parts = true;
  measured.finer.force_ratio = 0.875;
  measured.finer.shape_at_rest = {24, 0.125, 0.5};
  measured.solved = {true, "p1-p1", 500.5};
  measured.relaxation.terms.resize(2, 2);
  measured.relaxation.terms << 0.25, 2, 0.125, 20;
  write("rbfn-finer", measured);
  Model covered = modes;
  covered.probe_triangles.resize(2, 3);
  covered.probe_triangles << 0, 1, 1, 1, 0, 0;
  covered.covered.resize(3, 4);
  covered.covered << 2, 1, 0, 0, 3, 0, 65535, 0, 12, 1, 20000, 65535;
  write("modal-covered", covered);
  write("modal-linear-points", with_linear_points(with_levels(covered)));
  write("rbfn-linear-points", with_linear_points(networks));
  write("rbfn-levels-bounds", with_bounds(with_levels(networks)));
  write("modal-large", with_bound_between(with_levels(small_field_model(), 8)));
  Model untouched = small_linear_model();
  untouched.nodes.clear();
  untouched.title = "";
  write("linear-untouched", untouched);
}

const char* said_by_host(const std::string& text) {
  try {
    read_model_text(text, "model.txt");
  } catch (const Error&) {
    return "no";
  }
  return "yes";
}

const char* said_by_runtime(const std::string& text) {
  try {
    const LoadedModel loaded(text);
  } catch (const std::runtime_error&) {
    return "no";
  }
  return "yes";
}

int judge_all(const char* file) {
  std::ifstream texts(file, std::ios::binary);
  for (std::string length; std::getline(texts, length);) {
    std::string text(std::stoul(length), '\0');
    if (!texts.read(text.data(), static_cast<std::streamsize>(text.size()))) return 2;
    std::cout << said_by_host(text) << ' ' << said_by_runtime(text) << '\n';
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  if (std::strcmp(argv[1], "judge") == 0) return judge_all(argv[2]);
  write_all(argv[2]);
}
