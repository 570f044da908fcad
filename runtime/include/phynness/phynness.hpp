// phynness for C++17: a model's folder and, where several tools act, a body's file, as one object with four verbs:
// nearest, hold, touch and deform. No exceptions and no RTTI are used: functions that can fail return a [[nodiscard]]
// Status. Meaning, cost, units and errors are described in phynness.h, phynness_body.h and phynness_contact.h.
//
//   phynness::Organ organ = phynness::Organ::read("out/demo/model", "out/demo/body.txt", 2);
//   if (!organ) return std::puts(organ.problem().c_str());
//   phn_tool tool;
//   double force[3];
//   const auto found = organ.nearest({{0.03, 0.01, 0.05}}, tool);
//   tool.displacement[2] = -0.01;
//   const auto status = organ.hold(tool, force);
#ifndef PHYNNESS_HPP
#define PHYNNESS_HPP

#include <phynness/phynness_contact.h>
#include <phynness/phynness_tools.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
#if __cplusplus >= 202002L
#include <span>
#endif

namespace phynness {

#if __cplusplus >= 202002L
template <class T>
using Span = std::span<T>;
#else
/// The part of std::span that this header uses, for C++17.
template <class T>
class Span {
 public:
  constexpr Span() noexcept = default;
  constexpr Span(T* data, std::size_t size) noexcept : _data(data), _size(size) {}
  template <class Range, class = decltype(std::declval<Range&>().data(), std::declval<Range&>().size())>
  constexpr Span(Range&& range) noexcept : Span(range.data(), range.size()) {}
  template <std::size_t n>
  constexpr Span(T (&array)[n]) noexcept : Span(array, n) {}
  constexpr T* data() const noexcept { return _data; }
  constexpr std::size_t size() const noexcept { return _size; }
  constexpr T& operator[](std::size_t i) const noexcept { return _data[i]; }
  constexpr T* begin() const noexcept { return _data; }
  constexpr T* end() const noexcept { return _data + _size; }

 private:
  T* _data = nullptr;
  std::size_t _size = 0;
};
#endif

/// Exactly n contiguous numbers: an array, a std::array, an Eigen vector or matrix of fixed size, or a map of one. Any
/// other size is a compile-time error.
template <class T, std::size_t n>
class Fixed {
 public:
  constexpr Fixed(T (&array)[n]) noexcept : _data(array) {}
  template <class U, class = std::enable_if_t<std::is_convertible_v<U (*)[], T (*)[]>>>
  constexpr Fixed(std::array<U, n>& array) noexcept : _data(array.data()) {}
  template <class U, class = std::enable_if_t<std::is_convertible_v<const U (*)[], T (*)[]>>>
  constexpr Fixed(const std::array<U, n>& array) noexcept : _data(array.data()) {}
  template <class Matrix, class Plain = std::remove_cv_t<std::remove_reference_t<Matrix>>,
            class = std::enable_if_t<static_cast<std::size_t>(Plain::SizeAtCompileTime) ==
                                         n&& static_cast<int>(Plain::InnerStrideAtCompileTime) == 1 &&
                                     (Plain::IsVectorAtCompileTime ||
                                      static_cast<int>(Plain::OuterStrideAtCompileTime) == 3)>>
  constexpr Fixed(Matrix&& matrix) noexcept : _data(matrix.data()) {}
  constexpr T* data() const noexcept { return _data; }

