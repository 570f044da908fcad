// The exception of the host code: what is wrong, the value, and the remedy.
#pragma once

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
  Error(Kind kind, std::string what, std::string value, std::string remedy)
      : std::runtime_error(message(what, value, remedy)), _kind(kind) {}

  Kind kind() const noexcept { return _kind; }

 private:
  static std::string message(const std::string& what, const std::string& value, const std::string& remedy) {
    std::string text = what;
    if (!value.empty()) text += ": " + value;
    if (!remedy.empty()) text += "\n  remedy: " + remedy;
    return text;
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
