#include <phynness/formats/error.hpp>
#include <phynness/formats/law.hpp>
#include <string>

namespace phynness {
namespace {

template <class Row>
const Row* row_named(std::span<const Row> rows, std::string_view name, const char* kind) {
  std::string known;
  for (const auto& row : rows) {
    if (row.name == name) return &row;
    known.append(known.empty() ? "" : ", ").append(row.name);
  }
  throw input_error(std::string("there is no such ") + kind, std::string(name), "use one of " + known);
}

}  // namespace

Law law_named(std::string_view name) { return row_named(laws(), name, "law"); }
Element element_named(std::string_view name) { return row_named(elements(), name, "element"); }

}  // namespace phynness
