// Claim: every function of phynness.h and the other headers gives the same bits and status if an output overlaps an
// input at any offset. Outputs that overlap each other, or inputs that are too large to be copied, are refused with
// zeros as output. A function of the headers without a row here fails the test.
#include <phynness/phynness_contact.h>
#include <phynness/phynness_surface.h>

#include <cstddef>
#include <phynness/phynness.hpp>

#include "loaded_model.hpp"
#include "overlapping_memory.hpp"
#include "small_model.hpp"

namespace phynness::test {
namespace {

const std::string headers = std::string(PHYNNESS_SOURCE_DIR) + "/runtime/include/phynness/";

constexpr int no_answer = 12345;  ///< the call was not made
constexpr phn_tool none = {{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}};
constexpr phn_contact_state no_contact = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0, 0, none, 0};

constexpr std::array<std::size_t, 2> tool_hole = {sizeof none.nodes, offsetof(phn_tool, weights)};
constexpr std::size_t held = offsetof(phn_contact_state, held), touches = offsetof(phn_contact_state, in_contact);
const std::vector<std::array<std::size_t, 2>> state_holes = {{held + tool_hole[0], held + tool_hole[1]},
                                                             {touches + 4, sizeof(phn_contact_state)}};

/// All objects of one model, and a row for every function that writes to memory beside other memory.
class Table {
 public:
  explicit Table(Family family)
      : text(write_model_text(family == Family::linear  ? small_linear_model()
                              : family == Family::modal ? with_bounds(with_levels(small_field_model()))
                                                        : with_levels(small_model()))),
        loaded(text) {
    std::size_t bytes = 0;
    LoadedModel::check(phn_surface_size(loaded.model, 2, &bytes));
    surface_memory.resize(bytes);
    LoadedModel::check(phn_surface_init(surface_memory.data(), bytes, loaded.model, 2, &surface));
    LoadedModel::check(phn_contact_size(loaded.model, 2, &bytes));
    contact_memory.resize(bytes);
    LoadedModel::check(phn_contact_init(contact_memory.data(), bytes, loaded.model, 2, &contact));
    inits();
    responses();
    deformations();
    tools();
    touches();
  }

  std::vector<Row> rows;

 private:
  using Places = std::vector<char*>;

  void inits() {
    const std::size_t length = text.size(), room = loaded.model_memory.size() + (1 << 17);
    const std::vector<char> letters(text.begin(), text.end());
    rows.push_back({"phn_model_size",
                    {input("text", letters), output<std::size_t>("bytes"), output<std::size_t>("wrong_byte")},
                    [=](const Places& at) {
                      return phn_model_size(at[0], length, as<std::size_t>(at[1]), as<std::size_t>(at[2]));
                    }});
    rows.push_back({"phn_model_init",
                    {memory("memory", room), input("text", letters), output<const phn_model*>("model"),
                     output<std::size_t>("wrong_byte")},
                    [=](const Places& at) {
                      return phn_model_init(at[0], room, at[1], length, as<const phn_model*>(at[2]),
                                            as<std::size_t>(at[3]));
                    }});
    const auto init = [&](const char* function, const char* handle, auto call) {
      rows.push_back({function, {memory("memory", room), output<void*>(handle)}, [=](const Places& at) {
                        return call(at[0], room, at[1]);
                      }});
    };
    const phn_model* model = loaded.model;
    init("phn_data_init", "data", [model](void* memory, std::size_t bytes, char* handle) {
      return phn_data_init(memory, bytes, model, 4, as<phn_data*>(handle));
    });
    init("phn_surface_init", "surface", [model](void* memory, std::size_t bytes, char* handle) {
      return phn_surface_init(memory, bytes, model, 1, as<const phn_surface*>(handle));
    });
    init("phn_contact_init", "contact", [model](void* memory, std::size_t bytes, char* handle) {
      return phn_contact_init(memory, bytes, model, 2, as<phn_contact*>(handle));
    });
  }

