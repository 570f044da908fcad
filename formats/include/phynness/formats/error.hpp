// The exception of the host code: what is wrong, the value, and the remedy.
#pragma once

#include <phynness/formats/printable.hpp>
#include <stdexcept>
#include <string>

namespace phynness {

/// An error for the user. Everything that a user can cause throws it; defects of the program assert.
class Error : public std::runtime_error {
 public:
  /// `input`: wrong usage or input (exit status 2). `failure`: the work itself failed (exit status 1).
  enum class Kind { input, failure };

  /// @param what    what is wrong, in one sentence without a full stop
  /// @param value   the wrong value ("" if there is none)
  /// @param remedy  what the user can do ("" only if nothing can be done)
  /// An error that repeats another one has one remedy: its own, or the other's if its own is "".
  /// Control characters of all three are escaped in what(), and a long value is cut.
  Error(Kind kind, std::string what, std::string value, std::string remedy)
      : std::runtime_error(message(what, value, remedy)), _kind(kind) {}

  Kind kind() const noexcept { return _kind; }

 private:
  static std::string message(const std::string& what, const std::string& value, const std::string& remedy) {
    constexpr std::size_t most_of_value = 8000;
    constexpr std::string_view before_remedy = "\n  remedy: ";
    // What another error said: its remedy gives way to this one's.
    const auto without_remedy = [&](std::string_view text) {
      return remedy.empty() ? text : text.substr(0, text.find(before_remedy));
    };
    std::string text(without_remedy(what));
    if (!value.empty()) text += ": " + shortened(without_remedy(value), most_of_value);
    if (!remedy.empty()) (text += before_remedy) += remedy;
    return printable(text);
  }

  Kind _kind;
};

inline Error input_error(std::string what, std::string value, std::string remedy) {
  return {Error::Kind::input, std::move(what), std::move(value), std::move(remedy)};
}
inline Error failure(std::string what, std::string value, std::string remedy) {
  return {Error::Kind::failure, std::move(what), std::move(value), std::move(remedy)};
}

}  // namespace phynness