 private:
  T* _data;
};
using In3 = Fixed<const double, 3>;
using Out3 = Fixed<double, 3>;
using Out9 = Fixed<double, 9>;

/// Results of a call that belong to all its tools.
struct OrganReport {
  double energy_J = 0;     ///< stored; 0 in family rbfn
  double residual_m = 0;   ///< largest distance of a tool from the displacement that it prescribes
  double unbalanced = 0;   ///< of a body: size of the next step of Newton's method over that of the deformation; above
                           ///< 0.01 the status is PHN_WARNING_UNSETTLED
  std::int32_t steps = 0;  ///< of Newton's method, of a body
};

/// A model, a body of the same mesh, or both, with the working memory of one thread. It owns its memory and allocates
/// none after construction. It can be moved, which leaves the memory in place, but not copied.
///
/// One tool is answered by the model, several by the body, which does not follow one tool: the first call of several
/// makes up to steps_to_follow steps, so that their forces are there at once. Without a model the body answers one, and
/// without a body a model of node probes couples several. touch asks the body wherever there is one, so that its forces
/// do not change when a second sphere comes.
class Organ {
 public:
  static constexpr std::int32_t steps_to_follow = 20;
  /// 0 success, > 0 warnings (PHN_WARNING_*), < 0 an error, with zeros as outputs.
  class [[nodiscard]] Status {
   public:
    constexpr Status(int code = PHN_OK) noexcept : _code(code) {}
    constexpr operator int() const noexcept { return _code; }
    constexpr bool ok() const noexcept { return _code >= 0; }
    constexpr bool outside() const noexcept { return has(PHN_WARNING_OUTSIDE); }
    constexpr bool incomplete() const noexcept { return has(PHN_WARNING_INCOMPLETE); }
    constexpr bool unsettled() const noexcept { return has(PHN_WARNING_UNSETTLED); }
    constexpr bool are_near() const noexcept { return has(PHN_WARNING_NEAR); }
    constexpr bool relaxation() const noexcept { return has(PHN_WARNING_RELAXATION); }
    const char* message() const noexcept { return phn_status_message(_code); }
    constexpr void ignore() const noexcept {}

   private:
    constexpr bool has(int warning) const noexcept { return _code > 0 && (_code & warning) != 0; }
    int _code;
  };

  /// Nothing; every call returns PHN_ERROR_ARGUMENT.
  Organ() = default;
  /// @param model_text  of a model.txt, or empty: a body alone
  /// @param body_text   of a body.txt, or empty: a model alone
  /// @param max_tools   of one call; a body, and contact, have at most 8
  /// @param steps       of Newton's method, at most, that a body makes in one call of hold or touch
  explicit Organ(std::string_view model_text, std::string_view body_text = {}, std::int32_t max_tools = 1,
                 std::int32_t steps = 1)
      : _max_tools(max_tools), _steps(steps) {
    auto files = std::make_shared<Files>();
    _status = files->load(model_text, body_text, _wrong_byte);
    _files = std::move(files);
    if (_status.ok()) allocate();
    explain("the model", "the body", model_text, body_text);
  }
  /// The same of files. @param model  a model's folder or its model.txt; null: a body alone
  static Organ read(const char* model, const char* body = nullptr, std::int32_t max_tools = 1, std::int32_t steps = 1) {
    std::vector<char> model_text, body_text;
    std::string of_model = model != nullptr ? model : "";
    Organ none;
    none._status = PHN_ERROR_NOT_A_MODEL;
    if (model != nullptr && !content(model, model_text)) {
      of_model += "/model.txt";
      none._problem = std::string(model) + ": neither a model.txt nor a folder with one, or it is empty";
      if (!content(of_model.c_str(), model_text)) return none;
    }
    if (body != nullptr && !content(body, body_text)) {
      none._problem = std::string(body) + ": no file that can be read, or it is empty";
      return none;
    }
    Organ organ(view(model_text), view(body_text), max_tools, steps);
    organ.explain(of_model, body != nullptr ? body : "", view(model_text), view(body_text));
    return organ;
  }
  /// One of the same model and body, at rest, for another thread, with working memory of its own.
  Organ another() const {
    Organ other;
    other._files = _files;
    other._max_tools = _max_tools;
    other._steps = _steps;
    other._status = _status;
    other._problem = _problem;
    if (_files != nullptr && _status.ok()) other.allocate();
    return other;
  }
  Organ(Organ&& other) noexcept { swap(other); }
  Organ& operator=(Organ&& other) noexcept {
    Organ(std::move(other)).swap(*this);
    return *this;
  }

  explicit operator bool() const noexcept { return _status.ok(); }
  /// Of the construction. PHN_ERROR_NOT_A_MODEL: also of a file that cannot be read. PHN_ERROR_ARGUMENT: neither model
  /// nor body, max_tools or steps below 1, or a body of another mesh than the model.
  Status status() const noexcept { return _status; }
  /// What is wrong after the construction, with the name of the file, in words; empty if nothing is.
  const std::string& problem() const noexcept { return _problem; }
  /// Position of the first error in a refused text, counted from 1; it is the model's if there is no model(). 0: none.
  std::size_t wrong_byte() const noexcept { return _wrong_byte; }

