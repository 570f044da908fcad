#include "multifrontal.hpp"

#include <metis.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <string>

extern "C" {
void dgemm_(const char*, const char*, const int*, const int*, const int*, const double*, const double*, const int*,
            const double*, const int*, const double*, double*, const int*);
void dtrsm_(const char*, const char*, const char*, const char*, const int*, const int*, const double*, const double*,
            const int*, double*, const int*);
void dtrsv_(const char*, const char*, const char*, const int*, const double*, const int*, double*, const int*);
void dgemv_(const char*, const int*, const int*, const double*, const double*, const int*, const double*, const int*,
            const double*, double*, const int*);
}

namespace phynness {
namespace {

// Columns of a block of pivots, and of a block of the update of the rest.
constexpr int pivot_block = 32, update_block = 96;

/// C -= A B^T
void subtract_product(int rows, int columns, int depth, const double* A, int lda, const double* B, int ldb, double* C,
                      int ldc) {
  if (rows <= 0 || columns <= 0 || depth <= 0) return;
  const double minus = -1, one = 1;
  dgemm_("N", "T", &rows, &columns, &depth, &minus, A, &lda, B, &ldb, &one, C, &ldc);
}

/// Whether a front of this many pivots may hold this fraction of zeros in its columns of L.
bool few_zeros(double zeros, double entries, int pivots) {
  const double fraction = zeros / entries;
  return fraction < 0.05 || (pivots < 96 && fraction < 0.1) || (pivots < 32 && fraction < 0.3) ||
         (pivots < 16 && fraction < 0.8);
}

double entries_of(double size, double pivots) { return size * pivots - pivots * (pivots - 1) / 2; }

}  // namespace

/// Rows with the same pattern, in the order of elimination.
struct Multifrontal::Groups {
  std::vector<std::vector<int>> rows;       ///< rows of A of each group
  std::vector<std::vector<int>> structure;  ///< groups below the diagonal of L
  int weight(int group) const { return static_cast<int>(rows[group].size()); }

  Groups(std::span<const std::int32_t> row_start, std::span<const std::int32_t> column) {
    const int n = static_cast<int>(row_start.size()) - 1;
    const auto pattern = [&](int i) { return column.subspan(row_start[i], row_start[i + 1] - row_start[i]); };
    std::vector<int> group(n, -1), head;
    for (int i = 0; i < n; ++i) {
      for (const int j : pattern(i)) {
        if (j >= i) break;
        if (head[group[j]] == j && std::ranges::equal(pattern(i), pattern(j))) {
          group[i] = group[j];
          break;
        }
      }
      if (group[i] >= 0) continue;
      group[i] = static_cast<int>(head.size());
      head.push_back(i);
    }
    idx_t m = static_cast<idx_t>(head.size());
    std::vector<idx_t> start{0}, neighbour, weight(m, 0), order(m), place(m);
    for (int i = 0; i < n; ++i) ++weight[group[i]];
    for (int g = 0; g < m; ++g) {
      for (const int j : pattern(head[g]))
        if (group[j] != g && head[group[j]] == j) neighbour.push_back(group[j]);
      start.push_back(static_cast<idx_t>(neighbour.size()));
    }
    std::iota(order.begin(), order.end(), 0);
    place = order;
    // Refinement of both sides at once leaves smaller separators: 5 to 15 % fewer operations.
    idx_t options[METIS_NOPTIONS];
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_RTYPE] = METIS_RTYPE_SEP2SIDED;
    if (!neighbour.empty()) {
      // While METIS works, it has its own handler of SIGTERM, which ends the ordering with an error.
      sigset_t termination, before;
      sigemptyset(&termination);
      sigaddset(&termination, SIGTERM);
      pthread_sigmask(SIG_BLOCK, &termination, &before);
      const int status =
          METIS_NodeND(&m, start.data(), neighbour.data(), weight.data(), options, order.data(), place.data());
      pthread_sigmask(SIG_SETMASK, &before, nullptr);
      if (status != METIS_OK)
        throw failure("METIS could not order the unknowns of a tangent", std::to_string(n) + " unknowns",
                      "usually the memory is too small: use fewer ranks on each machine");
    }
    rows.resize(m);
    structure.resize(m);
    for (int i = 0; i < n; ++i) rows[place[group[i]]].push_back(i);
    std::vector<std::vector<int>> children(m);
    std::vector<int> seen(m, -1);
    for (int p = 0; p < m; ++p) {
      auto& own = structure[p];
      seen[p] = p;
      const auto add = [&](int q) {
        if (q < p || seen[q] == p) return;
        seen[q] = p;
        own.push_back(q);
      };
      for (auto k = start[order[p]]; k < start[order[p] + 1]; ++k) add(place[neighbour[k]]);
      for (const int child : children[p])
        for (const int q : structure[child]) add(q);
      std::sort(own.begin(), own.end());
      if (!own.empty()) children[own.front()].push_back(p);
    }
  }
};

