#include <phynness/phynness_surface.h>
#include <phynness/phynness_tools.h>

#include "../runtime/loaded_model.hpp"
#include "ask_model.hpp"

#include <algorithm>
#include <phynness/formats/hash.hpp>

namespace phynness::fuzz {
namespace {

using test::AtNode, test::contents_of;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr int warnings = PHN_WARNING_OUTSIDE | PHN_WARNING_INCOMPLETE;

bool finite(const double* d, std::size_t n) {
  return std::all_of(d, d + n, [](double x) { return std::isfinite(x); });
}
bool zero(const double* d, std::size_t n) {
  return std::all_of(d, d + n, [](double x) { return x == 0; });
}

class Asker {
 public:
  Asker(const phn_model* model, Script& script, bool trained)
      : _model(model),
        _script(script),
        _trained(trained),
        _max_tools(1 + script.below(script.below(4) == 0 ? 9 : 3)),
        _used(data_bytes(), script.below(64)),
        _fresh(data_bytes(), script.below(64)),
        _n_output(static_cast<std::size_t>(info_of(model).n_output)) {
    require(phn_data_init(_used.data(), _used.size(), _model, _max_tools, &_data) == PHN_OK,
            "data of the size asked for");
    phn_data* none = _data;
    require(phn_data_init(_fresh.data(), _fresh.size() - 1, _model, _max_tools, &none) == PHN_ERROR_BUFFER && !none,
            "a byte less is refused");
  }

  void call() {
    using Question = void (Asker::*)();
    constexpr Question questions[] = {
        &Asker::force,   &Asker::force,   &Asker::energy, &Asker::stiffness, &Asker::deform, &Asker::deform,
        &Asker::prepare, &Asker::nearest, &Asker::couple, &Asker::couple,    &Asker::couple, &Asker::field,
        &Asker::trained, &Asker::surface, &Asker::level,  &Asker::point,     &Asker::sizes};
    (this->*questions[_script.below(static_cast<int>(std::size(questions)))])();
  }

 private:
  std::size_t data_bytes() const {
    std::size_t bytes = 0;
    require(phn_data_size(_model, _max_tools, &bytes) == PHN_OK && bytes > 0, "a size of data");
    return bytes;
  }

  std::int32_t any_node() {
    const int kind = _script.below(8);
    const auto pick = [this](const std::int32_t* list, std::int32_t n) {
      return n > 0 ? list[_script.raw<std::uint16_t>() % n] : -1;
    };
    if (kind == 0) return _script.raw<std::int32_t>();
    if (kind == 1) return pick(info_of(_model).output_nodes, info_of(_model).n_output);
    if (kind == 2) return pick(info_of(_model).fixed_nodes, info_of(_model).n_fixed);
    return pick(info_of(_model).active_nodes, info_of(_model).n_active);
  }
  void displacement(double* d) {
    for (int k = 0; k < 3; ++k) d[k] = _script.number();
  }
  bool active(std::int32_t node) const {
    const std::int32_t* list = info_of(_model).active_nodes;
    return std::binary_search(list, list + info_of(_model).n_active, node);
  }

  /// call(data, out) -> status, of used and of fresh scratch.
  template <class Call>
  int answer(std::size_t n, std::vector<double>& out, int allowed_warnings, Call call, double refused = 0) {
    out.assign(n, nan);
    std::vector<double> again(n, nan);
    const int status = call(_data, out.data());
    phn_data* fresh = nullptr;
    _fresh.fill();
    require(phn_data_init(_fresh.data(), _fresh.size(), _model, _max_tools, &fresh) == PHN_OK, "data of its size");
    require(phn_set_level(_model, fresh, _level) == PHN_OK, "a level that the data have");
    require(call(fresh, again.data()) == status, "the status does not depend on earlier calls");
    require(n == 0 || std::memcmp(out.data(), again.data(), 8 * n) == 0, "the answer does not depend on earlier calls");
    require(status <= 0 || (status & ~allowed_warnings) == 0, "only documented warnings");
    require(finite(out.data(), n), "finite");
    for (std::size_t i = 0; i < n && status < 0; ++i) require(out[i] == refused, "zeros, or no bound, where refused");
    return status;
  }
  /// Of one node and displacement: which refusals are right. @return whether it was answered
  bool right(int status, std::int32_t node, const double* d, bool may_be_undefined) const {
    if (!finite(d, 3)) {
      require(status == PHN_ERROR_NOT_FINITE, "not finite");
    } else if (!active(node)) {
      require(status == PHN_ERROR_NOT_ACTIVE, "not active");
    } else {
      require(status >= 0 || (may_be_undefined && status == PHN_ERROR_UNDEFINED), "answered");
    }
    return status >= 0;
  }

