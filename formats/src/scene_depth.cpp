#include "scene_depth.hpp"

#include <algorithm>
#include <vector>

namespace phynness::scene_detail {
namespace {

class DepthScan {
 public:
  explicit DepthScan(std::string_view text) : _text(text) {}

  std::optional<int> line_too_deep() {
    while (_at < _text.size()) {
      step();
      if (depth() > largest_depth) return _line;
    }
    return std::nullopt;
  }

 private:
  /// Depth of a dotted key, at the top level or between two brackets. The depth of a header applies to the lines below
  /// it.
  struct Level {
    int parts = 1;
    bool header = false;
  };

  int depth() const { return _header + _outer + _levels.back().parts; }

  void step() {
    const char c = _text[_at];
    switch (c) {
      case '#':
        _at = std::min(_text.find('\n', _at), _text.size());
        return;
      case '"':
      case '\'':
        skip_string(c);
        return;
      case '\n':
        end_line();
        break;
      case '.':
        ++_levels.back().parts;
        break;
      case ',':
        _levels.back().parts = 1;
        break;
      case '[':
      case '{':
        open();
        break;
      case ']':
      case '}':
        close();
        break;
      default:
        break;
    }
    if (c != ' ' && c != '\t' && c != '\r' && c != '\n') _line_began = true;
    ++_at;
  }

  void end_line() {
    ++_line;
    _line_began = false;
    if (_levels.size() == 1) _levels.back().parts = 1;
  }

  /// A bracket at the start of a line, outside of all other brackets, starts a header.
  void open() {
    const bool header = _levels.size() == 1 && !_line_began;
    if (header) _header = 0;
    const bool second = _levels.size() == 2 && _levels.back().header && _levels.back().parts == 1;
    _outer += _levels.back().parts;
    _levels.push_back({1, header || second});
  }

  void close() {
    if (_levels.size() == 1) return;
    const Level closed = _levels.back();
    _levels.pop_back();
    _outer -= _levels.back().parts;
    if (closed.header) _header += closed.parts;
  }

  /// Number of consecutive quotes at _at, up to five: at the end of a string three quotes may follow two quotes of its
  /// content. Counting more would take quadratic time for a text of quotes.
  std::size_t quotes(char quote) const {
    const std::string_view ahead = _text.substr(_at, 5);
    return std::min(ahead.find_first_not_of(quote), ahead.size());
  }

  void skip_string(char quote) {
    _line_began = true;
    if (quotes(quote) >= 3) return skip_lines(quote);
    for (++_at; _at < _text.size() && _text[_at] != '\n'; ++_at) {
      if (_text[_at] == quote) {
        ++_at;
        return;
      }
      if (_text[_at] == '\\' && quote == '"') ++_at;
    }
  }

  /// Skips a multi-line string, whose content may end with up to two quotes.
  void skip_lines(char quote) {
    for (_at += 3; _at < _text.size(); ++_at) {
      if (_text[_at] == '\n') ++_line;
      if (_text[_at] == '\\' && quote == '"') {
        if (++_at < _text.size() && _text[_at] == '\n') ++_line;
      } else if (_text[_at] == quote && quotes(quote) >= 3) {
        _at += quotes(quote);
        return;
      }
    }
  }

  std::string_view _text;
  std::size_t _at = 0;
  int _line = 1, _header = 0, _outer = 0;
  bool _line_began = false;  ///< the line already has a character other than white space
  std::vector<Level> _levels{Level{}};
};

}  // namespace

std::optional<int> too_deep_at(std::string_view text) { return DepthScan(text).line_too_deep(); }

}  // namespace phynness::scene_detail
