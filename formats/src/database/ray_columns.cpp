#include "ray_columns.hpp"

#include <algorithm>
#include <functional>
#include <numeric>

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

template <class Code, std::size_t n>
CodeRow<Code> row_of(const CodeRow<Code> (&rows)[n], Code code) {
  const auto found = std::find_if(rows, rows + n, [code](const auto& row) { return row.code == code; });
  return found == rows + n ? CodeRow<Code>{code, "unknown", "unknown"} : *found;
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
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    const Field field = header.fields[i];
    columns.push_back(stored({RayColumn::FieldIndex{i}, name(field), ColumnOf::output_node, Tensor::scalar, unit(field),
                              description(field), false, true},
                             header, "/responses/fields/"));
  }
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

}  // namespace phynness