  /// Contents; zeros and null without a model, or a body.
  const phn_info& info() const noexcept { return files().info; }
  const phn_body_contents& body_info() const noexcept { return files().body_info; }
  /// Bytes of model and body.
  std::size_t constant_bytes() const noexcept { return files().model_memory.size() + files().body_memory.size(); }
  /// The objects of the C library, for functions that are not wrapped; null where there is none.
  const phn_model* model() const noexcept { return files().model; }
  phn_data* data() noexcept { return _data; }
  const phn_body* body() const noexcept { return files().body; }
  phn_body_state* state() noexcept { return _state; }
  phn_contact* contact() noexcept { return _contact; }

  /// The place of the undeformed surface nearest to x [m], with displacement 0, its point [m] and the distance [m],
  /// which is negative for an x inside.
  Status nearest(In3 x, phn_tool& tool) const noexcept { return place(x.data(), tool, nullptr, nullptr); }
  Status nearest(In3 x, phn_tool& tool, Out3 point) const noexcept {
    return place(x.data(), tool, point.data(), nullptr);
  }
  Status nearest(In3 x, phn_tool& tool, Out3 point, double& distance) const noexcept {
    return place(x.data(), tool, point.data(), &distance);
  }

  /// The force [N] that holds a tool, with energy [J] and stiffness [N/m], 3 x 3 and symmetric. Without a model there
  /// is no stiffness: PHN_ERROR_UNDEFINED and zeros, also of the force.
  Status hold(const phn_tool& tool, Out3 force) noexcept { return hold_one(tool, force.data(), nullptr, nullptr); }
  Status hold(const phn_tool& tool, Out3 force, double& energy) noexcept {
    return hold_one(tool, force.data(), &energy, nullptr);
  }
  Status hold(const phn_tool& tool, Out3 force, double& energy, Out9 stiffness) noexcept {
    return hold_one(tool, force.data(), &energy, stiffness.data());
  }
  /// Of several tools. @param forces  tools.size() x 3
  Status hold(Span<const phn_tool> tools, Span<double> forces, OrganReport* report = nullptr) noexcept {
    OrganReport unused;
    OrganReport& made = report != nullptr ? *report : unused;
    made = {};
    if (forces.size() / 3 < tools.size()) return PHN_ERROR_BUFFER;
    if (tools.size() > PHN_MOST_COUPLED) return refused(forces, PHN_ERROR_TOO_MANY_TOOLS);
    const auto n = static_cast<std::int32_t>(tools.size());
    if (_state != nullptr && (n != 1 || _data == nullptr)) return solve_body(n, tools.data(), forces.data(), made);
    if (n != 1) return couple(n, tools.data(), forces.data(), made);
    const bool has_energy = info().has_energy != 0;
    return hold_one(tools[0], forces.data(), has_energy ? &made.energy_J : nullptr, nullptr);
  }

  /// Replaces the force of a hold by that of the body that relaxes, dt_s after the relax before (phn_relax).
  Status relax(const phn_tool& tool, double dt_s, Out3 force) noexcept {
    return relax(Span<const phn_tool>(&tool, 1), dt_s, Span<double>(force.data(), 3));
  }
  /// Of several tools. @param tools  of that hold, in the order of the relax before; histories of others begin anew
  /// @param forces  3 tools.size() numbers, elastic ones at first
  Status relax(Span<const phn_tool> tools, double dt_s, Span<double> forces) noexcept {
    if (forces.size() < 3 * tools.size()) return PHN_ERROR_BUFFER;
    if (!_status.ok()) return refused(forces, PHN_ERROR_ARGUMENT);
    if (tools.size() > _histories.size()) return refused(forces, PHN_ERROR_TOO_MANY_TOOLS);
    int all = PHN_OK;
    for (std::size_t t = 0; t < _histories.size(); ++t) {
      if (t >= tools.size()) {
        _histories[t] = {};
        continue;
      }
      double place[3];
      rest_point(tools[t], place);
      double* const force = forces.data() + 3 * t;
      const int status = phn_relax(&relaxation(), &_histories[t], force, place, dt_s, force);
      if (status < 0) return refused(forces, status);
      all |= status;
    }
    return all;
  }
  /// The relaxation of the model, or without a model of the body.
  const phn_relaxation& relaxation() const noexcept {
    return model() != nullptr ? info().relaxation : body_info().relaxation;
  }
  /// The history of a tool of relax(), whose `outward` the caller may set. @pre below max_tools
  phn_relaxing& history(std::size_t tool) noexcept { return _histories[tool]; }

