// Texts with a checksum at their end, model.txt and mesh.txt, and functions that change texts.
#pragma once

#include <algorithm>
#include <phynness/formats/hash.hpp>

#include "fuzz_target.hpp"

namespace phynness::fuzz {

/// The text with the checksum that belongs to it, whatever stood there.
inline std::string sealed(std::string_view text) {
  const std::size_t last = text.rfind("checksum ");
  std::string body(text.substr(0, last));
  return body + "checksum " + hash_of(body) + "\n";
}

/// The words between the bars of a list.
inline std::vector<std::string_view> words_of(std::string_view list) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at <= list.size(); at += words.back().size() + 1)
    words.push_back(list.substr(at, list.find('|', at) - at));
  return words;
}

/// Changes lines, words and counts of a text so that much of it remains what a reader expects.
class TextMutator {
 public:
  TextMutator(std::string text, Random& random, const std::vector<std::string_view>& words)
      : _text(std::move(text)), _random(random), _words(words) {}

  std::string changed() {
    switch (_random.below(8)) {
      case 0:
        swap_lines();
        break;
      case 1:
      case 2:
        copy_line(_random.below(2) == 0);
        break;
      case 3:
        drop_line(_random.below(2) == 0);
        break;
      default:
        replace_word();
    }
    return _text;
  }

 private:
  std::string word() {
    if (_random.below(3) > 0 || _text.empty()) return std::string(_words[_random.below(_words.size())]);
    const auto [from, to] = word_at(_random.below(_text.size()));
    return _text.substr(from, to - from);
  }
  std::pair<std::size_t, std::size_t> word_at(std::size_t at) const {
    const auto part = [this](std::size_t i) {
      return std::string_view(" \n,=[]{}\"").find(_text[i]) == std::string::npos;
    };
    std::size_t from = at, to = at;
    while (from > 0 && part(from - 1)) --from;
    while (to < _text.size() && part(to)) ++to;
    return {from, to};
  }
  std::pair<std::size_t, std::size_t> line_at(std::size_t at) const {
    const std::size_t before = at == 0 ? std::string::npos : _text.rfind('\n', at - 1), end = _text.find('\n', at);
    return {before == std::string::npos ? 0 : before + 1, end == std::string::npos ? _text.size() : end + 1};
  }

  void replace_word() {
    if (_text.empty()) return;
    const auto [from, to] = word_at(_random.below(_text.size()));
    _text.replace(from, to - from, word());
  }
  void swap_lines() {
    if (_text.empty()) return;
    const auto a = line_at(_random.below(_text.size())), b = line_at(_random.below(_text.size()));
    if (a.second > b.first) return;
    const std::string first = _text.substr(a.first, a.second - a.first),
                      second = _text.substr(b.first, b.second - b.first);
    _text.replace(b.first, second.size(), first);
    _text.replace(a.first, first.size(), second);
  }
  void copy_line(bool counted) {
    if (_text.empty()) return;
    const auto [from, to] = line_at(_random.below(_text.size()));
    const std::string line = _text.substr(from, to - from);
    const std::size_t at = counted ? from : line_at(_random.below(_text.size())).first;
    _text.insert(at, line);
    if (counted) count_before(at, 1);
  }
  void drop_line(bool counted) {
    if (_text.empty()) return;
    const auto [from, to] = line_at(_random.below(_text.size()));
    _text.erase(from, to - from);
    if (counted) count_before(from, -1);
  }
  /// The nearest line before, "word number", counts the lines that follow it.
  void count_before(std::size_t at, int change) {
    while (at > 0) {
      const auto [from, to] = line_at(at - 1);
      const std::size_t space = _text.find(' ', from);
      if (space < to && _text[from] >= 'a' && _text[from] <= 'z' && _text[space + 1] >= '0' &&
          _text[space + 1] <= '9') {
        const std::size_t end = std::min(_text.find_first_not_of("0123456789", space + 1), _text.size());
        const auto count =
            std::strtoull(_text.c_str() + space + 1, nullptr, 10) + static_cast<unsigned long long>(change);
        _text.replace(space + 1, end - space - 1, std::to_string(count));
        return;
      }
      at = from;
    }
  }

  std::string _text;
  Random& _random;
  const std::vector<std::string_view>& _words;
};

/// LLVMFuzzerCustomMutator of an input that is a text behind `prologue` bytes.
inline std::size_t change_text(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed,
                               std::size_t prologue, const std::vector<std::string_view>& words) {
  Random random(seed);
  if (size <= prologue || random.below(4) == 0) return LLVMFuzzerMutate(data, size, max_size);
  std::string text(data + prologue, data + size);
  for (std::size_t n = random.below(3) + 1; n > 0; --n) text = TextMutator(std::move(text), random, words).changed();
  text.resize(std::min(text.size(), max_size - prologue));
  std::copy(text.begin(), text.end(), data + prologue);
  return prologue + text.size();
}

}  // namespace phynness::fuzz
