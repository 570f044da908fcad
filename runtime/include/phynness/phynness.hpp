// phynness for C++17: the functions of phynness.h and phynness_tools.h as members of objects. An object owns its memory
// or uses memory of the caller. After construction nothing is allocated. No exceptions and no RTTI are used: functions
// that can fail return a [[nodiscard]] Status, and an object whose construction failed converts to false and has a
// status. Meaning, cost and errors of each function are described in those headers.
#ifndef PHYNNESS_HPP
#define PHYNNESS_HPP

#include <phynness/phynness.h>

#include <array>
#include <cstddef>
#include <cstdio>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
#if __cplusplus >= 202002L
#include <span>
#endif

namespace phynness::rt {

/// Status of a function of phynness.h: 0 success, > 0 warnings (PHN_WARNING_*), < 0 an error, with zeros as outputs.
class [[nodiscard]] Status {
 public:
  constexpr Status(int code = PHN_OK) noexcept : _code(code) {}
  constexpr operator int() const noexcept { return _code; }
  constexpr bool ok() const noexcept { return _code >= 0; }
  constexpr bool outside() const noexcept { return _code > 0 && (_code & PHN_WARNING_OUTSIDE) != 0; }
  constexpr bool incomplete() const noexcept { return _code > 0 && (_code & PHN_WARNING_INCOMPLETE) != 0; }
  constexpr bool unsettled() const noexcept { return _code > 0 && (_code & PHN_WARNING_UNSETTLED) != 0; }
  constexpr bool near() const noexcept { return _code > 0 && (_code & PHN_WARNING_NEAR) != 0; }
  const char* message() const noexcept { return phn_status_message(_code); }
  constexpr void ignore() const noexcept {}

 private:
  int _code;
};

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

namespace detail {
/// Memory of an object, owned or provided by the caller.
class Memory {
 public:
  /// @return `own` unless it is empty, else `bytes` bytes of new memory that this object owns
  void* place(Span<std::byte> own, std::size_t bytes) {
    if (own.data() != nullptr) return own.data();
    _owned.resize(bytes);
    return _owned.data();
  }

 private:
  std::vector<std::byte> _owned;
};

/// What all classes of the wrapper are: an object of the C library in memory of its own or of the caller, and its
/// status. It can be moved, which leaves the memory in place and the other one as if constructed without arguments, but
/// not copied.
/// @tparam Object  of the C library
/// @tparam More    what a class keeps beside it
template <class Object, class More>
class Built {
 public:
  Built(Built&& other) noexcept { swap(other); }
  Built& operator=(Built&& other) noexcept {
    Built(std::move(other)).swap(*this);
    return *this;
  }
  explicit operator bool() const noexcept { return _object != nullptr; }
  Status status() const noexcept { return _status; }
  Object* get() const noexcept { return _object; }

 protected:
  Built() = default;
  /// @param size  called with the address of the number of bytes, returns a status
  /// @param init  called with memory, its bytes and the address of the object, returns a status
  /// @return the bytes that the object needs; 0 if there is none
  template <class Size, class Init>
  std::size_t build(Span<std::byte> own, Size&& size, Init&& init) {
    std::size_t bytes = 0;
    _status = size(&bytes);
    if (!_status.ok()) return 0;
    void* place = _memory.place(own, bytes);
    _status = init(place, own.data() ? own.size() : bytes, &_object);
    return _status.ok() ? bytes : 0;
  }
  /// The same for functions of a model and a number.
  template <class Size, class Init>
  std::size_t build(const phn_model* model, std::int32_t number, Span<std::byte> own, Size&& size, Init&& init) {
    return build(
        own, [&](std::size_t* bytes) { return size(model, number, bytes); },
        [&](void* place, std::size_t bytes, Object** object) { return init(place, bytes, model, number, object); });
  }
  /// @return the bytes that `size` tells; 0 if there is no object of these arguments
  template <class Size, class... Arguments>
  static std::size_t bytes_of(Size&& size, Arguments... arguments) noexcept {
    std::size_t bytes = 0;
    return size(arguments..., &bytes) == PHN_OK ? bytes : 0;
  }
  More& more() noexcept { return _more; }
  const More& more() const noexcept { return _more; }

 private:
  void swap(Built& other) noexcept {
    std::swap(_memory, other._memory);
    std::swap(_object, other._object);
    std::swap(_more, other._more);
    std::swap(_status, other._status);
  }