  /// Moves spheres (phynness_contact.h), in every millisecond of a haptic loop. @param states  spheres.size() of them
  Status touch(Span<const phn_contact_tool> spheres, Span<phn_contact_state> states,
               OrganReport* report = nullptr) noexcept {
    OrganReport unused;
    OrganReport& made = report != nullptr ? *report : unused;
    made = {};
    if (states.size() < spheres.size()) return PHN_ERROR_BUFFER;
    if (spheres.size() > PHN_MOST_COUPLED) return PHN_ERROR_TOO_MANY_TOOLS;
    return step(static_cast<std::int32_t>(spheres.size()), spheres.data(), states.data(), made);
  }

  /// Displacements [m] in the last hold or touch, zeros before: of the model's output nodes, n_output x 3, also where a
  /// body answered, which leaves nodes inside of it at 0. Without a model of the body's nodes, n_nodes x 3.
  Status deform(Span<double> out) noexcept {
    if (!_status.ok()) return PHN_ERROR_ARGUMENT;
    if (out.size() < n_deform()) return PHN_ERROR_BUFFER;
    return write_field(out.data());
  }
  /// Numbers that deform writes.
  std::size_t n_deform() const noexcept {
    return 3 * static_cast<std::size_t>(_data != nullptr ? info().n_output : body_info().n_nodes);
  }

  /// Bounds [N] of the errors of the forces of the last hold (of a model, of its full level), one for each of its
  /// tools; after an error PHN_NO_BOUND in all of `bounds`. PHN_ERROR_UNDEFINED: there are none, or the last call was
  /// not hold. PHN_ERROR_ARGUMENT: state() was since pressed by another number of tools.
  Status bound(Span<double> bounds) noexcept {
    const std::size_t n = _last == LastCall::of_tool ? 1 : _last == LastCall::of_tools ? _n_tools : 0;
    std::fill_n(bounds.data(), bounds.size(), PHN_NO_BOUND);
    if (n == 0) return PHN_ERROR_UNDEFINED;
    if (bounds.size() < n) return PHN_ERROR_BUFFER;
    return bounds_of(bounds.data());
  }
  /// Of one tool that the model may hold; PHN_NO_BOUND outside of the trained range and after an error.
  Status bound(const phn_tool& tool, double& bound) const noexcept { return phn_bound(model(), &tool, &bound); }
  /// Depth [m] of the trained range, of the model where there is one, at the place of a tool in the direction of its
  /// displacement; at rest the smallest.
  Status depth(const phn_tool& tool, double& depth) const noexcept {
    if (model() != nullptr) return phn_depth(model(), &tool, &depth);
    depth = body_info().max_displacement_m;
    return body() != nullptr ? PHN_OK : PHN_ERROR_ARGUMENT;
  }

  /// The body back to rest, and every contact ended; in the next touch all spheres are new.
  Status reset() noexcept {
    if (!_status.ok()) return PHN_ERROR_ARGUMENT;
    _last = LastCall::none;
    std::fill(_histories.begin(), _histories.end(), phn_relaxing{});
    if (_contact != nullptr) phn_contact_reset(_contact);
    if (_state == nullptr) return PHN_OK;
    return phn_body_state_init(_state_memory.data(), _state_memory.size(), body(), most_tools(), &_state);
  }

 private:
  using Bytes = std::vector<std::byte>;
  enum class LastCall { none, of_tool, of_tools, of_spheres };

  static bool is_of_this_library() noexcept {
    const auto same = [](const char* name, std::size_t bytes) {
      return phn_sizeof(name) == static_cast<std::int32_t>(bytes);
    };
    return phn_abi_version() == PHN_ABI_VERSION && same("phn_info", sizeof(phn_info)) &&
           same("phn_relaxation", sizeof(phn_relaxation)) && same("phn_relaxing", sizeof(phn_relaxing)) &&
           same("phn_level", sizeof(phn_level)) && same("phn_tool", sizeof(phn_tool)) &&
           same("phn_coupled", sizeof(phn_coupled)) && same("phn_body_contents", sizeof(phn_body_contents)) &&
           same("phn_body_report", sizeof(phn_body_report)) && same("phn_contact_tool", sizeof(phn_contact_tool)) &&
           same("phn_contact_state", sizeof(phn_contact_state)) &&
           same("phn_contact_report", sizeof(phn_contact_report));
  }

