// The columns that a database has, and access to their values in a Ray. A function that handles every column visits
// StoredColumn::member with a generic lambda and calls values_of() there.
#pragma once

#include <cstddef>
#include <phynness/formats/database.hpp>
#include <span>
#include <string>
#include <vector>

namespace phynness {

/// A column with what the header of a database determines.
struct StoredColumn : RayColumn {
  std::string path;                ///< of the dataset
  std::vector<std::size_t> shape;  ///< of one ray, without the axes of active nodes and directions
  std::size_t count = 1;           ///< values of one ray
};

std::vector<StoredColumn> columns_of(const DatabaseHeader& header);
/// Those of them with one value for each `of`.
std::vector<StoredColumn> columns_of(const DatabaseHeader& header, ColumnOf of);

/// The names of fields, with `joint` between them.
std::string names(const std::vector<Field>& fields, const char* joint);

/// The values of a column in one ray: a span of Status, EndReason, std::int32_t or double.
template <class AnyRay, class T>
auto values_of(AnyRay& ray, std::vector<T> Ray::*member) {
  return std::span((ray.*member).data(), (ray.*member).size());
}
template <class AnyRay, class T>
auto values_of(AnyRay& ray, T RayEnd::*member) {
  return std::span(&(ray.end.*member), 1);
}
template <class AnyRay>
auto values_of(AnyRay& ray, RayColumn::FieldIndex field) {
  return std::span(ray.fields[field.index].data(), ray.fields[field.index].size());
}
/// Type of the values of a column.
template <class Member>
using ValueOf = typename decltype(values_of(std::declval<Ray&>(), Member{}))::value_type;

/// Makes room for `count` values of a column; those that are added are zero, and the end of the ray becomes zero.
void resize_values(Ray& ray, const RayColumn& column, std::size_t count);

}  // namespace phynness
