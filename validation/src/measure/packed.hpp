// Serialization of records as numbers, which ranks exchange.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <phynness/formats/mesh.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace phynness {

/// Appends a record. A record is a trivially copyable value, a vector of records, Points, or a struct with
/// members(record, each), which calls each(member, ...) with all members.
template <class T>
void pack(std::vector<double>& rows, const T& record) {
  if constexpr (requires { T::members(record, [](auto&&...) {}); }) {
    T::members(record, [&](const auto&... member) { (pack(rows, member), ...); });
  } else if constexpr (std::is_same_v<T, Points>) {
    pack(rows, std::vector<double>(record.data(), record.data() + record.size()));
  } else if constexpr (requires { typename T::allocator_type; }) {
    rows.push_back(static_cast<double>(record.size()));
    for (const auto& one : record) pack(rows, one);
  } else {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::size_t at = rows.size();
    rows.resize(at + (sizeof(T) + sizeof(double) - 1) / sizeof(double));
    std::memcpy(&rows[at], &record, sizeof(T));
  }
}

/// Reads a record. @param at  is advanced to the next record
template <class T>
void unpack(const double*& at, T& record) {
  if constexpr (requires { T::members(record, [](auto&&...) {}); }) {
    T::members(record, [&](auto&... member) { (unpack(at, member), ...); });
  } else if constexpr (std::is_same_v<T, Points>) {
    std::vector<double> all;
    unpack(at, all);
    record = Eigen::Map<const Points>(all.data(), static_cast<Eigen::Index>(all.size()) / 3, 3);
  } else if constexpr (requires { typename T::allocator_type; }) {
    record.resize(static_cast<std::size_t>(*at++));
    for (auto& one : record) unpack(at, one);
  } else {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(static_cast<void*>(&record), at, sizeof(T));
    at += (sizeof(T) + sizeof(double) - 1) / sizeof(double);
  }
}

/// All records of these rows.
template <class T>
std::vector<T> unpacked(const std::vector<double>& rows) {
  std::vector<T> records;
  for (const double *at = rows.data(), *end = at + rows.size(); at != end;) unpack(at, records.emplace_back());
  return records;
}

/// Records that are gathered from all ranks in a given order.
template <class T>
class OrderedRows {
 public:
  using Order = std::array<double, 2>;

  void add(const Order& order, const T& record) {
    pack(_rows, order);
    pack(_rows, record);
  }
  /// The sorted records of all ranks on rank 0; empty on other ranks. Collective.
  std::vector<T> gathered(const SolverSession& session) const {
    const auto rows = session.gather(_rows);
    std::vector<std::pair<Order, T>> all;
    for (const double *at = rows.data(), *end = at + rows.size(); at != end;) {
      auto& [order, record] = all.emplace_back();
      unpack(at, order);
      unpack(at, record);
    }
    std::ranges::stable_sort(all, {}, &std::pair<Order, T>::first);
    std::vector<T> records;
    for (auto& one : all) records.push_back(std::move(one.second));
    return records;
  }

 private:
  std::vector<double> _rows;
};

}  // namespace phynness