  Memory _memory;
  Object* _object = nullptr;
  More _more = {};
  Status _status = PHN_ERROR_ARGUMENT;
};

struct Nothing {};
struct FieldSize {
  std::size_t n_field = 0;  ///< 3 n_output
};
struct ModelContent {
  static phn_info none() noexcept {
    phn_info info;
    phn_model_info(nullptr, &info);
    return info;
  }
  phn_info info = none();
  std::size_t bytes = 0, wrong_byte = 0;
};
struct DataSizes {
  const phn_model* model = nullptr;
  std::size_t n_field = 0;  ///< 3 n_output
};
}  // namespace detail

/// A model. It is constant and may be shared between threads. It can be moved, which leaves the memory in place, but
/// not copied.
class Model : public detail::Built<const phn_model, detail::ModelContent> {
 public:
  Model() = default;
  /// @param text  text of model.txt; not used after construction
  /// @param own   memory of at least bytes_for(text) bytes that outlives the model; empty: the model allocates memory
  explicit Model(std::string_view text, Span<std::byte> own = {}) {
    auto& content = more();
    const auto size = [&](std::size_t* bytes) {
      return phn_model_size(text.data(), text.size(), bytes, &content.wrong_byte);
    };
    const auto init = [&](void* place, std::size_t bytes, const phn_model** model) {
      return phn_model_init(place, bytes, text.data(), text.size(), model, &content.wrong_byte);
    };
    content.bytes = build(own, size, init);
    if (content.bytes > 0) phn_model_info(get(), &content.info);
  }

  /// The model in a file; status PHN_ERROR_NOT_A_MODEL if the file cannot be read.
  static Model read(const char* file) {
    std::vector<char> text;
    if (std::FILE* stream = std::fopen(file, "rb")) {
      constexpr std::size_t block = 1 << 20;
      for (std::size_t n = block; n == block;) {
        text.resize(text.size() + block);
        n = std::fread(text.data() + text.size() - block, 1, block, stream);
        text.resize(text.size() - block + n);
      }
      std::fclose(stream);
    }
    return Model(std::string_view(text.empty() ? "" : text.data(), text.size()));
  }
  /// Memory [bytes] of the model in a text; 0 if the text is refused.
  static std::size_t bytes_for(std::string_view text) noexcept {
    std::size_t bytes = 0;
    return phn_model_size(text.data(), text.size(), &bytes, nullptr) == PHN_OK ? bytes : 0;
  }

  /// Position of the first error in a refused text, counted from 1; 0 for a valid text.
  std::size_t wrong_byte() const noexcept { return more().wrong_byte; }
  /// Memory of the model [bytes].
  std::size_t bytes() const noexcept { return more().bytes; }

  /// Contents of the model; without a model all zeros.
  const phn_info& info() const noexcept { return more().info; }
  std::int32_t n_nodes() const noexcept { return info().n_nodes; }
  std::int32_t n_output() const noexcept { return info().n_output; }
  Span<const std::int32_t> active_nodes() const noexcept { return view(info().active_nodes, info().n_active); }
  Span<const std::int32_t> output_nodes() const noexcept { return view(info().output_nodes, info().n_output); }
  Span<const std::int32_t> fixed_nodes() const noexcept { return view(info().fixed_nodes, info().n_fixed); }
  /// n x 3, row by row
  Span<const double> output_points() const noexcept { return view(info().output_points, 3 * info().n_output); }
  Span<const double> fixed_points() const noexcept { return view(info().fixed_points, 3 * info().n_fixed); }
  Span<const std::int32_t> triangles() const noexcept { return view(info().triangles, 3 * info().n_triangles); }
  std::int32_t n_fields() const noexcept { return info().n_fields; }
  std::int32_t n_levels() const noexcept { return info().n_levels; }
  Status level_info(std::int32_t level, phn_level& info) const noexcept { return phn_level_info(get(), level, &info); }

  Status trained_depth(std::int32_t node, In3 d, double& depth_m) const noexcept {
    return phn_trained_depth(get(), node, d.data(), &depth_m);
  }
  Status bound(std::int32_t node, In3 d, double& bound) const noexcept {
    return phn_bound(get(), node, d.data(), &bound);
  }
  Status trained_depth(const phn_tool& tool, double& depth_m) const noexcept {
    return phn_trained_depth_at(get(), &tool, &depth_m);
  }
  Status bound(const phn_tool& tool, double& bound) const noexcept { return phn_bound_at(get(), &tool, &bound); }
  Status nearest(In3 x, phn_tool& tool) const noexcept { return phn_nearest(get(), x.data(), &tool, nullptr); }
  Status nearest(In3 x, phn_tool& tool, Out3 point) const noexcept {
    return phn_nearest(get(), x.data(), &tool, point.data());
  }