Multifrontal::Multifrontal(std::span<const std::int32_t> row_start, std::span<const std::int32_t> column) {
  build_fronts(Groups(row_start, column));
  find_entries(row_start, column);
}

void Multifrontal::build_fronts(const Groups& groups) {
  const int m = static_cast<int>(groups.rows.size());
  struct Node {
    std::vector<int> members, children;
    int pivots = 0, size = 0;
    double zeros = 0;
  };
  std::vector<Node> nodes(m);
  std::vector<int> roots;
  for (int p = 0; p < m; ++p) {
    auto& node = nodes[p];
    node.pivots = node.size = groups.weight(p);
    for (const int q : groups.structure[p]) node.size += groups.weight(q);
    // Children that fill most of the front first.
    std::ranges::sort(node.children, [&](int a, int b) { return nodes[a].size > nodes[b].size; });
    std::vector<int> kept;
    for (const int c : node.children) {
      auto& child = nodes[c];
      const int pivots = node.pivots + child.pivots, size = node.size + child.pivots;
      const double entries = entries_of(size, pivots);
      const double zeros = node.zeros + child.zeros + entries - entries_of(node.size, node.pivots) -
                           entries_of(child.size, child.pivots);
      if (!few_zeros(zeros, entries, pivots)) {
        kept.push_back(c);
        continue;
      }
      node.pivots = pivots;
      node.size = size;
      node.zeros = zeros;
      node.members.insert(node.members.end(), child.members.begin(), child.members.end());
      kept.insert(kept.end(), child.children.begin(), child.children.end());
      child = {};
    }
    node.children = std::move(kept);
    node.members.push_back(p);
    if (groups.structure[p].empty())
      roots.push_back(p);
    else
      nodes[groups.structure[p].front()].children.push_back(p);
  }
  // In postorder, so that the rests of the children of a front are the topmost of their stack.
  std::vector<int> start_of(m), front_of(m, -1);
  struct Visit {
    int node, level;
    std::size_t next;
    std::vector<int> children;
  };
  for (const int root : roots) {
    std::vector<Visit> path;
    path.push_back({root, 0, 0, {}});
    while (!path.empty()) {
      auto& visit = path.back();
      auto& node = nodes[visit.node];
      if (visit.next < node.children.size()) {
        path.push_back({node.children[visit.next++], visit.level + 1, 0, {}});
        continue;
      }
      std::sort(node.members.begin(), node.members.end());
      Front front{static_cast<int>(_order.size()), node.pivots, node.size, visit.level, 0, 0, {}, {}, visit.children};
      for (const int g : node.members) {
        start_of[g] = static_cast<int>(_order.size());
        _order.insert(_order.end(), groups.rows[g].begin(), groups.rows[g].end());
      }
      front_of[visit.node] = static_cast<int>(_fronts.size());
      _fronts.push_back(std::move(front));
      path.pop_back();
      if (!path.empty()) path.back().children.push_back(static_cast<int>(_fronts.size()) - 1);
    }
  }
  std::size_t size = 0, widest = 0, top[2] = {0, 0}, most[2] = {0, 0};
  for (int p = 0; p < m; ++p) {
    if (front_of[p] < 0) continue;
    auto& front = _fronts[front_of[p]];
    for (const int g : groups.structure[p])
      for (int k = 0; k < groups.weight(g); ++k) front.row.push_back(start_of[g] + k);
    std::sort(front.row.begin(), front.row.end());
  }
  for (auto& front : _fronts) {
    front.factors = size;
    size += static_cast<std::size_t>(front.size) * front.pivots;
    widest = std::max(widest, static_cast<std::size_t>(front.size) * front.pivots);
    for (const int c : front.children) {
      auto& child = _fronts[c];
      for (const int row : child.row)
        child.place.push_back(row < front.first + front.pivots
                                  ? row - front.first
                                  : front.pivots +
                                        static_cast<int>(std::ranges::lower_bound(front.row, row) - front.row.begin()));
    }
    const int parity = front.level % 2;
    top[parity] += static_cast<std::size_t>(front.rest()) * front.rest();
    most[parity] = std::max(most[parity], top[parity]);
    for (const int c : front.children)
      top[1 - parity] -= static_cast<std::size_t>(_fronts[c].rest()) * _fronts[c].rest();
  }
  _factors.resize(size);
  _scaled.resize(widest);
  for (const int parity : {0, 1}) _stack[parity].resize(most[parity]);
  _x.resize(_order.size());
  _below.resize(_order.size());
}

