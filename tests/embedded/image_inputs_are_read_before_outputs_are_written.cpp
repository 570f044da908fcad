// Claim: every function of phynness_image.h gives the same bits and status if an output overlaps an input at any
// offset. Scratch that overlaps the output, and a pointer to an image inside of its own bytes, are refused with zeros
// as output. A function of the header without a row here fails the test.
#include "../runtime/overlapping_memory.hpp"
#include "opened_image.hpp"
#include "round_models.hpp"

namespace phynness::test {
namespace {

class ImageOverlap : public ::testing::TestWithParam<Family> {
 protected:
  template <class Real>
  void add_rows(const OpenedImage<Real>& opened) {
    const std::string prefix = "phn_image";
    using Type = typename Image<Real>::Type;
    using Places = std::vector<char*>;
    const Type* image = opened.image;
    const std::size_t bytes = 8 * opened.words.size(), n_field = 3 * static_cast<std::size_t>(opened.n_output());
    const std::vector<Real> d = {Real(0.002), Real(-0.001), Real(0.003)};
    // An image has the address of its bytes: told is how far it is from these.
    rows.push_back({prefix + "_open",
                    {input("memory", opened.words), output<const Type*>("image")},
                    [=](const Places& at) {
                      const int status = Image<Real>::open(at[0], bytes, as<const Type*>(at[1]));
                      if (status == PHN_OK) *as<std::uintptr_t>(at[1]) -= reinterpret_cast<std::uintptr_t>(at[0]);
                      return status;
                    },
                    true});
    const auto row = [&](const char* function, const char* result, std::size_t n, auto call) {
      rows.push_back({prefix + function, {input("d", d), output<Real>(result, n)}, [=](const Places& at) {
                        return call(image, 8, as<Real>(at[0]), as<Real>(at[1]));
                      }});
    };
    row("_force", "force", 3, Image<Real>::force);
    row("_energy", "energy", 1, Image<Real>::energy);
    row("_stiffness", "stiffness", 9, Image<Real>::stiffness);
    row("_trained_depth", "depth", 1, Image<Real>::trained_depth);
    using Place = typename Image<Real>::Place;
    const std::vector<Place> place = {{{Real(0.5), Real(0.25), Real(0.25)}, 0}};
    const auto place_row = [&](const char* function, const char* result, std::size_t n, auto call) {
      rows.push_back(
          {prefix + function, {input("place", place), input("d", d), output<Real>(result, n)}, [=](const Places& at) {
             return call(image, as<Place>(at[0]), as<Real>(at[1]), as<Real>(at[2]));
           }});
    };
    place_row("_force_at", "force", 3, Image<Real>::force_at);
    place_row("_energy_at", "energy", 1, Image<Real>::energy_at);
    place_row("_stiffness_at", "stiffness", 9, Image<Real>::stiffness_at);
    place_row("_bound_at", "bound", 1, Image<Real>::bound_at);
    rows.push_back({prefix + "_nearest",
                    {input("x", d), output<Place>("place", 1, {{0, 0, 0}, -1}, {{3 * sizeof(Real) + 4, sizeof(Place)}}),
                     output<Real>("point", 3)},
                    [=](const Places& at) {
                      return Image<Real>::nearest(image, -1, as<Real>(at[0]), as<Place>(at[1]), as<Real>(at[2]));
                    }});
    rows.push_back({prefix + "_deform",
                    {scratch<Real>("scratch", Image<Real>::scratch_size(image) / sizeof(Real)), input("d", d),
                     output<Real>("out", n_field)},
                    [=](const Places& at) {
                      return Image<Real>::deform(image, as<Real>(at[0]), 8, as<Real>(at[1]), as<Real>(at[2]));
                    }});
  }

  const Model model = small_round_model(GetParam());
  const OpenedImage<double> doubles{model_image(model, {false, false})};
  const OpenedImage<float> floats{model_image(model, {false, true})};
  std::vector<Row> rows;

  void SetUp() override {
    add_rows(doubles);
    add_rows(floats);
  }
};
INSTANTIATE_TEST_SUITE_P(Families, ImageOverlap, ::testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

TEST_P(ImageOverlap, TableHoldsEveryFunctionOfTheHeader) {
  expect_rows_of_all_functions(rows, std::string(PHYNNESS_SOURCE_DIR) + "/runtime/include/phynness/phynness_image.h");
}

TEST_P(ImageOverlap, GivesTheSameBitsOrIsRefused) {
  for (const Row& row : rows) {
    Overlaps overlaps(row);
    EXPECT_GE(overlaps.status(), GetParam() == Family::modal ? PHN_OK : PHN_ERROR_UNDEFINED) << row.function;
    overlaps.check();
  }
}

}  // namespace
}  // namespace phynness::test
