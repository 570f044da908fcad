// Access to the parts of a Model for the grammar of models (phynness/schema/model_grammar.hpp): vectors and Eigen
// matrices by row and column.
#pragma once

#include <algorithm>
#include <cstdint>
#include <phynness/formats/model.hpp>
#include <vector>

namespace phynness {

/// A base of the `io` of the grammar. The text functions are those of a writer.
class ModelStores {
 public:
  void room(const char*, std::uint64_t) {}
  bool optional(const char*, bool present) { return present; }
  static constexpr bool good() { return true; }
  template <class T>
  void done(const T&) {}
  static bool has_place(const Model& model, std::int32_t node) {
    const auto is_in = [node](const auto& nodes) { return std::binary_search(nodes.begin(), nodes.end(), node); };
    return is_in(model.output) || is_in(model.fixed);
  }
  static bool has_output(const Model& model, std::int32_t node) {
    return std::binary_search(model.output.begin(), model.output.end(), node);
  }
  template <class Store>
  auto get(const Store& store, std::int64_t i, std::int64_t k) const {
    return cell(store, i, k);
  }
  template <class Store, class T>
  void set(const Store&, std::int64_t, std::int64_t, T) {}

  template <class T>
  static std::int64_t rows(const std::vector<T>& list) {
    return static_cast<std::int64_t>(list.size());
  }
  static std::int64_t rows(const Vec3&) { return 3; }
  template <class Matrix>
  static std::int64_t rows(const Eigen::DenseBase<Matrix>& matrix) {
    return matrix.rows();
  }
  template <class T>
  static std::int64_t cols(const std::vector<T>&) {
    return 1;
  }
  static std::int64_t cols(const std::vector<Vec3>&) { return 3; }
  static std::int64_t cols(const Vec3&) { return 1; }
  template <class Matrix>
  static std::int64_t cols(const Eigen::DenseBase<Matrix>& matrix) {
    return matrix.cols();
  }

  template <class T>
  static T& item(std::vector<T>& list, std::int64_t i) {
    return list[static_cast<std::size_t>(i)];
  }
  template <class T>
  static const T& item(const std::vector<T>& list, std::int64_t i) {
    return list[static_cast<std::size_t>(i)];
  }

 protected:
  template <class List>
  static auto& cell(List& list, std::int64_t i, std::int64_t k) {
    if constexpr (std::is_same_v<std::remove_const_t<List>, std::vector<Vec3>>)
      return list[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
    else if constexpr (requires { list.rows(); })
      return list(i, k);
    else
      return list[static_cast<std::size_t>(i)];
  }

  template <class T>
  static void resize(std::vector<T>& list, std::int64_t n, std::int64_t) {
    list.resize(static_cast<std::size_t>(n));
  }
  static void resize(Vec3&, std::int64_t, std::int64_t) {}
  template <class Matrix>
  static void resize(Eigen::PlainObjectBase<Matrix>& matrix, std::int64_t rows, std::int64_t cols) {
    matrix.resize(rows, cols);
  }
};

}  // namespace phynness