void Multifrontal::find_entries(std::span<const std::int32_t> row_start, std::span<const std::int32_t> column) {
  std::vector<int> place(_order.size());
  for (std::size_t k = 0; k < _order.size(); ++k) place[_order[k]] = static_cast<int>(k);
  for (auto& front : _fronts) {
    for (int c = 0; c < front.pivots; ++c) {
      const int i = _order[front.first + c];
      for (auto k = row_start[i]; k < row_start[i + 1]; ++k) {
        const int row = place[column[k]];
        if (row < front.first + c) continue;
        const auto r = row < front.first + front.pivots
                           ? row - front.first
                           : front.pivots + (std::ranges::lower_bound(front.row, row) - front.row.begin());
        _entries.push_back({k, front.factors + static_cast<std::size_t>(c) * front.size + r});
      }
    }
    front.last_entry = _entries.size();
  }
}

bool Multifrontal::factorize(std::span<const double> values) {
  _negative = 0;
  _top[0] = _top[1] = 0;
  std::size_t k = 0;
  for (auto& front : _fronts) {
    std::fill_n(_factors.data() + front.factors, static_cast<std::size_t>(front.size) * front.pivots, 0.0);
    for (; k < front.last_entry; ++k) _factors[_entries[k].to] = values[_entries[k].from];
    const int parity = front.level % 2;
    double* rest = _stack[parity].data() + _top[parity];
    gather(front, _stack[1 - parity], rest);
    if (!eliminate(front, rest)) return false;
    _top[parity] += static_cast<std::size_t>(front.rest()) * front.rest();
  }
  return true;
}

/// Adds the rests of the children.
void Multifrontal::gather(Front& front, std::vector<double>& from, double* rest) {
  const int below = front.rest();
  for (int j = 0; j < below; ++j) std::fill_n(rest + static_cast<std::size_t>(j) * below + j, below - j, 0.0);
  auto& top = _top[1 - front.level % 2];
  for (auto c = front.children.rbegin(); c != front.children.rend(); ++c) {
    const auto& child = _fronts[*c];
    const int n = child.rest();
    top -= static_cast<std::size_t>(n) * n;
    const int* place = child.place.data();
    for (int j = 0; j < n; ++j) {
      const double* source = from.data() + top + static_cast<std::size_t>(j) * n;
      const int t = place[j];
      double* target = t < front.pivots ? _factors.data() + front.factors + static_cast<std::size_t>(t) * front.size
                                        : rest + static_cast<std::size_t>(t - front.pivots) * below - front.pivots;
      for (int i = j; i < n; ++i) target[place[i]] += source[i];
    }
  }
}