  void force() {
    const std::int32_t node = any_node();
    double d[3];
    displacement(d);
    const int status = answer(3, _out, warnings, [&](phn_data* data, double* out) {
      return phn_force(_model, data, AtNode(node, d), out, nullptr, nullptr);
    });
    if (!right(status, node, d, false) || !zero(d, 3)) return;
    double energy;
    if (phn_force(_model, _data, AtNode(node, d), nullptr, &energy, nullptr) >= 0)
      require(zero(_out.data(), 3), "no force at rest");
  }
  void energy() {
    const std::int32_t node = any_node();
    double d[3];
    displacement(d);
    const int status = answer(1, _out, warnings, [&](phn_data* data, double* out) {
      return phn_force(_model, data, AtNode(node, d), nullptr, out, nullptr);
    });
    if (right(status, node, d, true) && zero(d, 3)) require(_out[0] == 0, "no energy at rest");
  }
  void stiffness() {
    const std::int32_t node = any_node();
    double d[3];
    displacement(d);
    const int status = answer(9, _out, warnings, [&](phn_data* data, double* out) {
      return phn_force(_model, data, AtNode(node, d), nullptr, nullptr, out);
    });
    right(status, node, d, true);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < i; ++j)
        require(std::memcmp(&_out[3 * i + j], &_out[3 * j + i], 8) == 0, "a symmetric stiffness");
  }
  void deform() {
    const std::int32_t node = any_node();
    double d[3];
    displacement(d);
    const int status = answer(3 * _n_output, _out, warnings, [&](phn_data* data, double* out) {
      return phn_deform(_model, data, AtNode(node, d), out);
    });
    right(status, node, d, true);
    if (status < 0) return;
    const std::int32_t* output = info_of(_model).output_nodes;
    const auto at = std::lower_bound(output, output + _n_output, node) - output;
    if (static_cast<std::size_t>(at) == _n_output || output[at] != node || !_trained) return;
    if (!std::all_of(d, d + 3, [](double x) { return std::fabs(x) < 1; })) return;
    for (int k = 0; k < 3; ++k) require(_out[3 * at + k] == d[k], "a touched node moves by exactly d");
  }
  void prepare() {
    const std::int32_t node = any_node();
    require(phn_prepare(_model, _data, AtNode(node)) == (active(node) ? PHN_OK : PHN_ERROR_NOT_ACTIVE), "prepared");
  }
  void nearest() {
    double x[3];
    displacement(x);
    phn_tool tool;
    double point[3] = {nan, nan, nan};
    const int status = phn_nearest(_model, x, &tool, point, nullptr);
    require(finite(point, 3) && finite(tool.weights, 3) && zero(tool.displacement, 3), "a finite point");
    if (!finite(x, 3)) return require(status == PHN_ERROR_NOT_FINITE, "not finite");
    if (info_of(_model).n_triangles == 0) return require(status == PHN_ERROR_UNDEFINED, "no surface");
    if (status == PHN_ERROR_UNDEFINED) return;  // no triangle can be touched
    require(status == PHN_OK, "a nearest point");
    double sum = 0;
    for (const double w : tool.weights) {
      require(w >= 0, "weights of a point of the triangle");
      sum += w;
    }
    require(std::fabs(sum - 1) < 1e-9, "weights of sum 1");
    double forces[3];
    require(phn_couple(_model, _data, 1, &tool, forces, nullptr) != PHN_ERROR_ARGUMENT, "a tool that may be used");
  }
  phn_tool any_tool() {
    phn_tool tool{{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}};
    const int kind = _script.below(8);
    if (kind < 2) {
      tool.nodes[0] = any_node();
      tool.weights[0] = 1;
    } else if (kind < 6) {
      double x[3];
      displacement(x);
      phn_nearest(_model, x, &tool, nullptr, nullptr);
    } else {
      double sum = 0;
      for (int k = 0; k < 3; ++k) {
        tool.nodes[k] = any_node();
        sum += tool.weights[k] = kind == 6 ? std::fabs(_script.number()) : _script.byte();
      }
      for (double& w : tool.weights) w /= sum;
    }
    displacement(tool.displacement);
    return tool;
  }
  void couple() {
    constexpr std::int32_t counts[] = {1, 1, 1, 2, 2, 3, 8, 0, 9, -1};
    const std::int32_t n = _script.below(64) == 63 ? 10000 : counts[_script.below(10)];
    const auto size = static_cast<std::size_t>(std::max(n, 0));
    std::vector<phn_tool> tools(size);
    for (std::size_t t = 0; t < std::min<std::size_t>(size, 9); ++t) tools[t] = any_tool();
    const std::size_t n_forces = 3 * size;
    const int status =
        answer(n_forces + 2 + 3 * _n_output, _out, warnings | PHN_WARNING_UNSETTLED, [&](phn_data* data, double* out) {
          phn_coupled result;
          const int told = phn_couple(_model, data, n, tools.data(), out, &result);
          out[n_forces] = result.residual;
          out[n_forces + 1] = result.energy;
          double* field = out + n_forces + 2;
          const int deformed = phn_coupled_deform(_model, data, field);
          // After a refusal there are no tools: what was there before is gone, too.
          if (n >= 0 && n <= std::min(_max_tools, 8) && told < 0)
            require(deformed == PHN_OK, "nothing is held after a refusal");
          if (told < 0) std::fill(field, field + 3 * _n_output, 0);
          return told;
        });
    if (n < 0) require(status == PHN_ERROR_ARGUMENT, "a negative number of tools");
    if (n == 0) require(status == PHN_OK, "no tools");
    if (n > std::min(_max_tools, 8))
      require(status == (n > 8 ? PHN_ERROR_TOO_MANY_TOOLS : PHN_ERROR_TOOLS), "too many tools");
    if (status >= 0) require(_out[n_forces] >= 0, "a distance");
  }
  void point() {
    const phn_tool tool = any_tool();
    const auto of_data = [&](phn_data* data, double* out) {
      return phn_force(_model, data, &tool, out, nullptr, nullptr);
    };
    const int status = answer(3, _out, warnings | PHN_WARNING_UNSETTLED, of_data);
    const bool at_rest = zero(_out.data(), 3);
    const int more = answer(10, _out, warnings, [&](phn_data* data, double* out) {
      return phn_force(_model, data, &tool, nullptr, out, out + 1);
    });
    require(more == status || more == PHN_ERROR_UNDEFINED, "what has an energy and a stiffness has a force");
    if (more >= 0 && zero(tool.displacement, 3)) require(at_rest && _out[0] == 0, "nothing at rest");
    const int trained =
        answer(1, _out, PHN_WARNING_OUTSIDE, [&](phn_data*, double* out) { return phn_depth(_model, &tool, out); });
    // Between nodes, node probes have a force but no depth.
    require(trained == PHN_ERROR_UNDEFINED || (trained < 0 ? trained == status : status >= 0),
            "a depth where answered");
    answer(
        1, _out, warnings, [&](phn_data*, double* out) { return phn_bound(_model, &tool, out); }, PHN_NO_BOUND);
    require(_out[0] >= 0, "a bound");
  }
  void field() {
    const std::int32_t node = any_node(),
                       number = _script.below(4) == 0 ? _script.raw<std::int32_t>() : _script.below(3);
    double d[3];
    displacement(d);
    const int status = answer(_n_output, _out, warnings, [&](phn_data* data, double* out) {
      return phn_field(_model, data, AtNode(node, d), number, out);
    });
    if (number < 0 || number >= info_of(_model).n_fields) {
      require(status == PHN_ERROR_ARGUMENT, "no such field");
    } else {
      right(status, node, d, true);
    }
    for (const double x : _out) require(x >= 0 && (x == 0 || !zero(d, 3)), "fields are not negative, and 0 at rest");
  }
  void level() {
    const std::int32_t n = info_of(_model).n_levels,
                       wanted = _script.below(8) == 0 ? _script.raw<std::int32_t>() : _script.below(n + 1);
    const bool there = wanted >= 0 && wanted < n;
    require(phn_set_level(_model, _data, wanted) == (there ? PHN_OK : PHN_ERROR_ARGUMENT), "set or refused");
    if (there) _level = wanted;
    phn_level info;
    require(phn_level_info(_model, wanted, &info) == (there ? PHN_OK : PHN_ERROR_ARGUMENT), "told or refused");
    require(info.error_force >= 0 && info.error_displacement >= 0, "errors are not negative");
  }
  void trained() {
    const std::int32_t node = any_node();
    double d[3];
    displacement(d);
    const int status = answer(1, _out, PHN_WARNING_OUTSIDE,
                              [&](phn_data*, double* out) { return phn_depth(_model, AtNode(node, d), out); });
    right(status, node, d, false);
    require(_out[0] >= 0, "a depth");
    const int warned = status;
    const auto bound = [&](phn_data*, double* out) { return phn_bound(_model, AtNode(node, d), out); };
    const int bounded = answer(1, _out, PHN_WARNING_OUTSIDE | PHN_WARNING_INCOMPLETE, bound, PHN_NO_BOUND);
    if (!right(bounded, node, d, true)) return;
    require((bounded & PHN_WARNING_OUTSIDE) == (warned & PHN_WARNING_OUTSIDE), "the same range");
    require((_out[0] == PHN_NO_BOUND) == ((bounded & PHN_WARNING_OUTSIDE) != 0), "a bound inside of the range only");
    require(_out[0] >= 0, "a bound");
  }
  void surface() {
    const std::int32_t levels = _script.below(16) < 14 ? _script.below(4) - 1 : _script.below(8);
    std::size_t bytes = 1;
    const int status = phn_surface_size(_model, levels, &bytes);
    if (status < 0) {
      require(bytes == 0, "no size where refused");
      require(status == PHN_ERROR_ARGUMENT || status == PHN_ERROR_UNDEFINED || status == PHN_ERROR_GEOMETRY ||
                  status == PHN_ERROR_TOO_LARGE,
              "refused");
      return;
    }
    if (bytes > largest_memory / 16) return;
    const Memory memory(bytes, static_cast<std::size_t>(_script.below(16)));
    const phn_surface* fine = nullptr;
    require(phn_surface_init(memory.data(), bytes, _model, levels, &fine) == PHN_OK, "a surface of its size");
    const auto n = 3 * static_cast<std::size_t>(contents_of(fine).n_vertices);
    const float* points = contents_of(fine).points;
    for (std::size_t i = 0; i < n; ++i) require(std::isfinite(points[i]), "finite points of the surface");
    const std::int32_t* corner = contents_of(fine).triangles;
    for (std::size_t i = 0; i < 3 * static_cast<std::size_t>(contents_of(fine).n_triangles); ++i)
      require(corner[i] >= 0 && 3 * static_cast<std::size_t>(corner[i]) < n, "corners are vertices");
    std::vector<double> field(3 * _n_output);
    for (std::size_t i = 0; i < field.size(); ++i) field[i] = i < 12 ? _script.number() : field[i % 12];
    std::vector<float> scratch(contents_of(fine).scratch_bytes / sizeof(float)), out(n, 1);
    const int deformed = phn_surface_deform(fine, scratch.data(), field.data(), out.data());
    const bool good = finite(field.data(), field.size());
    if (_n_output > 0) require(deformed == (good ? PHN_OK : PHN_ERROR_NOT_FINITE), "a fine field");
    for (const float x : out) require(deformed < 0 ? x == 0 : std::isfinite(x), "a finite fine field");
  }
  void sizes() {
    const auto tools = _script.raw<std::int32_t>();
    std::size_t bytes = 1;
    const int status = phn_data_size(_model, tools, &bytes);
    require(status == (tools < 1 ? PHN_ERROR_ARGUMENT : PHN_OK) && (bytes == 0) == (tools < 1), "a size for any tools");
    require(phn_status_message(_script.raw<std::int32_t>()) != nullptr, "words for any status");
  }

