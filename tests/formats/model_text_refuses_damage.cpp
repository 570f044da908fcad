#include <gtest/gtest.h>

#include <limits>
#include <phynness/formats/model.hpp>

#include "../messages.hpp"
#include "changed_text.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

// Claim: each kind of defect has its own message. That all of them are refused is shown by grammar_of_model_text.py.
TEST(ModelText, RefusalsSayWhatIsWrong) {
  const std::string text = write_model_text(small_model());
  std::string corrupted = text;
  corrupted[text.size() / 2] ^= 1;
  const std::pair<std::string, const char*> cases[] = {
      {"solid liver\nendsolid\n", "not a phynness model"},
      {"", "not a phynness model"},
      {text.substr(0, text.size() - 1), "truncated"},
      {text.substr(0, text.size() / 2), "truncated"},
      {text.substr(0, 5), "truncated"},
      {corrupted, "corrupted"},
      {replaced(text, "phynness-model 4\n", "phynness-model 2\n"), "another version"},
      {replaced(text, "phynness-model 4\n", "phynness-model 4\r\n"), "line endings"},
      {replaced(text, "family rbfn", "family tree"), "family"},
      {replaced(text, "spread 1.", "spread 1,"), "comma"},
      {replaced(text, "spread 1.", "spread 1x"), "malformed number"},
      {replaced(text, "spread ", "spread nan "), "not finite"},
      {replaced(text, "spread ", "spread -inf "), "not finite"},
      {replaced(text, "spread ", "spread -"), "out of range"},
      {replaced(text, "output 12", "output 2000000000"), "larger than the rest"},
      {replaced(text, "output 12", "output -1"), "out of range"},
      {replaced(text, "output 12", "output 99999999999999999999"), "out of range"},
      {replaced(text, "force 5", "force 4"), "expected 'deformation'"},
      {replaced(text, "mesh_nodes 20", "mesh_nodes 9"), "node number is out of range"},
      {replaced(text, "\nnode 5\n", "\nnode 3\n"), "must ascend"},
      {replaced(text, "checksum", "surplus\nchecksum"), "after the last"},
  };
  const std::string linear = write_model_text(small_linear_model());
  const std::pair<std::string, const char*> linear_cases[] = {
      {replaced(linear, "family linear", "family rbfn"), "expected 'force'"},
      {replaced(text, "family rbfn", "family linear"), "expected 'stiffness'"},
      {replaced(linear, "stiffness ", "stiffness 1p+400 "), "stiffness is beyond 1e100"},
      {replaced(linear, "stiffness ", "stiffness 0p+0 "), "end of the line"},
      {replaced(linear, "unit_responses\n", ""), "expected 'unit_responses'"},
      {replaced(linear, "unit_responses\n", "unit_responses\n-1p+400 "), "unit response is beyond 1e100"},
  };
  const std::string modal = write_model_text(small_modal_model());
  const std::pair<std::string, const char*> modal_cases[] = {
      {replaced(modal, "family modal", "family linear"), "expected 'active'"},
      {replaced(modal, "shared_modes 6", "shared_modes 1025"), "out of range 0 ... 1024"},
      {replaced(modal, "\nmodes ", "\nmodes -"), "scale is negative"},
      {replaced(modal, "\nweights ", "\nweights 1p+5 "), "scale is negative or too large"},
      {replaced(modal, "\nshape 1", "\nshape -1"), "out of range"},
      {replaced(modal, "near 4\n0\n1\n2\n4\n", "near 4\n0\n1\n1\n4\n"), "must ascend"},
      {replaced(modal, "near 4\n0\n1\n2\n4\n", "near 4\n0\n1\n2\n12\n"), "near node is out of range"},
  };
  const std::string leveled = write_model_text(with_levels(small_modal_model())),
                    networks = write_model_text(with_levels(small_model()));
  const std::pair<std::string, const char*> level_cases[] = {
      {replaced(leveled, "\nlevels 3", "\nlevels 1"), "out of range 2 ... 8"},
      {replaced(networks, "\nlevels 3", "\nlevels 4"), "expected 'level'"},
      {replaced(networks, "\nlevel 1p-1", "\nlevel -1p-1"), "is negative or beyond 1e100"},
      {replaced(leveled, "\nlevel 1p-1 1p-2\namplitude_centers 2", "\nlevel 1p-1 1p-2\namplitude_centers 5\n1\n1\n1"),
       "more centers than its model"},
      {replaced(leveled, "\ndeformation 1\n", "\ndeformation 0\n"), "modes of a level is out of range 1 ... 3"},
      {replaced(networks, "\ndeformation 3\n", "\ndeformation 10\n"), "more neurons than its model"},
  };
  const auto expect_messages = [](const auto& of) {
    for (const auto& [damaged, message] : of)
      expect_names(message_of([&, &text = damaged] { read_model_text(text, "model.txt"); }), {message});
  };
  expect_messages(cases);
  expect_messages(linear_cases);
  expect_messages(modal_cases);
  expect_messages(level_cases);
}

// Claim: what cannot be stored is not written.
TEST(ModelText, WriterRefusesWhatTheFormatCannotHold) {
  Model model = small_model();
  model.nodes[0].force.weights(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_model_text(model), Error);
  model = small_model();
  model.nodes[0].deformation.centers(0, 0) += 1e-12;
  EXPECT_THROW(write_model_text(model), Error);
  model = small_model();
  model.family = Family::modal;
  EXPECT_THROW(write_model_text(model), Error);
  model = small_linear_model();
  model.nodes[0].linear.stiffness(0, 1) += 1e-12;
  EXPECT_THROW(write_model_text(model), Error) << "not symmetric";
  model = small_linear_model();
  model.nodes[0].linear.stiffness(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_model_text(model), Error);
  model = small_linear_model();
  model.nodes[0].linear.unit_responses(2, 3) = 1.01e100;
  EXPECT_THROW(write_model_text(model), Error);
  model = small_linear_model();
  model.nodes[0].linear.unit_responses.conservativeResize(11, 9);
  EXPECT_THROW(write_model_text(model), Error);
  const auto refused = [](auto change) {
    Model modal = small_modal_model();
    change(modal);
    EXPECT_THROW(write_model_text(modal), Error);
  };
  refused([](Model& m) { m.nodes[0].conservative.stiffness(0, 1) += 1e-12; });
  refused([](Model& m) { m.nodes[0].conservative.coefficients(0, 0) = 1.01e100; });
  refused([](Model& m) { m.nodes[0].conservative.centers[0] = 8; });
  refused([](Model& m) { m.nodes[0].conservative.centers.pop_back(); });
  refused([](Model& m) { m.nodes[0].conservative.shape = 0.9e-6; });
  refused([](Model& m) { m.shared.shape = 1.1e6; });
  refused([](Model& m) { m.shared.modes.scale[0] = -1; });
  refused([](Model& m) { m.shared.modes.entries(0, 0) = -32768; });
  refused([](Model& m) { m.nodes[0].modal.mixing.scale[0] = 31; });
  refused([](Model& m) { m.nodes[0].modal.weights.scale[0] = std::numeric_limits<double>::quiet_NaN(); });
  refused([](Model& m) { m.nodes[0].modal.near.pop_back(); });
  refused([](Model& m) { m.shared.centers.pop_back(); });
}

}  // namespace
