// Arbitrary sequences of tools that approach, touch, slide and leave, at any places and of any sizes. Every step is
// computed twice: with a contact whose scratch was used before, and with fresh scratch. Input: the model, the number of
// tools, steps.
#include <phynness/phynness_levels.h>

#include <phynness/phynness_contact.h>

#include <algorithm>

#include "../contact/bodies.hpp"
#include "ask_model.hpp"

namespace phynness::fuzz {
namespace {

using namespace phynness::test;

bool finite(const double* x, std::size_t n) {
  return std::all_of(x, x + n, [](double value) { return std::isfinite(value); });
}
double along(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

class Hand {
 public:
  Hand(const phn_model* model, Script& script)
      : _model(model),
        _script(script),
        _max_tools(1 + script.below(8)),
        _contact_memory(contact_bytes(), script.below(16)),
        _twin_memory(contact_bytes(), script.below(16)),
        _used(data_bytes(), script.below(16)),
        _fresh(data_bytes(), script.below(16)) {
    for (auto [memory, contact] : {std::pair(&_contact_memory, &_contact), std::pair(&_twin_memory, &_twin)})
      require(phn_contact_init(memory->data(), memory->size(), model, _max_tools, contact) == PHN_OK,
              "a contact of its size");
    require(phn_data_init(_used.data(), _used.size(), model, _max_tools, &_data) == PHN_OK, "data of its size");
    const Memory less(contact_bytes() / 2, 0);
    phn_contact* none = _contact;
    require(phn_contact_init(less.data(), less.size(), model, _max_tools, &none) == PHN_ERROR_BUFFER && !none,
            "half the memory is refused");
    for (phn_contact_tool& tool : _tools) {
      for (double& x : tool.center) x = near();
      tool = {{tool.center[0], tool.center[1], tool.center[2]}, 0.004, 0, PHN_TOOL_PRESS};
    }
  }

  void move() {
    switch (_script.below(16)) {
      case 0:
        return refit();
      case 1:
        return nearest();
      case 2:
        require(phn_contact_reset(_contact) == PHN_OK && phn_contact_reset(_twin) == PHN_OK, "all tools are new");
        return;
      case 3:
        _level = _script.below(info_of(_model).n_levels);
        require(phn_set_level(_model, _data, _level) == PHN_OK, "a level");
        return;
      default:
        return step();
    }
  }

 private:
  std::size_t contact_bytes() const {
    std::size_t bytes = 0;
    require(phn_contact_size(_model, _max_tools, &bytes) == PHN_OK && bytes > 0, "a size of contact");
    return bytes;
  }
  std::size_t data_bytes() const {
    std::size_t bytes = 0;
    require(phn_data_size(_model, _max_tools, &bytes) == PHN_OK && bytes > 0, "a size of data");
    return bytes;
  }
  /// A coordinate within and around the bodies.
  double near() { return _script.raw<std::int16_t>() / 32768.0 * 0.08; }
  double amount() { return std::fabs(_script.number()); }

  /// Mostly a small way on from where the tool was, or to the middle of the body; sometimes anything.
  void change(phn_contact_tool& tool) {
    const int kind = _script.below(16);
    for (double& x : tool.center) {
      if (kind < 9) {
        x += 0.1 * near();
      } else if (kind < 12) {
        x = near();
      } else if (kind == 12) {
        x = _script.number();
      } else if (kind == 13) {
        x *= 0.8;
      }
    }
    if (kind == 14) tool.mode = _script.below(8) == 0 ? _script.raw<std::int32_t>() : _script.below(3);
    if (kind == 15) tool.radius = _script.below(2) == 0 ? amount() : std::fabs(near());
    if (kind == 11) tool.friction = _script.below(2) == 0 ? amount() : _script.byte() / 128.0;
  }

  void step() {
    const std::int32_t n = _script.below(64) == 0 ? _script.below(16) - 1 : 1 + _script.below(_max_tools);
    const auto size = static_cast<std::size_t>(std::max(n, 0));
    phn_contact_tool before[8];
    std::copy(_tools, _tools + 8, before);
    for (std::size_t t = 0; t < std::min<std::size_t>(size, 8); ++t) change(_tools[t]);
    std::vector<phn_contact_tool> tools(size);
    std::copy_n(_tools, std::min<std::size_t>(size, 8), tools.begin());
    std::vector<phn_contact_state> states(size), again(size);
    phn_coupled coupled, coupled_again;
    const int status = phn_contact_step(_contact, _data, n, tools.data(), states.data(), &coupled);
    phn_data* fresh = nullptr;
    _fresh.fill();
    require(phn_data_init(_fresh.data(), _fresh.size(), _model, _max_tools, &fresh) == PHN_OK, "data of its size");
    require(phn_set_level(_model, fresh, _level) == PHN_OK, "a level that the data have");
    require(phn_contact_step(_twin, fresh, n, tools.data(), again.data(), &coupled_again) == status,
            "the status does not depend on earlier scratch");
    // Members, as between them there may be anything.
    for (std::size_t t = 0; t < size; ++t)
      require(values(states[t]) == values(again[t]), "the answer does not depend on earlier scratch");
    require(coupled.energy == coupled_again.energy && coupled.residual == coupled_again.residual, "nor the result");
    require(std::isfinite(coupled.energy) && std::isfinite(coupled.residual), "a finite result");
    if (n < 0) return require(status == PHN_ERROR_ARGUMENT, "a negative number of tools");
    if (n > _max_tools) require(status == PHN_ERROR_TOOLS, "too many tools");
    for (std::size_t t = 0; t < size; ++t) look_at(status, tools[t], states[t]);
    if (status < 0) {
      std::copy(before, before + 8, _tools);  // tools stayed where they were
      return;
    }
    require(status <= (PHN_WARNING_OUTSIDE | PHN_WARNING_INCOMPLETE | PHN_WARNING_UNSETTLED), "documented warnings");
    std::vector<double> field(3 * static_cast<std::size_t>(info_of(_model).n_output));
    require(phn_coupled_deform(_model, _data, field.data()) >= 0 && finite(field.data(), field.size()),
            "the field of this step");
  }

  static std::vector<double> values(const phn_contact_state& s) {
    std::vector<double> all{s.scale, s.unbalanced, double(s.in_contact)};
    for (int k = 0; k < 3; ++k) {
      for (const double x :
           {s.force[k], s.proxy[k], s.normal[k], s.held.weights[k], s.held.displacement[k], double(s.held.nodes[k])})
        all.push_back(x);
    }
    return all;
  }

  static void look_at(int status, const phn_contact_tool& tool, const phn_contact_state& state) {
    const auto all = values(state);
    require(finite(all.data(), all.size()), "a finite state");
    if (status < 0 || state.in_contact == 0) {
      require(along(state.force, state.force) == 0 && along(state.normal, state.normal) == 0 && state.scale == 0 &&
                  state.held.nodes[0] == -1,
              "nothing without contact");
      return;
    }
    require(state.in_contact == 1 && tool.mode != PHN_TOOL_OFF, "a tool in contact");
    require(state.scale > 0 && state.scale <= 1 && state.unbalanced >= 0, "a scale");
    require(std::fabs(std::sqrt(along(state.normal, state.normal)) - 1) < 1e-12, "a unit normal");
    double sum = 0;
    for (const double w : state.held.weights) {
      require(w >= 0, "weights of a point of the triangle");
      sum += w;
    }
    require(std::fabs(sum - 1) < 1e-12, "weights of sum 1");
    if (tool.mode != PHN_TOOL_PRESS) return;
    double f[3], largest = 0;
    for (const double x : state.force) largest = std::max(largest, std::fabs(x));
    for (int k = 0; k < 3; ++k) f[k] = largest > 0 ? state.force[k] / largest : 0;
    const double push = -along(f, state.normal);
    double tangential[3];
    for (int k = 0; k < 3; ++k) tangential[k] = f[k] + push * state.normal[k];
    // Rounding of a force of size 1; the friction that the runtime reads ends at 1e6.
    require(push >= -1e-14, "pushes only");
    require(std::sqrt(along(tangential, tangential)) <= std::min(tool.friction, 1e6) * push + 1e-9, "in the cone");
  }

  void refit() {
    std::vector<double> field(3 * static_cast<std::size_t>(info_of(_model).n_output));
    const int kind = _script.below(4);
    for (std::size_t i = 0; i < field.size(); ++i)
      field[i] = i >= 12 ? field[i % 12] : kind == 0 ? _script.number() : 0.1 * near();
    const double* given = kind == 3 ? nullptr : field.data();
    const int expected = given == nullptr || finite(field.data(), field.size()) ? PHN_OK : PHN_ERROR_NOT_FINITE;
    require(phn_contact_refit(_contact, given) == expected && phn_contact_refit(_twin, given) == expected, "refitted");
  }

  void nearest() {
    double x[3], point[3] = {1, 1, 1};
    for (double& value : x) value = _script.number();
    phn_tool tool;
    const int status = phn_contact_nearest(_contact, x, &tool, point);
    require(status == (finite(x, 3) ? PHN_OK : PHN_ERROR_NOT_FINITE), "a nearest point");
    require(finite(point, 3) && finite(tool.weights, 3), "a finite point");
    double force[3];
    if (status == PHN_OK)
      require(phn_couple(_model, _data, 1, &tool, force, nullptr) != PHN_ERROR_ARGUMENT, "a tool that may be used");
  }

  const phn_model* _model;
  Script& _script;
  std::int32_t _max_tools;
  Memory _contact_memory, _twin_memory, _used, _fresh;
  phn_contact *_contact = nullptr, *_twin = nullptr;
  phn_data* _data = nullptr;
  std::int32_t _level = info_of(_model).n_levels - 1;
  phn_contact_tool _tools[8] = {};
};

}  // namespace

std::vector<Input> seeds() { return random_inputs(13, 240, 600); }

}  // namespace phynness::fuzz

using namespace phynness::fuzz;
using namespace phynness::test;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Models models({small_model(), small_linear_model(), with_levels(small_field_model()),
                              linear_model(ball(1)), bent_model(ball(1)), linear_model(held_ball(1))},
                             5);
  Script script(data, size);
  models.ask_one(script, [&](const phn_model* model) {
    Hand hand(model, script);
    for (int i = 0; i < 60 && !script.at_end(); ++i) hand.move();
  });
  return 0;
}
