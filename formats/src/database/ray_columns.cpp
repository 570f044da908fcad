#include "ray_columns.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <phynness/formats/printable.hpp>

namespace phynness {
namespace {

template <class T>
void resize(Ray& ray, std::vector<T> Ray::*member, std::size_t count) {
  (ray.*member).resize(count);
}
template <class T>
void resize(Ray& ray, T RayEnd::*member, std::size_t) {
  ray.end.*member = T{};
}
void resize(Ray& ray, RayColumn::FieldIndex field, std::size_t count) {
  ray.fields.resize(std::max(ray.fields.size(), field.index + 1));
  ray.fields[field.index].resize(count);
}

constexpr const char* unknown = "unknown";

template <class Code, std::size_t n>
CodeRow<Code> row_of(const CodeRow<Code> (&rows)[n], Code code) {
  const auto found = std::find_if(rows, rows + n, [code](const auto& row) { return row.code == code; });
  return found == rows + n ? CodeRow<Code>{code, unknown, unknown} : *found;
}

StoredColumn stored(const RayColumn& column, const DatabaseHeader& header, const char* folder) {
  StoredColumn result{column, std::string(folder) + column.name, {}, 1};
  if (column.of != ColumnOf::ray) result.shape.push_back(header.magnitudes_m.size());
  if (column.of == ColumnOf::output_node) result.shape.push_back(header.sets.output.size());
  if (column.tensor != Tensor::scalar) result.shape.push_back(3);
  if (column.tensor == Tensor::matrix) result.shape.push_back(3);
  result.count = std::accumulate(result.shape.begin(), result.shape.end(), std::size_t{1}, std::multiplies<>());
  return result;
}

}  // namespace

const char* name(Status status) { return row_of(every_status, status).name; }
const char* meaning(Status status) { return row_of(every_status, status).meaning; }
const char* name(EndReason reason) { return row_of(every_end, reason).name; }
const char* meaning(EndReason reason) { return row_of(every_end, reason).meaning; }

std::vector<StoredColumn> columns_of(const DatabaseHeader& header) {
  std::vector<StoredColumn> columns;
  for (const auto& column : ray_columns) {
    if (column.with_tangents && !header.tangents) continue;
    columns.push_back(stored(column, header, "/responses/"));
    columns.back().float32 &= !header.float64;
  }
  for (std::size_t i = 0; i < header.fields.size(); ++i)
    columns.push_back(stored(field_column(header.fields[i], i), header, "/responses/fields/"));
  return columns;
}

std::vector<StoredColumn> columns_of(const DatabaseHeader& header, ColumnOf of) {
  auto columns = columns_of(header);
  std::erase_if(columns, [of](const auto& column) { return column.of != of; });
  return columns;
}

std::string names(const std::vector<Field>& fields, const char* joint) {
  std::string text;
  for (const auto field : fields) text.append(text.empty() ? "" : joint).append(name(field));
  return text;
}

RayColumn field_column(Field field, std::size_t index) {
  return {RayColumn::FieldIndex{index},
          name(field),
          ColumnOf::output_node,
          Tensor::scalar,
          ColumnKind::measure,
          unit(field),
          description(field),
          false,
          true};
}

void resize_values(Ray& ray, const RayColumn& column, std::size_t count) {
  std::visit([&](auto member) { resize(ray, member, count); }, column.member);
}

Ray empty_ray(const DatabaseHeader& header, std::int32_t active, std::int32_t direction) {
  Ray ray;
  ray.active = active;
  ray.direction = direction;
  for (const auto& column : columns_of(header)) resize_values(ray, column, column.count);
  std::fill(ray.status.begin(), ray.status.end(), Status::not_requested);
  ray.end.reason = EndReason::not_requested;
  return ray;
}

namespace {

/// Whether values are within the bounds of a column's kind.
struct Possible {
  double least, most;

  Possible(ColumnKind kind, double farthest_m)
      : most(kind == ColumnKind::displacement ? farthest_m : std::numeric_limits<double>::max()) {
    least = kind == ColumnKind::count ? 0 : -most;
  }
  template <class T>
  bool operator()(T value) const {
    if constexpr (std::is_enum_v<T>)
      return name(value) != unknown;
    else
      return static_cast<double>(value) >= least && static_cast<double>(value) <= most;
  }
};

template <class T>
std::string tell(const StoredColumn& column, std::size_t increment, T value) {
  std::string number;
  if constexpr (std::is_enum_v<T>)
    number = std::to_string(static_cast<int>(value));
  else
    number = number_text(value);
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
