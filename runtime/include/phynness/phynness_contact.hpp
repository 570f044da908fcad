// phynness for C++17: the functions of phynness_contact.h as members of a class, in the manner of phynness.hpp.
#ifndef PHYNNESS_CONTACT_HPP
#define PHYNNESS_CONTACT_HPP

#include <phynness/phynness_contact.h>
#include <phynness/phynness.hpp>

namespace phynness::rt {

/// Contact of tools with a model; each thread that moves tools has its own. @pre the model outlives this object
class Contact : public detail::Built<phn_contact, detail::FieldSize> {
 public:
  Contact() = default;
  Contact(const Model& model, std::int32_t max_tools, Span<std::byte> own = {}) {
    more().n_field = 3 * static_cast<std::size_t>(model.n_output());
    build(model.get(), max_tools, own, phn_contact_size, phn_contact_init);
  }
  static std::size_t bytes_for(const Model& model, std::int32_t max_tools) noexcept {
    return bytes_of(phn_contact_size, model.get(), max_tools);
  }

  /// @param states  tools.size() of them
  Status step(Span<const phn_contact_tool> tools, Span<phn_contact_state> states,
              phn_contact_report* report = nullptr) noexcept {
    if (states.size() < tools.size()) return PHN_ERROR_BUFFER;
    if (tools.size() > PHN_MOST_COUPLED) return PHN_ERROR_TOO_MANY_TOOLS;
    return phn_contact_step(get(), static_cast<std::int32_t>(tools.size()), tools.data(), states.data(), report);
  }
  Status step(const phn_contact_tool& tool, phn_contact_state& state, phn_contact_report* report = nullptr) noexcept {
    return phn_contact_step(get(), 1, &tool, &state, report);
  }
  Status reset() noexcept { return phn_contact_reset(get()); }
};

}  // namespace phynness::rt

#endif
