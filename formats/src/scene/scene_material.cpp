// [material]: computes the law's parameters and the moduli at rest from one of the sets of numbers that the law
// accepts.
#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/schema/bounds.hpp>

#include "scene_keys.hpp"
#include "scene_sections.hpp"

namespace phynness {
namespace {

std::string choices_of(Law law) {
  std::string text;
  for (const auto& set : law->accepted) {
    std::vector<std::string_view> keys;
    for (const auto& quantity : set.given) keys.push_back(quantity.key);
    text += (text.empty() ? "" : "; or ") + scene_detail::listed(keys, " and ");
  }
  return text;
}

Material converted(Law law, const LawSet& set, const std::vector<double>& given) {
  Material m;
  m.law = law;
  m.parameters.resize(law->parameters.size());
  set.convert(given.data(), m.parameters.data(), m);
  return m;
}

}  // namespace

Material material_of(Law law, const std::vector<std::pair<std::string_view, double>>& given) {
  for (const auto& set : law->accepted) {
    std::vector<double> values;
    for (const auto& quantity : set.given)
      for (const auto& [key, value] : given)
        if (key == quantity.key) values.push_back(value);
    if (values.size() == set.given.size() && values.size() == given.size()) return converted(law, set, values);
  }
  std::vector<std::string_view> keys;
  for (const auto& [key, value] : given) keys.push_back(key);
  throw input_error(std::string("the given parameters do not determine law ") + law->name,
                    scene_detail::listed(keys, " and "), "give exactly one of these sets: " + choices_of(law));
}

std::string Relaxation::sentence() const {
  std::string text;
  for (const auto& term : terms.rowwise())
    text += (text.empty() ? "" : ", ") + scene_detail::shortest(100 * term[0]) + " % in " +
            scene_detail::shortest(term[1]) + " s";
  return text.empty() ? "none" : text;
}

namespace scene_detail {
namespace {

std::string with_values(const SceneTable& table, const std::vector<std::string_view>& keys) {
  std::string text;
  for (auto key : keys) text += (text.empty() ? "" : ", ") + std::string(key) + " = " + shown(*table.find(key));
  return text.empty() ? "no parameter is given" : text;
}

std::vector<std::string_view> numbers_in(const SceneTable& table) {
  std::vector<std::string_view> given;
  for (auto key : keys_of("material"))
    if (key != "law" && key != "relaxation" && table.has(key)) given.push_back(key);
  return given;
}

const LawSet& the_accepted_set(const SceneTable& table, Law law) {
  const auto given = numbers_in(table);
  const auto is_given = [&](const LawSet& set) {
    return std::all_of(set.given.begin(), set.given.end(), [&](const auto& q) { return table.has(q.key); });
  };
  for (const auto& set : law->accepted)
    if (set.given.size() == given.size() && is_given(set)) return set;

  const std::string law_name = law->name;
  if (std::any_of(law->accepted.begin(), law->accepted.end(), is_given))
    refuse(given.empty() ? table.where() : table.where(given.back()),
           "the parameters of law " + law_name + " are over-determined", with_values(table, given),
           "keep exactly one of these sets: " + choices_of(law));
  refuse(given.empty() ? table.where() : table.where(given.front()),
         "the parameters of law " + law_name + " do not determine it", with_values(table, given),
         "give exactly one of these sets: " + choices_of(law));
}

/// @param otherwise  has the numbers of the set that `table` lacks
Material read_numbers(const SceneTable& table, const SceneTable& otherwise, Law law, const LawSet& set) {
  const auto holder = [&](std::string_view key) -> const SceneTable& { return table.has(key) ? table : otherwise; };
  std::vector<double> given;
  if (const auto* d1 = table.find("d1_per_Pa"); d1 && d1->value<double>() == 0.0)
    table.reject("d1_per_Pa", "must be greater than 0, because K is 1/D1",
                 "give bulk_modulus_Pa = 100 to 1,000 times mu in its place");
  for (const auto& q : set.given)
    given.push_back(*holder(q.key).number(q.key, {q.low, q.high, q.low_open, q.high_open}));
  for (const auto& bound : set.bounds) {
    const auto& key = set.given[static_cast<std::size_t>(bound.given)].key;
    const double value = given[static_cast<std::size_t>(bound.given)], limit = bound.value(given.data());
    if (bound.greater ? value > limit : value < limit) continue;
    holder(key).reject(
        key, bound.what,
        std::string(bound.remedy) + " it must be " + (bound.greater ? "greater" : "less") + " than " + shortest(limit));
  }
  Material m = converted(law, set, given);
  m.d1_given = table.has("d1_per_Pa");
  m.where = table.where();
  return m;
}

}  // namespace

Material parse_material(const SceneTable& table) {
  const Law law = *table.choice<Law>("law", choices(laws()));
  return read_numbers(table, table, law, the_accepted_set(table, law));
}

Material parse_material(const SceneTable& region, const SceneTable& body, Law law) {
  const LawSet& of_body = the_accepted_set(body, law);
  const auto is_of_body = [&](std::string_view key) {
    return std::ranges::any_of(of_body.given, [&](const auto& q) { return q.key == key; });
  };
  const auto given = numbers_in(region);
  if (given.empty())
    region.missing(of_body.given.front().key, ", and so is every other parameter of law " + std::string(law->name),
                   "give what is different from [material]: " + choices_of(law));
  const bool some = std::ranges::all_of(given, is_of_body);
  return read_numbers(region, body, law, some ? of_body : the_accepted_set(region, law));
}

Relaxation parse_relaxation(const SceneTable& material) {
  const char* const remedy = "write relaxation = { g = [0.3, 0.2], tau_s = [2.0, 20.0] }";
  const auto* table = material.find("relaxation")->as_table();
  if (!table) material.reject("relaxation", "must be a table of g and tau_s", remedy);
  for (const auto& [key, value] : *table)
    if (key != "g" && key != "tau_s")
      refuse(material.where(value), "unknown key in [material] relaxation", std::string(key.str()), remedy);
  const toml::array* columns[] = {table->get_as<toml::array>("g"), table->get_as<toml::array>("tau_s")};
  if (!columns[0] || !columns[1]) material.reject("relaxation", "needs an array g and an array tau_s", remedy);
  const std::size_t n = columns[0]->size();
  if (n != columns[1]->size() || n < 1 || n > schema::largest_relaxation_count)
    material.reject("relaxation",
                    "must have as many numbers in g as in tau_s, 1 to " +
                        std::to_string(schema::largest_relaxation_count) + " of each",
                    remedy);
  Relaxation relaxation;
  relaxation.terms.resize(static_cast<Eigen::Index>(n), 2);
  for (std::size_t i = 0; i < n; ++i)
    for (int k = 0; k < 2; ++k) {
      const toml::node& node = *columns[k]->get(i);
      const double value = node.value<double>().value_or(std::nan(""));
      const auto& bound = k == 0 ? schema::relaxing_share : schema::relaxation_time;
      if (!(value >= bound.low && value <= bound.high))
        refuse(material.where(node),
               std::string("[material] relaxation: ") + (k == 0 ? "g " : "tau_s ") + bound.outside, shown(node),
               k == 0 ? "g is the share of the shear modulus that a term loses" : "tau_s is in seconds");
      relaxation.terms(static_cast<Eigen::Index>(i), k) = value;
    }
  if (!(relaxation.terms.col(0).sum() < 1))
    material.reject("relaxation", "has a sum of g that is not below 1, so that no elastic stiffness is left",
                    "reduce g; the stiffness after a long time is 1 - sum g of that at once");
  return relaxation;
}

void check_material(const SceneTable& table, const Scene& scene) {
  std::vector<std::string_view> names, always;
  for (const auto& law : laws()) {
    names.push_back(law.name);
    if (law.has_shell && law.shell_from == 0) always.push_back(law.name);
  }
  if (!table.has("law")) table.missing("law", "", "add law, one of " + listed(names));
  const Material& m = scene.material;
  const std::string remedy = "use law = " + listed(always) + ", or a solid without thickness_m";
  if (!(scene.mesh.thickness_m > 0)) return;
  if (!m.law->has_shell) table.reject("law", "is not available for shells (it has no plane-stress form)", remedy);
  if (m.bulk_to_shear() < m.law->shell_from)
    table.reject("law",
                 "is accurate enough for shells only from K/mu = " + shortest(m.law->shell_from) +
                     " on; here K/mu is " + shortest(m.bulk_to_shear()),
                 remedy);
}

}  // namespace scene_detail
}  // namespace phynness