  const phn_model* _model;
  Script& _script;
  bool _trained;
  std::int32_t _max_tools;
  Memory _used, _fresh;
  std::size_t _n_output;
  phn_data* _data = nullptr;
  std::int32_t _level = info_of(_model).n_levels - 1;
  std::vector<double> _out;
};

}  // namespace

bool refusal_of_loader(int status) { return status <= PHN_ERROR_NOT_A_MODEL && status >= PHN_ERROR_FAMILY; }

LoadedText::LoadedText(const char* text, std::size_t length, std::size_t shift) {
  std::size_t bytes = 1;
  status = phn_model_size(text, length, &bytes, nullptr);
  if (status != PHN_OK) {
    require(refusal_of_loader(status) && bytes == 0, "a documented refusal");
    std::vector<char> some(4096);
    const int again = phn_model_init(some.data(), some.size(), text, length, &model, nullptr);
    require((refusal_of_loader(again) || again == PHN_ERROR_BUFFER) && model == nullptr, "init refuses, too");
    return;
  }
  if (bytes > largest_memory) return;
  memory = std::make_unique<Memory>(bytes, shift);
  status = phn_model_init(memory->data(), bytes, text, length, &model, nullptr);
  require(status == PHN_OK || status == PHN_ERROR_RANGE, "what size accepts, init accepts or finds out of range");
  require((model != nullptr) == (status == PHN_OK), "a model or none");
  if (status != PHN_OK) return;
  const Memory less(bytes - 1, 0);
  const phn_model* none = nullptr;
  require(phn_model_init(less.data(), bytes - 1, text, length, &none, nullptr) == PHN_ERROR_BUFFER && none == nullptr,
          "a byte less is refused");
}