  /// Contents of the files, which threads share.
  struct Files {
    Files() {
      phn_model_info(nullptr, &info);
      phn_body_info(nullptr, &body_info);
    }
    int load(std::string_view model_text, std::string_view body_text, std::size_t& wrong) {
      if (!is_of_this_library()) return PHN_ERROR_VERSION;
      if (model_text.empty() && body_text.empty()) return PHN_ERROR_ARGUMENT;
      std::size_t bytes = 0;
      int status = PHN_OK;
      if (!model_text.empty()) {
        status = phn_model_size(model_text.data(), model_text.size(), &bytes, &wrong);
        if (status < 0) return status;
        model_memory.resize(bytes);
        status = phn_model_init(model_memory.data(), bytes, model_text.data(), model_text.size(), &model, &wrong);
        if (status < 0) return status;
        phn_model_info(model, &info);
      }
      if (body_text.empty()) return PHN_OK;
      status = phn_body_size(body_text.data(), body_text.size(), &bytes, &wrong);
      if (status < 0) return status;
      body_memory.resize(bytes);
      status = phn_body_init(body_memory.data(), bytes, body_text.data(), body_text.size(), &body, &wrong);
      if (status < 0) return status;
      phn_body_info(body, &body_info);
      if (model == nullptr) return PHN_OK;
      if (!is_of_one_mesh()) return PHN_ERROR_ARGUMENT;
      rows.resize(static_cast<std::size_t>(info.n_output));
      for (std::size_t o = 0; o < rows.size(); ++o) {
        const std::int32_t *end = body_info.nodes + body_info.n_nodes,
                           *at = std::lower_bound(body_info.nodes, end, info.output_nodes[o]);
        rows[o] = at != end && *at == info.output_nodes[o] ? at - body_info.nodes : -1;
      }
      return PHN_OK;
    }
    bool is_of_one_mesh() const {
      const std::string_view of_model = info.mesh_hash, of_body = body_info.mesh_hash;
      return of_model.empty() || of_body.empty() || of_model == of_body;
    }

    Bytes model_memory, body_memory;
    const phn_model* model = nullptr;
    const phn_body* body = nullptr;
    phn_info info;
    phn_body_contents body_info;
    std::vector<std::ptrdiff_t> rows;  ///< of the output nodes among the body's nodes; -1: inside of the body
  };

  static std::string_view view(const std::vector<char>& text) noexcept {
    return {text.empty() ? "" : text.data(), text.size()};
  }
  /// @return whether the file has any
  static bool content(const char* file, std::vector<char>& text) {
    text.clear();
    std::FILE* const stream = std::fopen(file, "rb");
    if (stream == nullptr) return false;
    constexpr std::size_t block = 1 << 20;
    for (std::size_t n = block; n == block;) {
      text.resize(text.size() + block);
      n = std::fread(text.data() + text.size() - block, 1, block, stream);
      text.resize(text.size() - block + n);
    }
    std::fclose(stream);
    return !text.empty();
  }

  /// Sets the words of a status. @param of_model, of_body  names of the texts
  void explain(const std::string& of_model, const std::string& of_body, std::string_view model_text,
               std::string_view body_text) {
    _problem.clear();
    if (_status.ok()) return;
    const bool is_of_model = model() == nullptr && !model_text.empty();
    const bool is_of_body = !is_of_model && body() == nullptr && !body_text.empty();
    const auto begins = [&](std::string_view word) {
      return (is_of_model ? model_text : body_text).substr(0, word.size()) == word;
    };
    if (is_of_model || is_of_body) {
      _problem = (is_of_model ? of_model : of_body) + ": ";
      if (is_of_model && begins("phynness-body ")) {
        _problem += "this is a body, and no model";
      } else if (is_of_body && begins("phynness-model ")) {
        _problem += "this is a model, and no body";
      } else {
        _problem += _status == PHN_ERROR_NOT_A_MODEL && is_of_body ? "this is not a phynness body" : _status.message();
        if (_wrong_byte > 0) _problem += ", at byte " + std::to_string(_wrong_byte);
      }
    } else if (model() != nullptr && body() != nullptr && !files().is_of_one_mesh()) {
      _problem = of_body + ": the body is of another mesh than " + of_model;
    } else {
      _problem = _status.message();
    }
  }

