// A model in separately allocated memory, and claims about the result of every query.
#pragma once

#include <phynness/phynness.h>

#include <functional>
#include <memory>
#include <phynness/formats/model.hpp>

#include "fuzz_target.hpp"

namespace phynness::fuzz {

/// Bytes at any alignment that end where the heap's block ends, filled with what no number is.
class Memory {
 public:
  Memory(std::size_t bytes, std::size_t shift) : _all(new char[bytes + shift]), _bytes(bytes), _shift(shift) { fill(); }
  void fill() { std::memset(_all.get(), 0xff, _bytes + _shift); }
  char* data() const { return _all.get() + _shift; }
  std::size_t size() const { return _bytes; }

 private:
  std::unique_ptr<char[]> _all;
  std::size_t _bytes, _shift;
};

inline constexpr std::size_t largest_memory = std::size_t(1) << 26;

inline phn_info info_of(const phn_model* model) {
  phn_info info;
  phn_model_info(model, &info);
  return info;
}

/// Whether phynness.h names this status for a loader.
bool refusal_of_loader(int status);

/// Loads a text, or finds that it is refused, as it should be in every respect. @return null if it is
/// refused, or takes more than largest_memory
struct LoadedText {
  LoadedText(const char* text, std::size_t length, std::size_t shift);
  /// Of the memory: a model never changes. @pre model != nullptr
  std::uint64_t hash() const;

  std::unique_ptr<Memory> memory;
  const phn_model* model = nullptr;
  int status = PHN_OK;
};

/// Good models, each in a block of its own alignment.
class Models {
 public:
  Models(const std::vector<Model>& models, std::size_t shift);
  /// Asks the one that the script chooses, which never changes.
  void ask_one(Script& script, const std::function<void(const phn_model*)>& ask) const;

 private:
  std::vector<LoadedText> _all;
  std::vector<std::uint64_t> _hashes;
};

/// Claims of the accessors.
void look_at(const phn_model* model);

/// Reads calls from the script until it ends, at most `most` of them. Each is asked twice, of scratch in use
/// and of fresh scratch: answers must be the same to the last bit, defined, of a documented status, zeros
/// where it is negative.
/// @param trained  the model is one that training could have made: touched nodes move by exactly d
void ask(const phn_model* model, Script& script, bool trained, int most = 24);

}  // namespace phynness::fuzz
