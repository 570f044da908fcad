// Reads a body.txt by the grammar of phynness/schema/body_grammar.hpp.
#include <cfloat>
#include <cmath>
#include <cstring>

#include <phynness/schema/round_tool.hpp>

#include "body/body.hpp"
#include "core/evaluate.hpp"
#include "core/text_lines.hpp"

namespace PHN_RUNTIME {
namespace {

/// Numbers in the memory of the body. Without memory they are only counted.
template <class T>
struct Numbers {
  T* data = nullptr;
  std::int64_t n = 0, n_cols = 1;
  void shape(Arena& arena, std::int64_t rows, std::int64_t cols) {
    n = rows;
    n_cols = cols;
    data = arena.take<T>(static_cast<std::size_t>(rows), static_cast<std::size_t>(cols));
  }
  template <class V>
  void set(std::int64_t i, std::int64_t k, V value) {
    if (data) data[i * n_cols + k] = static_cast<T>(value);
  }
};

/// Rows of floats, padded to whole blocks.
struct PaddedRows {
  const Numbers<double>* scale = nullptr;
  float* data = nullptr;
  std::int64_t n = 0, n_cols = 0;
  std::int32_t stride = 0;
  void shape(Arena& arena, std::int64_t rows, std::int64_t cols) {
    n = rows;
    n_cols = cols;
    stride = whole_blocks(static_cast<std::int32_t>(cols));
    data = arena.take<float>(static_cast<std::size_t>(rows), static_cast<std::size_t>(stride));
  }
  void set(std::int64_t i, std::int64_t k, std::int32_t entry) {
    if (data == nullptr) return;
    if (k == 0)
      for (std::int64_t pad = n_cols; pad < stride; ++pad) data[i * stride + pad] = 0;
    data[i * stride + k] = static_cast<float>(scale->data[k] * entry);
  }
  RowMatrix matrix() const { return {data, n, stride}; }
};

struct ScaledRows {
  Numbers<double> scale;
  PaddedRows entries;
  ScaledRows() { entries.scale = &scale; }
  ScaledRows(const ScaledRows&) = delete;
};

struct Parameters {
  double data[schema::largest_parameter_count] = {};
  std::int64_t n = 0;
  void shape(Arena&, std::int64_t rows, std::int64_t) { n = rows; }
  void set(std::int64_t i, std::int64_t, double value) { data[i] = value; }
};

struct BodyStore {
  const char *mesh_hash = "", *physics_hash = "", *law = "";
  Parameters parameters;
  double bulk_in_shape_Pa = 0, tool_radius_m = 0, depth_m = 0;
  phn_relaxation made = {};
  RelaxationStore relaxation{{made}};
  Numbers<std::int32_t> nodes, kinds, surface;
  Numbers<double> points, shear_m3, bulk_rJ, regions;
  Numbers<std::int32_t> region_of_cell;
  ScaledRows modes, gradients, cells_at_rest, lack_at_rest, pressures, lacking;
  double coverage = 0;
  std::int32_t n_rays = 0;
  Numbers<double> bounds;
};

/// The `io` of the grammar for reading.
class BodyLoader : public LinesReader {
 public:
  BodyLoader(TextReader& in, Arena& arena) : LinesReader(in), _arena(arena) {}

  void word(const char* key, const char*& word) {
    const auto token = _in.word(static_cast<std::size_t>(schema::longest_word));
    char copy[schema::longest_word + 1] = {};
    if (good()) memcpy(copy, token.begin, token.length());
    if (strcmp(key, "law") == 0) law = find_body_law(copy);
    char* to = _arena.take<char>(token.length() + 1);
    if (to == nullptr) return;
    memcpy(to, token.begin, token.length());
    to[token.length()] = 0;
    word = to;
  }
  template <class Store>
  static std::int64_t rows(const Store& store) {
    return store.n;
  }
  template <class Store>
  static std::int64_t cols(const Store& store) {
    return store.n_cols;
  }
  template <class Store, class Value>
  static void set(Store& store, std::int64_t i, std::int64_t k, Value value) {
    store.set(i, k, value);
  }
  template <class Store>
  void shape(const char*, Store& store, std::int64_t rows, std::int64_t cols) {
    store.shape(_arena, good() ? rows : 0, good() ? cols : 0);
  }

  const BodyLaw* law = nullptr;  ///< null for an unknown one

