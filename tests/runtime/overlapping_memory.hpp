// Calls functions of a C header with pointers to overlapping memory: the declarations of the header, and the roles of
// the arguments of each function.
#pragma once

#include <gtest/gtest.h>
#include <phynness/phynness.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace phynness::test {

/// Memory that a function is given. Of scratch, and of memory where an object is made, the contents do not
/// matter.
enum class Given { input, output, scratch, memory };

struct Argument {
  std::string name;  ///< as in the header
  Given given;
  std::vector<char> value;         ///< of inputs; what outputs of refused calls hold
  std::size_t align;               ///< of its elements
  std::vector<bool> padding = {};  ///< of outputs: bytes that hold nothing
};

template <class T>
Argument input(const char* name, const std::vector<T>& values) {
  const auto* bytes = reinterpret_cast<const char*>(values.data());
  return {name, Given::input, {bytes, bytes + values.size() * sizeof(T)}, alignof(T)};
}
/// @param refused  what each of the n is after a refused call; @param holes first byte of padding and the one
/// behind it
template <class T>
Argument output(const char* name, std::size_t n = 1, const T& refused = {},
                const std::vector<std::array<std::size_t, 2>>& holes = {}) {
  Argument result = input(name, std::vector<T>(n, refused));
  result.given = Given::output;
  result.padding.resize(result.value.size());
  for (const auto& [first, last] : holes) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = first; k < last; ++k) result.padding[i * sizeof(T) + k] = true;
  }
  return result;
}
template <class T>
Argument scratch(const char* name, std::size_t n) {
  return {name, Given::scratch, std::vector<char>(n * sizeof(T)), alignof(T)};
}
inline Argument memory(const char* name, std::size_t bytes) {
  return {name, Given::memory, std::vector<char>(bytes), 1};
}

/// One function with good arguments.
struct Row {
  std::string function;
  std::vector<Argument> arguments;
  std::function<int(const std::vector<char*>&)> call;  ///< takes the places of the arguments, in their order
  bool large_inputs = false;                           ///< inputs that are not copied: outputs over them are refused
};

template <class T>
T* as(char* place) {
  return reinterpret_cast<T*>(place);
}

/// Names of the pointers to memory in each function of a header, those to const ones after "const". Left out
/// are objects (phn_model and its like), functions, and what these are passed.
inline std::map<std::string, std::set<std::string>> pointers_of(const std::string& header) {
  std::ifstream file(header);
  std::stringstream stream;
  stream << file.rdbuf();
  std::string text = std::regex_replace(stream.str(), std::regex(R"(/\*[^*]*\*+([^/*][^*]*\*+)*/)"), " ");
  text = std::regex_replace(text, std::regex("\\s+"), " ");
  std::map<std::string, std::set<std::string>> functions;
  const std::regex declaration(R"(\b(phn_\w+) ?\(((?:[^();]|\([^()]*\))*)\) ?;)");
  for (std::sregex_iterator at(text.begin(), text.end(), declaration), end; at != end; ++at) {
    auto& pointers = functions[(*at)[1]];
    std::string list = std::regex_replace((*at)[2].str(), std::regex(R"(\w+ \(\*\w+\)\([^()]*\))"), "");
    std::stringstream parameters(list);
    for (std::string one; std::getline(parameters, one, ',');) {
      std::smatch part;
      if (!std::regex_match(one, part, std::regex(R"( ?(const )?(\w+) ?(\**) ?(\w+)(\[\d*\])? ?)"))) continue;
      const std::string stars = part[3].str() + (part[5].matched ? "*" : "");
      const std::regex object("phn_(model|data|surface|contact|imagef?)");
      if (stars.empty() || part[4] == "user" || (stars.size() == 1 && std::regex_match(part[2].str(), object)))
        continue;
      pointers.insert((part[1].matched && stars.size() == 1 ? "const " : "") + part[4].str());
    }
  }
  return functions;
}

/// Claim: the rows are all functions of the header that write memory and are given more of it, with all of
/// that.
inline void expect_rows_of_all_functions(const std::vector<Row>& rows, const std::string& header) {
  const auto functions = pointers_of(header);
  ASSERT_FALSE(functions.empty()) << header;
  for (const auto& [function, pointers] : functions) {
    const bool writes = std::any_of(pointers.begin(), pointers.end(),
                                    [](const auto& p) { return p[0] != 'c' || p.find("const ") != 0; });
    if (!writes || pointers.size() < 2) continue;
    const auto row =
        std::find_if(rows.begin(), rows.end(), [&name = function](const Row& r) { return r.function == name; });
    ASSERT_NE(row, rows.end()) << function << " of " << header << " has no row: add it to the table of this test";
  }
  for (const Row& row : rows) {
    const auto declared = functions.find(row.function);
    if (declared == functions.end()) continue;  // of another header
    std::set<std::string> names;
    for (const Argument& a : row.arguments) names.insert((a.given == Given::input ? "const " : "") + a.name);
    EXPECT_EQ(names, declared->second) << row.function;
  }
}