  const Files& files() const noexcept {
    static const Files none;
    return _files != nullptr ? *_files : none;
  }
  /// Tools of a body and of contact.
  std::int32_t most_tools() const noexcept { return (std::min<std::int32_t>)(_max_tools, PHN_MOST_COUPLED); }

  /// Makes an object of the C library in memory. @return a status
  template <class Object, class Size, class Init, class Of>
  static int make(Bytes& memory, Object*& object, Size&& size, Init&& init, const Of* of, std::int32_t n) {
    std::size_t bytes = 0;
    const int status = size(of, n, &bytes);
    if (status < 0) return status;
    memory.resize(bytes);
    return init(memory.data(), bytes, of, n, &object);
  }
  void allocate() {
    if (_steps < 1) _status = PHN_ERROR_ARGUMENT;
    if (_max_tools > 0) _histories.resize(static_cast<std::size_t>(_max_tools));
    if (_status.ok() && model() != nullptr)
      _status = make(_data_memory, _data, phn_data_size, phn_data_init, model(), _max_tools);
    if (_status.ok() && body() != nullptr)
      _status = make(_state_memory, _state, phn_body_state_size, phn_body_state_init, body(), most_tools());
    if (!_status.ok()) return;
    // An organ without a surface that can be touched is one for hold alone.
    const auto init = [this](void* memory, std::size_t bytes, const phn_body* of, std::int32_t n,
                             phn_contact** contact) {
      return phn_body_contact_init(memory, bytes, of, n, _steps, contact);
    };
    _touch_status = body() != nullptr
                        ? make(_touch_memory, _contact, phn_body_contact_size, init, body(), most_tools())
                        : make(_touch_memory, _contact, phn_contact_size, phn_contact_init, model(), most_tools());
    if (model() != nullptr && body() != nullptr) _field.resize(3 * static_cast<std::size_t>(body_info().n_nodes));
  }

  /// The undeformed place of a tool, of nodes that are known.
  void rest_point(const phn_tool& tool, double* x) const noexcept {
    std::fill_n(x, 3, 0.0);
    const auto add = [&](const std::int32_t* nodes, std::int32_t n, const double* points, int corner) {
      const std::int32_t* const at = std::lower_bound(nodes, nodes + n, tool.nodes[corner]);
      if (at == nodes + n || *at != tool.nodes[corner]) return;
      for (int k = 0; k < 3; ++k) x[k] += tool.weights[corner] * points[3 * (at - nodes) + k];
    };
    for (int corner = 0; corner < 3; ++corner) {
      if (model() == nullptr) {
        add(body_info().nodes, body_info().n_nodes, body_info().points, corner);
        continue;
      }
      add(info().output_nodes, info().n_output, info().output_points, corner);
      add(info().fixed_nodes, info().n_fixed, info().fixed_points, corner);
    }
  }