std::uint64_t LoadedText::hash() const {
  Fnv1a64 hash;
  hash.add(memory->data(), memory->size());
  return hash.value();
}

Models::Models(const std::vector<Model>& models, std::size_t shift) {
  for (const Model& model : models) {
    const std::string text = write_model_text(model);
    _all.emplace_back(text.data(), text.size(), shift * _all.size());
    require(_all.back().model != nullptr, "a good model");
    _hashes.push_back(_all.back().hash());
  }
}

void Models::ask_one(Script& script, const std::function<void(const phn_model*)>& ask) const {
  const auto i = static_cast<std::size_t>(script.below(static_cast<int>(_all.size())));
  ask(_all[i].model);
  require(_all[i].hash() == _hashes[i], "a model never changes");
}

void look_at(const phn_model* model) {
  const auto ascending = [&](const std::int32_t* list, std::int32_t n) {
    for (std::int32_t i = 0; i < n; ++i)
      require(list[i] >= 0 && list[i] < info_of(model).n_nodes && (i == 0 || list[i] > list[i - 1]), "nodes ascend");
  };
  const std::int32_t n_output = info_of(model).n_output, n_fixed = info_of(model).n_fixed;
  ascending(info_of(model).active_nodes, info_of(model).n_active);
  ascending(info_of(model).output_nodes, n_output);
  ascending(info_of(model).fixed_nodes, n_fixed);
  require(finite(info_of(model).output_points, 3 * static_cast<std::size_t>(n_output)), "finite points");
  require(finite(info_of(model).fixed_points, 3 * static_cast<std::size_t>(n_fixed)), "finite fixed points");
  const std::int32_t* corner = info_of(model).triangles;
  for (std::size_t i = 0; i < 3 * static_cast<std::size_t>(info_of(model).n_triangles); ++i)
    require(corner[i] >= 0 && corner[i] < n_output + n_fixed, "corners are vertices");
  for (std::int32_t f = 0; f < info_of(model).n_fields; ++f) {
    const std::size_t n = std::strlen(info_of(model).field_names[f]), m = std::strlen(info_of(model).field_units[f]);
    require(n >= 1 && n <= 40 && m >= 1 && m <= 40, "names of fields");
  }
}

void ask(const phn_model* model, Script& script, bool trained, int most) {
  std::size_t bytes = 0;
  if (phn_data_size(model, 9, &bytes) != PHN_OK || bytes > largest_memory) return;
  Asker asker(model, script, trained);
  for (int i = 0; i < most && !script.at_end(); ++i) asker.call();
}

}  // namespace phynness::fuzz