/// Calls one function with two of its arguments at all offsets from each other, the others apart.
class Overlaps {
 public:
  explicit Overlaps(const Row& row) : _row(row) {
    for (const Argument& a : row.arguments) _apart.emplace_back(a.value.size() + 2 * slack);
    _status = call(apart());
    for (std::size_t i = 0; i < row.arguments.size(); ++i) _expected.push_back(bytes(apart(), i));
  }

  /// Of the call whose arguments are apart.
  int status() const { return _status; }

  void check() {
    for (std::size_t a = 0; a < _row.arguments.size(); ++a) {
      for (std::size_t b = 0; b < _row.arguments.size(); ++b) {
        if (a == b || _row.arguments[b].given == Given::input) continue;
        if (_row.arguments[a].given != Given::input && a > b) continue;
        check_pair(a, b);
      }
    }
  }

 private:
  static constexpr std::size_t slack = 64;
  using Places = std::vector<char*>;

  static char* aligned(std::vector<char>& memory) {
    return memory.data() + (slack - reinterpret_cast<std::uintptr_t>(memory.data()) % slack) % slack;
  }
  std::size_t size(std::size_t i) const { return _row.arguments[i].value.size(); }
  Places apart() {
    Places places;
    for (auto& memory : _apart) places.push_back(aligned(memory));
    return places;
  }
  std::vector<char> bytes(const Places& places, std::size_t i) const { return {places[i], places[i] + size(i)}; }
  /// Fills outputs with rubbish, then inputs with their values.
  int call(const Places& places) const {
    for (std::size_t i = 0; i < places.size(); ++i) std::memset(places[i], 0x25, size(i));
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (_row.arguments[i].given == Given::input) std::memcpy(places[i], _row.arguments[i].value.data(), size(i));
    }
    return _row.call(places);
  }

  /// Whether an output is as expected but for padding, and where another one lies that may have been written
  /// later.
  bool holds(const Places& places, std::size_t i, const std::vector<char>& expected, std::size_t other) const {
    for (std::size_t k = 0; k < expected.size(); ++k) {
      const char* at = places[i] + k;
      const bool hidden = other != i && at >= places[other] && at < places[other] + size(other);
      if (!_row.arguments[i].padding[k] && !hidden && *at != expected[k]) return false;
    }
    return true;
  }

  /// `b` slides over `a`, from just before it to just behind it.
  void check_pair(std::size_t a, std::size_t b) {
    const Argument &fixed = _row.arguments[a], &sliding = _row.arguments[b];
    const std::size_t align = sliding.align;
    const std::size_t before = (size(b) + slack - 1) / slack * slack, behind = (size(a) + align - 1) / align * align;
    const std::size_t step = std::max(align, (before + behind) / 50 / align * align);
    std::vector<char> both(before + behind + size(b) + 2 * slack);
    std::vector<std::size_t> offsets = {before, before + behind};
    for (std::size_t offset = 0; offset < before + behind; offset += step) offsets.push_back(offset);
    for (const std::size_t offset : offsets) {
      Places places = apart();
      places[a] = aligned(both) + before;
      places[b] = aligned(both) + offset;
      const bool overlaps = size(a) > 0 && size(b) > 0 && offset + size(b) > before && offset < before + size(a);
      const bool refused =
          overlaps && (fixed.given != Given::input || sliding.given == Given::memory || _row.large_inputs);
      SCOPED_TRACE(_row.function + ": " + sliding.name + " begins " + std::to_string(offset) + " - " +
                   std::to_string(before) + " bytes behind " + fixed.name);
      const int status = call(places);
      EXPECT_EQ(status, refused ? PHN_ERROR_OVERLAP : _status);
      // An object that is made elsewhere has another address.
      const bool moved = sliding.given == Given::memory || fixed.given == Given::memory;
      for (std::size_t i = 0; i < places.size() && (refused || !moved); ++i) {
        if (_row.arguments[i].given != Given::output) continue;
        const std::size_t hidden_by = i == a ? b : i == b && refused ? a : i;
        EXPECT_TRUE(holds(places, i, refused ? _row.arguments[i].value : _expected[i], hidden_by))
            << _row.arguments[i].name;
      }
      if (::testing::Test::HasFailure()) return;
    }
  }

  const Row& _row;
  std::vector<std::vector<char>> _apart, _expected;
  int _status = 0;
};

}  // namespace phynness::test