bool Multifrontal::eliminate(Front& front, double* rest) {
  const int m = front.size, n = front.pivots, below = front.rest();
  double* L = _factors.data() + front.factors;
  const double one = 1;
  for (int k = 0; k < n; k += pivot_block) {
    const int width = std::min(pivot_block, n - k);
    double* block = L + static_cast<std::size_t>(k) * m + k;
    for (int c = 0; c < width; ++c) {
      double* column = block + static_cast<std::size_t>(c) * m;
      const double pivot = column[c];
      if (!(std::abs(pivot) > 0) || !std::isfinite(pivot)) return false;
      _negative += pivot < 0;
      for (int j = c + 1; j < width; ++j) {
        const double factor = column[j] / pivot;
        double* target = block + static_cast<std::size_t>(j) * m;
        for (int i = j; i < width; ++i) target[i] -= factor * column[i];
      }
      for (int j = c + 1; j < width; ++j) column[j] /= pivot;
    }
    const int after = m - k - width;
    if (after == 0) break;
    double* under = block + width;
    dtrsm_("R", "L", "T", "U", &after, &width, &one, block, &m, under, &m);
    double* scaled = _scaled.data() + static_cast<std::size_t>(k) * m + k + width;
    for (int c = 0; c < width; ++c) {
      const double inverse = 1 / block[static_cast<std::size_t>(c) * m + c];
      double* column = under + static_cast<std::size_t>(c) * m;
      double* copy = scaled + static_cast<std::size_t>(c) * m;
      for (int i = 0; i < after; ++i) {
        copy[i] = column[i];
        column[i] *= inverse;
      }
    }
    for (int j = k + width; j < n; j += update_block) {
      const int columns = std::min(update_block, n - j);
      subtract_product(m - j, columns, width, L + static_cast<std::size_t>(k) * m + j, m,
                       _scaled.data() + static_cast<std::size_t>(k) * m + j, m, L + static_cast<std::size_t>(j) * m + j,
                       m);
    }
  }
  for (int j = 0; j < below; j += update_block)
    subtract_product(below - j, std::min(update_block, below - j), n, L + n + j, m, _scaled.data() + n + j, m,
                     rest + static_cast<std::size_t>(j) * below + j, below);
  return true;
}

void Multifrontal::solve(std::span<const double> b, std::span<double> x) {
  const int step = 1;
  const double one = 1, minus = -1, zero = 0;
  for (std::size_t i = 0; i < _order.size(); ++i) _x[i] = b[_order[i]];
  for (const auto& front : _fronts) {
    const double* L = _factors.data() + front.factors;
    double* own = _x.data() + front.first;
    const int below = front.rest();
    dtrsv_("L", "N", "U", &front.pivots, L, &front.size, own, &step);
    if (below > 0) {
      dgemv_("N", &below, &front.pivots, &one, L + front.pivots, &front.size, own, &step, &zero, _below.data(), &step);
      for (int i = 0; i < below; ++i) _x[front.row[i]] -= _below[i];
    }
    for (int i = 0; i < front.pivots; ++i) own[i] /= L[static_cast<std::size_t>(i) * front.size + i];
  }
  for (auto f = _fronts.rbegin(); f != _fronts.rend(); ++f) {
    const auto& front = *f;
    const double* L = _factors.data() + front.factors;
    double* own = _x.data() + front.first;
    const int below = front.rest();
    if (below > 0) {
      for (int i = 0; i < below; ++i) _below[i] = _x[front.row[i]];
      dgemv_("T", &below, &front.pivots, &minus, L + front.pivots, &front.size, _below.data(), &step, &one, own, &step);
    }
    dtrsv_("L", "T", "U", &front.pivots, L, &front.size, own, &step);
  }
  for (std::size_t i = 0; i < _order.size(); ++i) x[_order[i]] = _x[i];
}

}  // namespace phynness
