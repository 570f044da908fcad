// Models of valid structure with arbitrary numbers, coincident points and empty parts: the runtime loads the text of
// the host or finds a value out of range, and every result is defined. Input: the small model, its sizes, changes,
// queries.
#include <phynness/formats/error.hpp>
#include <phynness/formats/model.hpp>

#include "../runtime/model_numbers.hpp"
#include "../runtime/small_model.hpp"
#include "ask_model.hpp"

namespace phynness::fuzz {
namespace {

using namespace phynness::test;

Model start_without_levels(Script& script) {
  switch (script.below(4)) {
    case 0: {
      const int n = script.below(4);
      return small_model(n, script.below(4));
    }
    case 1:
      return small_linear_model();
    case 2: {
      const int modes = script.below(4), force = script.below(4), shared = script.below(5);
      return small_modal_model(modes, force, shared, script.below(4));
    }
    default:
      return small_field_model();
  }
}

Model start(Script& script) {
  Model model = start_without_levels(script);
  const bool levels = script.below(4) == 0 && model.family != Family::linear;
  return levels ? with_levels(model, 2 + script.below(3)) : model;
}

/// One group of numbers: one of them, all of them, or a multiple.
void change_values(Model& model, Script& script) {
  // What all nodes share is chosen as often as what each of them has.
  std::vector<std::pair<double*, std::size_t>> groups;
  const std::size_t n_shared =
      for_each_group(model, [&](double* first, std::size_t n) { groups.emplace_back(first, n); });
  const bool shared = script.below(2) == 0;
  const std::size_t n_groups = shared ? n_shared : groups.size() - n_shared;
  if (n_groups == 0) return;
  const auto [first, n] = groups[(shared ? 0 : n_shared) + script.raw<std::uint16_t>() % n_groups];
  if (n == 0) return;
  constexpr double extremes[] = {1e30,  1e100,  1e155,  1e200, 1e300, 1.7976931348623157e308,
                                 1e-30, 1e-160, 1e-300, 5e-324};
  const double value = script.below(2) == 0 ? extremes[script.below(10)] : script.number();
  switch (script.below(4)) {
    case 0:
      first[script.raw<std::uint16_t>() % n] = value;
      break;
    case 1:
      std::fill(first, first + n, value);
      break;
    case 2:
      for (std::size_t i = 0; i < n; ++i) first[i] = script.below(2) == 0 ? value : -value;
      break;
    default:
      for (std::size_t i = 0; i < n; ++i) first[i] *= value;
  }
  for (ActiveNodeModel& node : model.nodes) {
    if (model.family == Family::rbfn) {
      fill_centers(model, node.force);
      fill_centers(model, node.deformation);
    }
    for (Eigen::Matrix3d* k : {&node.linear.stiffness, &node.conservative.stiffness})
      *k = k->selfadjointView<Eigen::Upper>();
  }
}

void change_structure(Model& model, Script& script) {
  const auto node = [&]() -> ActiveNodeModel& {
    return model.nodes[static_cast<std::size_t>(script.below(4)) % model.nodes.size()];
  };
  switch (script.below(9)) {
    case 0:
      model.output_points.row(script.below(12)) = model.output_points.row(script.below(12));
      break;
    case 1:
      if (!model.nodes.empty()) node().point = node().point;
      break;
    case 2:
      if (!model.nodes.empty()) std::copy_n(model.output_points.row(script.below(12)).data(), 3, node().point.data());
      break;
    case 3:
      model.surface.resize(0, 3);
      break;
    case 4:
      if (model.surface.rows() > 0) model.surface(0, script.below(3)) = model.surface(0, script.below(3));
      break;
    case 5:
      model.nodes.clear();
      break;
    case 6:
      if (model.surface.rows() > 0)
        model.surface.conservativeResize(1 + script.below(static_cast<int>(model.surface.rows())), 3);
      break;
    case 7:
      for (auto* table : {&model.shared.modes.entries})
        table->setConstant(script.raw<std::int16_t>() == -32768 ? 32767 : script.raw<std::int16_t>() / 2);
      break;
    default:
      if (!model.nodes.empty()) node().n_incomplete = script.below(5);
  }
}

}  // namespace

std::vector<Input> seeds() { return random_inputs(7, 1000, 300, 4); }

}  // namespace phynness::fuzz

using namespace phynness;
using namespace phynness::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Script script(data, size);
  Model model = start(script);
  for (int n = script.below(6); n > 0; --n) {
    if (script.below(4) == 0) {
      change_structure(model, script);
    } else {
      change_values(model, script);
    }
  }
  std::string text;
  try {
    text = write_model_text(model);
  } catch (const Error&) {
    return 0;
  }
  const LoadedText loaded(text.data(), text.size(), 8);
  if (loaded.model == nullptr) return 0;
  look_at(loaded.model);
  const std::uint64_t before = loaded.hash();
  ask(loaded.model, script, false);
  // And what nobody should have to guess.
  static const Input usual = [] {
    Input questions(2000);
    Random random(5);
    for (auto& byte : questions) byte = static_cast<std::uint8_t>(random.next());
    return questions;
  }();
  Script always(usual);
  ask(loaded.model, always, false, 100);
  require(loaded.hash() == before, "a model never changes");
  return 0;
}
