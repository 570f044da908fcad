// Texts in memory of the caller: the part of the `io` of a grammar that reads lines
// (phynness/schema/model_grammar.hpp), and the common parts of the functions _size and _init of each kind of text.
#pragma once

#include <phynness/schema/text_reader.hpp>

#include "core/arena.hpp"
#include "core/lookup.hpp"

namespace PHN_RUNTIME {

using schema::TextReader;

class LinesReader {
 public:
  explicit LinesReader(TextReader& in) : _in(in) {}

  void keyword(const char* word) { _in.keyword(word); }
  void end() { _in.end_line(); }
  void real(const char*, double& value, const schema::Bound& bound) {
    const double read = _in.real();
    require(read >= bound.low && read <= bound.high, nullptr);
    if (good()) value = read;
  }
  void integer(const char*, std::int32_t& value, std::int32_t low, std::int32_t high) {
    const std::int32_t read = _in.integer(low, high);
    if (good()) value = read;
  }
  void count(const char*, std::int32_t& n, std::int32_t low) { n = _in.count(low); }
  void room(const char*, std::uint64_t n) { _in.require_room(n); }
  bool optional(const char* word, bool) { return good() && _in.next_is(word); }
  void require(bool condition, const char*) {
    if (!condition) _in.fail(PHN_ERROR_RANGE);
  }
  bool good() const { return _in.good(); }
  template <class Store>
  static double get(const Store&, std::int64_t, std::int64_t) {
    return 0;
  }

 protected:
  TextReader& _in;
};

/// The Prony series of a model or a body.
struct RelaxationStore {
  struct Terms {
    phn_relaxation& made;
    std::int32_t& n = made.n_terms;
    std::int64_t rows() const { return n; }
    template <class Memory>
    void shape(Memory&, std::int64_t rows, std::int64_t) {
      n = static_cast<std::int32_t>(rows);
    }
    void set(std::int64_t i, std::int64_t k, double value) { (k == 0 ? made.g : made.tau_s)[i] = value; }
    template <class Memory>
    void set(Memory&, std::int64_t i, std::int64_t k, double value) {
      set(i, k, value);
    }
  } terms;
  double& length_m = terms.made.length_m;
};

/// Reads a text into an arena. @return a status of phynness.h; *result is null on failure and when only counting
template <class T>
using LoadText = int (*)(const char* text, std::size_t length, Arena& arena, const T** result, std::size_t& wrong_byte);

template <class T>
int size_of_text(LoadText<T> load, const char* text, std::size_t length, std::size_t* bytes, std::size_t* wrong_byte) {
  Arena arena;
  const T* none = nullptr;
  std::size_t wrong = 0;
  int status = PHN_ERROR_ARGUMENT;
  if (overlap(bytes, sizeof *bytes, wrong_byte, sizeof *wrong_byte)) {
    status = PHN_ERROR_OVERLAP;
  } else if (text != nullptr && bytes != nullptr) {
    status = load(text, length, arena, &none, wrong);
    if (arena.overflow()) status = PHN_ERROR_TOO_LARGE;
  }
  if (bytes != nullptr) *bytes = status == PHN_OK ? arena.needed() : 0;
  if (wrong_byte != nullptr) *wrong_byte = wrong;
  return status;
}

template <class T>
int init_of_text(LoadText<T> load, void* memory, std::size_t bytes, const char* text, std::size_t length,
                 const T** result, std::size_t* wrong_byte) {
  const T* loaded = nullptr;
  std::size_t wrong = 0;
  int status = PHN_ERROR_ARGUMENT;
  if (overlap(memory, bytes, text, length) || overlap(memory, bytes, result, sizeof *result) ||
      overlap(memory, bytes, wrong_byte, sizeof *wrong_byte) ||
      overlap(result, sizeof *result, wrong_byte, sizeof *wrong_byte)) {
    status = PHN_ERROR_OVERLAP;
  } else if (memory != nullptr && text != nullptr && result != nullptr) {
    Arena arena(memory, bytes);
    status = load(text, length, arena, &loaded, wrong);
  }
  if (result != nullptr) *result = loaded;
  if (wrong_byte != nullptr) *wrong_byte = wrong;
  return status;
}

}  // namespace PHN_RUNTIME
