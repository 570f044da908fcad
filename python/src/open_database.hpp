// A database that can be closed. HDF5 may not be thread-safe: all reading is done with the GIL held.
#pragma once

#include <phynness/formats/database.hpp>

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