  void responses() {
    const phn_model* model = loaded.model;
    phn_data* data = loaded.data;
    const auto row = [&](const char* function, const char* result, std::size_t n, auto call) {
      rows.push_back({function, {input("d", d), output<double>(result, n)}, [=](const Places& at) {
                        return call(as<double>(at[0]), as<double>(at[1]));
                      }});
    };
    rows.push_back(
        {"phn_force",
         {input("d", d), output<double>("force", 3), output<double>("energy"), output<double>("stiffness", 9)},
         [=](const Places& at) {
           return phn_force(model, data, 8, as<double>(at[0]), as<double>(at[1]), as<double>(at[2]), as<double>(at[3]));
         }});
    row("force alone", "force", 3,
        [=](double* x, double* out) { return phn_force(model, data, 8, x, out, nullptr, nullptr); });
    row("energy alone", "energy", 1,
        [=](double* x, double* out) { return phn_force(model, data, 8, x, nullptr, out, nullptr); });
    row("stiffness alone", "stiffness", 9,
        [=](double* x, double* out) { return phn_force(model, data, 8, x, nullptr, nullptr, out); });
    row("phn_field", "out", n_output(), [=](double* x, double* out) { return phn_field(model, data, 8, x, 1, out); });
    row("phn_deform", "out", 3 * n_output(),
        [=](double* x, double* out) { return phn_deform(model, data, 8, x, out); });
    row("phn_trained_depth", "depth", 1, [=](double* x, double* out) { return phn_trained_depth(model, 8, x, out); });
    row("phn_bound", "bound", 1, [=](double* x, double* out) { return phn_bound(model, 8, x, out); });
  }

  void deformations() {
    const phn_model* model = loaded.model;
    phn_data* data = loaded.data;
    const std::vector<std::int32_t> nodes = {8, 3, 15};
    const std::vector<double> displacements = {0.002, -0.001, 0.003, -0.002, 0.001, 0.004, 0.001, 0.002, -0.003};
    for (const std::int32_t n : {1, 3}) {
      rows.push_back(
          {"phn_blend_paper",
           {input("nodes", nodes), input("displacements", displacements), output<double>("out", 3 * n_output())},
           [=](const Places& at) {
             return phn_blend_paper(model, data, n, as<std::int32_t>(at[0]), as<double>(at[1]), as<double>(at[2]));
           }});
    }
    const phn_surface* fine = surface;
    std::vector<double> field(3 * n_output());
    LoadedModel::check(phn_deform(model, data, nodes[0], displacements.data(), field.data()));
    rows.push_back({"phn_surface_deform",
                    {scratch<float>("scratch", phn_surface_scratch_size(fine) / sizeof(float)), input("field", field),
                     output<float>("out", 3 * static_cast<std::size_t>(phn_surface_n_vertices(fine)))},
                    [=](const Places& at) {
                      return phn_surface_deform(fine, as<float>(at[0]), as<double>(at[1]), as<float>(at[2]));
                    },
                    true});
  }

  void tools() {
    const phn_model* model = loaded.model;
    phn_data* data = loaded.data;
    rows.push_back({"phn_nearest",
                    {input("x", x), output("tool", 1, none, {tool_hole}), output<double>("point", 3)},
                    [=](const Places& at) {
                      return phn_nearest(model, as<double>(at[0]), as<phn_tool>(at[1]), as<double>(at[2]));
                    }});
    const std::vector<phn_tool> two = {{{3, 5, 8}, {0.5, 0.25, 0.25}, {0.001, -0.002, 0.001}},
                                       {{8, -1, -1}, {1, 0, 0}, {0.001, 0.002, 0}}};
    const std::vector<phn_tool> one = {two.back()};
    rows.push_back(
        {"phn_force_at",
         {input("tool", one), output<double>("force", 3), output<double>("energy"), output<double>("stiffness", 9)},
         [=](const Places& at) {
           return phn_force_at(model, data, as<phn_tool>(at[0]), as<double>(at[1]), as<double>(at[2]),
                               as<double>(at[3]));
         }});
    rows.push_back({"phn_trained_depth_at", {input("tool", one), output<double>("depth")}, [=](const Places& at) {
                      return phn_trained_depth_at(model, as<phn_tool>(at[0]), as<double>(at[1]));
                    }});
    rows.push_back({"phn_bound_at", {input("tool", one), output<double>("bound")}, [=](const Places& at) {
                      return phn_bound_at(model, as<phn_tool>(at[0]), as<double>(at[1]));
                    }});
    for (const std::int32_t n : {1, 2}) {
      const std::vector<phn_tool> given(two.end() - n, two.end());
      rows.push_back(
          {"phn_couple",
           {input("tools", given), output<double>("forces", 3 * given.size()), output<phn_coupled>("result")},
           [=](const Places& at) {
             return phn_couple(model, data, n, as<phn_tool>(at[0]), as<double>(at[1]), as<phn_coupled>(at[2]));
           }});
    }
  }