 private:
  template <class T>
  static Span<const T> view(const T* data, std::int32_t n) noexcept {
    return {data, static_cast<std::size_t>(n)};
  }
};

/// Working memory of one thread, with the functions that use it. Output spans may be longer than needed. A span that is
/// too short is not written, and the status is PHN_ERROR_BUFFER. @pre the model outlives this object
class Data : public detail::Built<phn_data, detail::DataSizes> {
 public:
  Data() = default;
  Data(const Model& model, std::int32_t max_tools, Span<std::byte> own = {}) {
    more().model = model.get();
    if (build(model.get(), max_tools, own, phn_data_size, phn_data_init) == 0) return;
    more().n_field = 3 * static_cast<std::size_t>(model.n_output());
  }
  static std::size_t bytes_for(const Model& model, std::int32_t max_tools) noexcept {
    return bytes_of(phn_data_size, model.get(), max_tools);
  }

  Status force(std::int32_t node, In3 d, Out3 force_N) noexcept {
    return phn_force(more().model, get(), node, d.data(), force_N.data(), nullptr, nullptr);
  }
  /// Force, energy and stiffness in one call. @param stiffness_N_per_m  3 x 3, symmetric
  Status force(std::int32_t node, In3 d, Out3 force_N, double& energy_J, Out9 stiffness_N_per_m) noexcept {
    return phn_force(more().model, get(), node, d.data(), force_N.data(), &energy_J, stiffness_N_per_m.data());
  }
  Status force(std::int32_t node, In3 d, Out3 force_N, double& energy_J) noexcept {
    return phn_force(more().model, get(), node, d.data(), force_N.data(), &energy_J, nullptr);
  }
  Status energy(std::int32_t node, In3 d, double& energy_J) noexcept {
    return phn_force(more().model, get(), node, d.data(), nullptr, &energy_J, nullptr);
  }
  /// @param stiffness_N_per_m  3 x 3, symmetric
  Status stiffness(std::int32_t node, In3 d, Out9 stiffness_N_per_m) noexcept {
    return phn_force(more().model, get(), node, d.data(), nullptr, nullptr, stiffness_N_per_m.data());
  }
  /// One tool at a point; families with an energy. @param stiffness_N_per_m  3 x 3, symmetric
  Status force(const phn_tool& tool, Out3 force_N, double& energy_J, Out9 stiffness_N_per_m) noexcept {
    return phn_force_at(more().model, get(), &tool, force_N.data(), &energy_J, stiffness_N_per_m.data());
  }
  Status force(const phn_tool& tool, Out3 force_N) noexcept {
    return phn_force_at(more().model, get(), &tool, force_N.data(), nullptr, nullptr);
  }
  /// @param out  n_output x 3
  Status deform(std::int32_t node, In3 d, Span<double> out) noexcept {
    return out.size() < more().n_field ? Status(PHN_ERROR_BUFFER)
                                       : Status(phn_deform(more().model, get(), node, d.data(), out.data()));
  }
  /// The paper's blending of several tools. @param displacements  nodes.size() x 3; @param out  n_output x 3
  Status blend_paper(Span<const std::int32_t> nodes, Span<const double> displacements, Span<double> out) noexcept {
    if (out.size() < more().n_field || displacements.size() < 3 * nodes.size()) return PHN_ERROR_BUFFER;
    if (nodes.size() > INT32_MAX / 3) return PHN_ERROR_TOOLS;
    return phn_blend_paper(more().model, get(), static_cast<std::int32_t>(nodes.size()), nodes.data(),
                           displacements.data(), out.data());
  }
  Status prepare(std::int32_t node) noexcept { return phn_prepare(more().model, get(), node); }
  /// @param out  n_output values
  Status field(std::int32_t node, In3 d, std::int32_t number, Span<double> out) noexcept {
    return 3 * out.size() < more().n_field ? Status(PHN_ERROR_BUFFER)
                                           : Status(phn_field(more().model, get(), node, d.data(), number, out.data()));
  }

  Status set_level(std::int32_t level) noexcept { return phn_set_level(more().model, get(), level); }

  /// @param forces_N  tools.size() x 3
  Status couple(Span<const phn_tool> tools, Span<double> forces_N, phn_coupled* result = nullptr) noexcept {
    if (forces_N.size() / 3 < tools.size()) return PHN_ERROR_BUFFER;
    if (tools.size() > PHN_MOST_COUPLED) return PHN_ERROR_TOO_MANY_TOOLS;
    return phn_couple(more().model, get(), static_cast<std::int32_t>(tools.size()), tools.data(), forces_N.data(),
                      result);
  }
  Status couple(const phn_tool& tool, Out3 force_N, phn_coupled* result = nullptr) noexcept {
    return phn_couple(more().model, get(), 1, &tool, force_N.data(), result);
  }
  Status coupled_deform(Span<double> out) noexcept {
    return out.size() < more().n_field ? Status(PHN_ERROR_BUFFER)
                                       : Status(phn_coupled_deform(more().model, get(), out.data()));
  }
};

}  // namespace phynness::rt

#endif
