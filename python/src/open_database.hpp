// A database that can be closed. HDF5 may not be thread-safe: all reading is done with the GIL held.
#pragma once

#include <phynness/formats/database.hpp>
#include <phynness/formats/imported.hpp>

#include <memory>
#include <vector>

#include "arrays.hpp"

namespace phynness::python {

/// A copy of n x columns numbers.
template <class T>
py::array_t<T> copy(const T* numbers, py::ssize_t n, py::ssize_t columns = 0) {
  return columns == 0 ? py::array_t<T>({n}, numbers) : py::array_t<T>({n, columns}, numbers);
}
template <class T>
py::array_t<T> copy(const std::vector<T>& numbers) {
  return copy(numbers.data(), std::ssize(numbers));
}
/// Vectors of responses, n x 3. @throws Error of Python if they are too many to be copied
inline Points points_of(const py::object& given, const char* name) {
  const Vectors vectors(given, name);
  if (vectors.size() > most_imported_rows * 10)
    raise(std::string(name) + " have too many rows: " + std::to_string(vectors.size()) +
          "\n  remedy: give every n-th row; of each node at most 600 are fitted");
  Points points(vectors.size(), 3);
  double x[3];
  for (py::ssize_t i = 0; i < points.rows(); ++i) {
    vectors.get(i, x);
    points.row(i) << x[0], x[1], x[2];
  }
  return points;
}

class OpenDatabase {
 public:
  explicit OpenDatabase(const py::object& path) : _path(path_of(path)) {
    _database = std::make_shared<const Database>(Database::open(_path));
  }
  void close() { _database.reset(); }
  const std::shared_ptr<const Database>& get() const {
    if (!_database) raise("the database " + _path.string() + " is closed");
    return _database;
  }
  const DatabaseHeader& header() const { return get()->header(); }
  const std::filesystem::path& path() const { return _path; }

 private:
  std::filesystem::path _path;
  std::shared_ptr<const Database> _database;
};

}  // namespace phynness::python