 private:
  Arena& _arena;
};

/// Sets the unit normals of the nodes: means of the normals of their triangles, weighted by area.
void set_normals(const phn_body& body, double* normals) {
  const auto n_nodes = static_cast<std::size_t>(body.info.n_nodes);
  set_zero(normals, 3 * n_nodes);
  for (std::int32_t t = 0; t < body.info.n_triangles; ++t) {
    const std::int32_t* corner = body.info.triangles + 3 * static_cast<std::size_t>(t);
    Vector x[3];
    for (int k = 0; k < 3; ++k) x[k] = vector_at(body.info.points + 3 * static_cast<std::size_t>(corner[k]));
    const Vector normal = cross(x[1] - x[0], x[2] - x[0]);
    for (int k = 0; k < 3; ++k) add_scaled(1, normal.x, 3, normals + 3 * static_cast<std::size_t>(corner[k]));
  }
  for (std::size_t i = 0; i < n_nodes; ++i) {
    const double size = length(normals + 3 * i);
    for (std::size_t k = 0; k < 3 && size > 0; ++k) normals[3 * i + k] /= size;
  }
}

/// Sets the materials of the body and of its regions.
void set_materials(const BodyStore& store, const BodyLaw& law, BodyMaterial* materials) {
  const double F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (std::int64_t m = 0; m <= store.regions.n; ++m) {
    BodyMaterial& material = materials[m];
    const double* of_region = m > 0 ? store.regions.data + (m - 1) * store.regions.n_cols : nullptr;
    for (int k = 0; k < schema::largest_parameter_count; ++k)
      material.parameters[k] = of_region && k < store.parameters.n ? of_region[k] : store.parameters.data[k];
    material.bulk = of_region ? of_region[store.parameters.n] : store.bulk_in_shape_Pa;
    material.modulus = 0;
    double value, stress[9], A[81];
    if (!law.shape(F, material.parameters, value, stress, A)) continue;
    for (const double a : A) material.modulus = std::fmax(material.modulus, std::fabs(a));
  }
}

/// Keeps of the pressure modes only the rows of cells that have a pressure.
void compact_pressure_rows(phn_body& body, float* pressures, std::int32_t* pressure_row) {
  const auto stride = static_cast<std::size_t>(body.pressure_modes.stride);
  std::int32_t n = 0;
  for (std::int32_t c = 0; c < body.info.n_cells; ++c) {
    pressure_row[c] = body.pressure_weights[c] > 0 ? n++ : -1;
    if (pressure_row[c] >= 0)
      memmove(pressures + static_cast<std::size_t>(pressure_row[c]) * stride,
              pressures + static_cast<std::size_t>(c) * stride, stride * sizeof(float));
  }
  body.pressure_modes.n_rows = n;
  body.pressure_row = pressure_row;
}

}  // namespace

int load_body(const char* text, std::size_t length, Arena& arena, const phn_body** result, std::size_t& wrong_byte) {
  *result = nullptr;
  const int envelope = schema::check_envelope(schema::body_first_line, text, length, wrong_byte);
  if (envelope != PHN_OK) return envelope;
  TextReader in(text, length);
  in.rest_of_line();
  in.end_line();
  auto* body = arena.take<phn_body>(1);
  BodyStore store;
  BodyLoader loader(in, arena);
  schema::body(loader, store);
  if (!in.at_end()) in.fail_next(PHN_ERROR_SYNTAX);
  auto* neighbors = arena.take<std::int32_t>(static_cast<std::size_t>(store.surface.n), 3);
  auto* previous_corner = arena.take<std::int32_t>(static_cast<std::size_t>(store.surface.n), 3);
  auto* last_corner = arena.take<std::int32_t>(static_cast<std::size_t>(store.nodes.n));
  auto* pressure_row = arena.take<std::int32_t>(static_cast<std::size_t>(store.shear_m3.n));
  auto* normals = arena.take<double>(static_cast<std::size_t>(store.nodes.n), 3);
  auto* materials = arena.take<BodyMaterial>(static_cast<std::size_t>(store.regions.n) + 1);
  wrong_byte = in.wrong_byte();
  if (!in.good()) return in.status();
  if (loader.law == nullptr || loader.law->n_parameters != store.parameters.n) return PHN_ERROR_FAMILY;
  if (arena.overflow()) return PHN_ERROR_BUFFER;
  if (arena.counting()) return PHN_OK;
  *body = {};
  phn_body_contents& info = body->info;
  info.mesh_hash = store.mesh_hash;
  info.physics_hash = store.physics_hash;
  info.law = store.law;
  info.relaxation = store.made;
  info.tool_radius_m = store.tool_radius_m;
  info.max_displacement_m = store.depth_m;
  info.nodes = store.nodes.data;
  info.points = store.points.data;
  info.triangles = store.surface.data;
  info.n_nodes = static_cast<std::int32_t>(store.nodes.n);
  info.n_triangles = static_cast<std::int32_t>(store.surface.n);
  info.n_modes = static_cast<std::int32_t>(store.modes.entries.n_cols);
  info.n_pressures = static_cast<std::int32_t>(store.pressures.entries.n_cols);
  info.n_cells = static_cast<std::int32_t>(store.shear_m3.n);
  body->law = loader.law;
  set_materials(store, *body->law, materials);
  body->materials = materials;
  body->n_materials = static_cast<std::int32_t>(store.regions.n) + 1;
  body->material_of_cell = store.regions.n > 0 ? store.region_of_cell.data : nullptr;
  body->stride = store.modes.entries.stride;
  body->node_kinds = store.kinds.data;
  body->modes = store.modes.entries.matrix();
  body->cell_weights = store.shear_m3.data;
  body->pressure_weights = store.bulk_rJ.data;
  body->mode_gradients = store.gradients.entries.matrix();
  body->pressure_modes = store.pressures.entries.matrix();
  compact_pressure_rows(*body, store.pressures.entries.data, pressure_row);
  body->cells_at_rest = store.cells_at_rest.entries.matrix();
  body->lack_at_rest = store.lack_at_rest.entries.matrix();
  body->residual_compliance = store.lacking.entries.matrix();
  body->bounds = store.bounds.n > 0 ? store.bounds.data : nullptr;
  schema::find_neighbors(info.triangles, info.n_triangles, info.n_nodes, last_corner, previous_corner, neighbors);
  set_normals(*body, normals);
  body->neighbors = neighbors;
  body->normals = normals;
  *result = body;
  return PHN_OK;
}

}  // namespace PHN_RUNTIME