  static int refused(Span<double> forces, int status) noexcept {
    std::fill_n(forces.data(), forces.size(), 0.0);
    return status;
  }
  Status place(const double* x, phn_tool& tool, double* point, double* distance) const noexcept {
    return model() != nullptr ? phn_nearest(model(), x, &tool, point, distance)
                              : phn_body_nearest(body(), x, &tool, point, distance);
  }
  Status hold_one(const phn_tool& tool, double* force, double* energy, double* stiffness) noexcept {
    if (_data == nullptr && _state != nullptr) {
      OrganReport made;
      const Status status = solve_body(1, &tool, force, made);
      if (energy != nullptr) *energy = made.energy_J;
      if (stiffness == nullptr) return status;
      std::fill_n(stiffness, 9, 0.0);
      if (energy != nullptr) *energy = 0;
      return refused({force, 3}, PHN_ERROR_UNDEFINED);
    }
    _last = LastCall::of_tool;
    _tool = tool;
    return phn_force(model(), _data, &_tool, force, energy, stiffness);
  }
  Status couple(std::int32_t n, const phn_tool* tools, double* forces, OrganReport& made) noexcept {
    _last = LastCall::of_tools;
    _n_tools = static_cast<std::size_t>(n);
    phn_coupled coupled{};
    const int status = phn_couple(model(), _data, n, tools, forces, &coupled);
    made.energy_J = coupled.energy;
    made.residual_m = coupled.residual;
    return status;
  }
  Status solve_body(std::int32_t n, const phn_tool* tools, double* forces, OrganReport& made) noexcept {
    const bool follows = _data == nullptr || _last == LastCall::of_tools;
    const std::int32_t steps = follows || _steps > steps_to_follow ? _steps : steps_to_follow;
    _last = LastCall::of_tools;
    _n_tools = static_cast<std::size_t>(n);
    phn_body_report pressed{};
    const int status = phn_body_force(body(), _state, n, tools, steps, forces, &pressed);
    made = {pressed.energy, pressed.residual_m, pressed.unbalanced, pressed.steps};
    return status;
  }
  Status step(std::int32_t n, const phn_contact_tool* spheres, phn_contact_state* states, OrganReport& made) noexcept {
    if (_contact == nullptr) return _touch_status;
    _last = LastCall::of_spheres;
    phn_contact_report report{};
    const int status = phn_contact_step(_contact, n, spheres, states, &report);
    made = {report.energy, report.residual_m, report.unbalanced, report.steps};
    return status;
  }
  Status write_field(double* out) noexcept {
    const bool of_body = _state != nullptr && (_data == nullptr || _last != LastCall::of_tool);
    if (_last == LastCall::none) {
      std::fill_n(out, n_deform(), 0.0);
      return PHN_OK;
    }
    if (of_body) {
      double* const field = _data != nullptr ? _field.data() : out;
      const int status =
          _last == LastCall::of_spheres ? phn_contact_deform(_contact, field) : phn_body_deform(body(), _state, field);
      for (std::size_t o = 0; o < files().rows.size(); ++o)
        for (std::size_t k = 0; k < 3; ++k)
          out[3 * o + k] = files().rows[o] < 0 ? 0 : _field[3 * static_cast<std::size_t>(files().rows[o]) + k];
      return status;
    }
    if (_last == LastCall::of_spheres) return phn_contact_deform(_contact, out);
    if (_last == LastCall::of_tools) return phn_coupled_deform(model(), _data, out);
    return phn_deform(model(), _data, &_tool, out);
  }
  Status bounds_of(double* bounds) const noexcept {
    if (_last == LastCall::of_tool) return phn_bound(model(), &_tool, bounds);
    if (_state != nullptr) return phn_body_bound(body(), _state, static_cast<std::int32_t>(_n_tools), bounds);
    return PHN_ERROR_UNDEFINED;
  }

  void swap(Organ& other) noexcept {
    std::swap(_files, other._files);
    std::swap(_data_memory, other._data_memory);
    std::swap(_state_memory, other._state_memory);
    std::swap(_touch_memory, other._touch_memory);
    std::swap(_field, other._field);
    std::swap(_histories, other._histories);
    std::swap(_data, other._data);
    std::swap(_state, other._state);
    std::swap(_contact, other._contact);
    std::swap(_tool, other._tool);
    std::swap(_n_tools, other._n_tools);
    std::swap(_last, other._last);
    std::swap(_max_tools, other._max_tools);
    std::swap(_steps, other._steps);
    std::swap(_wrong_byte, other._wrong_byte);
    std::swap(_problem, other._problem);
    std::swap(_status, other._status);
    std::swap(_touch_status, other._touch_status);
  }

  std::shared_ptr<const Files> _files;
  Bytes _data_memory, _state_memory, _touch_memory;
  std::vector<double> _field;
  std::vector<phn_relaxing> _histories;
  phn_data* _data = nullptr;
  phn_body_state* _state = nullptr;
  phn_contact* _contact = nullptr;
  phn_tool _tool{};
  std::size_t _n_tools = 0;
  LastCall _last = LastCall::none;
  std::int32_t _max_tools = 1, _steps = 1;
  std::size_t _wrong_byte = 0;
  std::string _problem = phn_status_message(PHN_ERROR_ARGUMENT);
  Status _status = PHN_ERROR_ARGUMENT, _touch_status = PHN_ERROR_ARGUMENT;
};

}  // namespace phynness

#endif
