// [material]: any usual pair of moduli in, all moduli out.
//
// With E and nu: mu = E / (2 (1 + nu)), lambda = E nu / ((1 + nu) (1 - 2 nu)); always K = lambda + 2 mu / 3.
// With E and K:  mu = 3 K E / (9 K - E).
// neo-Hookean (8): mu = 2 C10. Mooney-Rivlin (9): mu = 2 (C10 + C01). K = 1 / D1, as the paper's numbers have
// it.
#include <algorithm>
#include <array>

#include "scene_keys.hpp"
#include "scene_sections.hpp"

namespace phynness::scene_detail {
namespace {

constexpr Range modulus{0, 1e12, true, false};
constexpr std::array<std::string_view, 8> parameter_keys = {
    "youngs_modulus_Pa", "poisson_ratio", "shear_modulus_Pa", "lame_lambda_Pa",
    "bulk_modulus_Pa",   "d1_per_Pa",     "c10_Pa",           "c01_Pa"};

using Keys = std::vector<std::string_view>;

std::vector<Keys> accepted_sets(Law law) {
  if (law == Law::mooney_rivlin)
    return {{"c10_Pa", "c01_Pa", "bulk_modulus_Pa"}, {"c10_Pa", "c01_Pa", "d1_per_Pa"}};
  std::vector<Keys> sets = {{"youngs_modulus_Pa", "poisson_ratio"},  {"shear_modulus_Pa", "lame_lambda_Pa"},
                            {"shear_modulus_Pa", "bulk_modulus_Pa"}, {"youngs_modulus_Pa", "bulk_modulus_Pa"},
                            {"shear_modulus_Pa", "d1_per_Pa"},       {"youngs_modulus_Pa", "d1_per_Pa"}};
  if (law == Law::neo_hookean) {
    sets.push_back({"c10_Pa", "bulk_modulus_Pa"});
    sets.push_back({"c10_Pa", "d1_per_Pa"});
  }
  return sets;
}

std::string with_values(const SceneTable& table, const Keys& keys) {
  std::string text;
  for (auto key : keys)
    text += (text.empty() ? "" : ", ") + std::string(key) + " = " + shown(*table.find(key));
  return text.empty() ? "none given" : text;
}

void require_one_accepted_set(const SceneTable& table, Law law) {
  Keys given;
  for (auto key : parameter_keys)
    if (table.has(key)) given.push_back(key);
  const auto sets = accepted_sets(law);
  const auto same = [&](Keys set) {
    return set.size() == given.size() &&
           std::all_of(set.begin(), set.end(), [&](auto key) { return table.has(key); });
  };
  if (std::any_of(sets.begin(), sets.end(), same)) return;

  const bool contains_a_set = std::any_of(sets.begin(), sets.end(), [&](const Keys& set) {
    return std::all_of(set.begin(), set.end(), [&](auto key) { return table.has(key); });
  });
  std::string choices;
  for (const auto& set : sets) choices += (choices.empty() ? "" : "; or ") + listed(set, " and ");
  const std::string law_name = phynness::name(law);
  if (contains_a_set)
    refuse(given.empty() ? table.where() : table.where(given.back()),
           "the parameters of law " + law_name + " are over-determined", with_values(table, given),
           "keep exactly one of these sets: " + choices);
  refuse(given.empty() ? table.where() : table.where(given.front()),
         "the parameters of law " + law_name + " do not determine it", with_values(table, given),
         "give exactly one of these sets: " + choices);
}

/// K from bulk_modulus_Pa or d1_per_Pa, whichever is there.
double bulk_modulus(const SceneTable& table) {
  if (const auto bulk = table.number("bulk_modulus_Pa", modulus)) return *bulk;
  return 1.0 / *table.number("d1_per_Pa", {1e-12, 1e12, false, false});
}

void fill_lame_pair(const SceneTable& table, Material& m) {
  const auto young = table.number("youngs_modulus_Pa", modulus);
  const auto poisson = table.number("poisson_ratio", {-1.0, 0.5, true, true});
  const auto shear = table.number("shear_modulus_Pa", modulus);
  const auto c10 = table.number("c10_Pa", modulus);
  if (poisson) {
    m.shear_modulus_Pa = *young / (2 * (1 + *poisson));
    m.lame_lambda_Pa = *young * *poisson / ((1 + *poisson) * (1 - 2 * *poisson));
    m.bulk_modulus_Pa = *young / (3 * (1 - 2 * *poisson));
  } else if (table.has("lame_lambda_Pa")) {
    m.shear_modulus_Pa = *shear;
    m.lame_lambda_Pa = *table.number("lame_lambda_Pa", {-1e12, 1e12});
    m.bulk_modulus_Pa = m.lame_lambda_Pa + 2 * m.shear_modulus_Pa / 3;
    if (!(m.bulk_modulus_Pa > 0))
      table.reject(
          "lame_lambda_Pa", "leaves a bulk modulus lambda + 2 mu / 3 that is not positive",
          "with this shear modulus it must be greater than " + shortest(-2 * m.shear_modulus_Pa / 3));
  } else {
    m.bulk_modulus_Pa = bulk_modulus(table);
    if (young && !(*young < 9 * m.bulk_modulus_Pa))
      table.reject("youngs_modulus_Pa", "must be less than nine times the bulk modulus",
                   "with this bulk modulus it must be less than " + shortest(9 * m.bulk_modulus_Pa));
    m.shear_modulus_Pa = young   ? 3 * m.bulk_modulus_Pa * *young / (9 * m.bulk_modulus_Pa - *young)
                         : shear ? *shear
                                 : 2 * *c10;
    m.lame_lambda_Pa = m.bulk_modulus_Pa - 2 * m.shear_modulus_Pa / 3;
  }
  if (m.law == Law::neo_hookean) m.c10_Pa = m.shear_modulus_Pa / 2;
}

}  // namespace

Material parse_material(const SceneTable& table) {
  Material m;
  m.where = table.where();
  const auto law = table.choice<Law>("law", {{"linear", Law::linear},
                                             {"st-venant-kirchhoff", Law::st_venant_kirchhoff},
                                             {"neo-hookean", Law::neo_hookean},
                                             {"mooney-rivlin", Law::mooney_rivlin}});
  if (!law)
    table.missing("law", "",
                  "add law = \"linear\", \"st-venant-kirchhoff\", \"neo-hookean\" or \"mooney-rivlin\"");
  m.law = *law;
  require_one_accepted_set(table, m.law);

  if (m.law == Law::mooney_rivlin) {
    m.c10_Pa = *table.number("c10_Pa", modulus);
    m.c01_Pa = *table.number("c01_Pa", {0, 1e12});
    m.bulk_modulus_Pa = bulk_modulus(table);
    m.shear_modulus_Pa = 2 * (m.c10_Pa + m.c01_Pa);
    m.lame_lambda_Pa = m.bulk_modulus_Pa - 2 * m.shear_modulus_Pa / 3;
  } else {
    fill_lame_pair(table, m);
  }
  return m;
}

}  // namespace phynness::scene_detail