  void touches() {
    phn_data* data = loaded.data;
    phn_contact* touch = contact;
    rows.push_back({"phn_contact_nearest",
                    {input("x", x), output("tool", 1, none, {tool_hole}), output<double>("point", 3)},
                    [=](const Places& at) {
                      return phn_contact_nearest(touch, as<double>(at[0]), as<phn_tool>(at[1]), as<double>(at[2]));
                    }});
    // Both hold the surface, and are then moved.
    phn_tool tool;
    std::vector<phn_contact_tool> before(2), after(2);
    for (std::size_t t = 0; t < 2; ++t) {
      const double from[3] = {x[0] + 0.01 * static_cast<double>(t), x[1], x[2]};
      before[t] = {{}, 0.01, 0.5, PHN_TOOL_GRASP};
      LoadedModel::check(phn_contact_nearest(touch, from, &tool, before[t].center));
      after[t] = before[t];
      after[t].center[t] += 0.002;
    }
    rows.push_back(
        {"phn_contact_step",
         {input("tools", after), output("states", 2, no_contact, state_holes), output<phn_coupled>("result")},
         [=](const Places& at) {
           phn_contact_state states[2];
           LoadedModel::check(phn_contact_reset(touch));
           if (phn_contact_step(touch, data, 2, before.data(), states, nullptr) < 0 || states[0].in_contact != 1)
             return no_answer;
           return phn_contact_step(touch, data, 2, as<phn_contact_tool>(at[0]), as<phn_contact_state>(at[1]),
                                   as<phn_coupled>(at[2]));
         }});
  }

  std::size_t n_output() const { return static_cast<std::size_t>(info_of(loaded.model).n_output); }

  const std::vector<double> d = {0.002, -0.001, 0.003}, x = {0.01, 0.02, 0.01};
  const std::string text;
  LoadedModel loaded;
  std::vector<char> surface_memory, contact_memory;
  const phn_surface* surface = nullptr;
  phn_contact* contact = nullptr;
};

class Overlap : public ::testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, Overlap, ::testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

TEST_P(Overlap, TableHoldsEveryFunctionOfTheHeaders) {
  const Table table(GetParam());
  for (const char* header : {"phynness.h", "phynness_tools.h", "phynness_contact.h", "phynness_levels.h",
                             "phynness_paper.h", "phynness_surface.h"})
    expect_rows_of_all_functions(table.rows, headers + header);
}

TEST_P(Overlap, GivesTheSameBitsOrIsRefused) {
  const Table table(GetParam());
  for (const Row& row : table.rows) {
    Overlaps overlaps(row);
    const bool may_be_undefined = row.function == "phn_force" || row.function == "energy alone" ||
                                  row.function == "stiffness alone" || row.function == "phn_field" ||
                                  row.function == "phn_bound" || row.function == "phn_force_at" ||
                                  row.function == "phn_bound_at";
    EXPECT_GE(overlaps.status(), may_be_undefined ? PHN_ERROR_UNDEFINED : PHN_OK) << row.function;
    EXPECT_LT(overlaps.status(), no_answer) << row.function;
    overlaps.check();
  }
}

// An object is not made in the memory of its model.
TEST_P(Overlap, OfAnObjectAndItsModelIsRefused) {
  LoadedModel loaded(write_model_text(small_model_of(GetParam())));
  const std::vector<char> before = loaded.model_memory;
  phn_data* data = nullptr;
  const phn_surface* surface = nullptr;
  phn_contact* contact = nullptr;
  const std::size_t bytes = 1 << 20;
  for (const std::size_t offset : {std::size_t{0}, before.size() / 2, before.size() - 64}) {
    char* const memory = loaded.model_memory.data() + offset;
    EXPECT_EQ(phn_data_init(memory, bytes, loaded.model, 1, &data), PHN_ERROR_OVERLAP);
    EXPECT_EQ(phn_surface_init(memory, bytes, loaded.model, 1, &surface), PHN_ERROR_OVERLAP);
    EXPECT_EQ(phn_contact_init(memory, bytes, loaded.model, 1, &contact), PHN_ERROR_OVERLAP);
    EXPECT_TRUE(data == nullptr && surface == nullptr && contact == nullptr);
  }
  EXPECT_EQ(loaded.model_memory, before);
}

// The wrapper passes memory on as it is: a vector becomes the force of what it was.
TEST_P(Overlap, WrapperGivesTheSameBits) {
  const std::string text = write_model_text(small_model_of(GetParam()));
  const rt::Model model(text);
  rt::Data data(model, 1);
  std::array<double, 3> d = {0.002, -0.001, 0.003}, force;
  const rt::Status apart = data.force(8, d, force), same = data.force(8, d, d);
  EXPECT_EQ(apart, same);
  EXPECT_EQ(d, force);
}

}  // namespace
}  // namespace phynness::test
