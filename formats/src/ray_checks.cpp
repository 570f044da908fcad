#include "ray_checks.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

namespace phynness {
namespace {

template <class Code, std::size_t n>
bool is_one_of(const CodeRow<Code> (&rows)[n], Code code) {
  return std::any_of(rows, rows + n, [code](const auto& row) { return row.code == code; });
}
bool is_known(Status code) { return is_one_of(every_status, code); }
bool is_known(EndReason code) { return is_one_of(every_end, code); }

/// Whether values are within the bounds of a column's kind.
struct Possible {
  double least, most;

  Possible(ColumnKind kind, double farthest_m)
      : most(kind == ColumnKind::displacement ? farthest_m : std::numeric_limits<double>::max()) {
    least = kind == ColumnKind::count || kind == ColumnKind::cost ? 0 : -most;
  }
  template <class T>
  bool operator()(T value) const {
    if constexpr (std::is_enum_v<T>)
      return is_known(value);
    else
      return static_cast<double>(value) >= least && static_cast<double>(value) <= most;
  }
};

template <class T>
std::string tell(const StoredColumn& column, std::size_t increment, T value) {
  std::string number;
  if constexpr (std::is_enum_v<T>) {
    number = std::to_string(static_cast<int>(value));
  } else {
    char buffer[32];
    number.assign(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
  }
  const bool of_ray = column.of == ColumnOf::ray;
  return column.path + (of_ray ? "" : ", increment " + std::to_string(increment) + ",") + " is " + number;
}

template <class T>
std::string defect(const StoredColumn& column, std::span<const T> values, const std::vector<Status>& status,
                   double farthest_m) {
  const Possible is_possible(column.kind, farthest_m);
  const bool is_measure = column.kind == ColumnKind::measure || column.kind == ColumnKind::displacement;
  const std::size_t increments = column.of == ColumnOf::ray ? 1 : status.size();
  const std::size_t per_increment = values.size() / increments;
  for (std::size_t i = 0; i < increments; ++i) {
    if (is_measure && column.of != ColumnOf::ray && status[i] != Status::converged) continue;
    const auto part = values.subspan(i * per_increment, per_increment);
    const auto found = std::find_if_not(part.begin(), part.end(), is_possible);
    if (found != part.end()) return tell(column, i, *found);
  }
  return "";
}

}  // namespace

std::string ray_defect(const Ray& ray, const std::vector<StoredColumn>& columns, double farthest_m) {
  for (const auto& column : columns) {
    auto found = std::visit(
        [&](auto member) {
          return defect<ValueOf<decltype(member)>>(column, values_of(ray, member), ray.status, farthest_m);
        },
        column.member);
    if (!found.empty()) return found;
  }
  return "";
}

}  // namespace phynness
