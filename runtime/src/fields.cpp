// Scalar fields beside the deformation: loading and evaluation (formats/model.md, "Fields").
#include <cmath>

#include "load_parts.hpp"
#include "modal.hpp"
#include "modal_kernels.hpp"

namespace PHN_RUNTIME {
namespace {

/// Products of two components of x, beside its three components.
constexpr std::int32_t n_even = 6;

/// e_jk = x_j x_k |x|^(degree - 2), zero at x = 0.
void even_basis(const double* x, std::int32_t degree, double* e) {
  const double size = std::sqrt(dot(x, x));
  const double by = degree == 2 ? 1 : size > 0 ? 1 / size : 0;
  for (int j = 0; j < 3; ++j) {
    for (int k = j; k < 3; ++k) *e++ = x[j] * x[k] * by;
  }
}

void field_lines(TextReader& in, Arena& arena, std::int32_t n_output, SharedField& field) {
  in.keyword("field");
  field.name = place_word(arena, in.word());
  field.unit = place_word(arena, in.word());
  in.end_line();
  in.keyword("degree");
  field.degree = in.integer(1, 2);
  in.end_line();
  real_line(in, "scale", &field.scale, 1, true);
  if (!(field.scale <= largest_linear)) in.fail(PHN_ERROR_RANGE);
  load_shared_table(in, arena, n_output, 1, field);
}

}  // namespace

void load_fields(TextReader& in, Arena& arena, phn_model& model) {
  TextReader attempt = in;
  attempt.keyword("fields");
  if (!in.good() || !attempt.good()) return;
  in.keyword("fields");
  const std::int32_t n = in.integer(1, largest_field_count);
  in.end_line();
  for (std::int32_t f = 0; f < n && in.good(); ++f) field_lines(in, arena, model.n_output, model.fields[f]);
  model.n_fields = in.good() ? n : 0;
}

void load_node_fields(TextReader& in, Arena& arena, phn_model& model, LoadedModal& node) {
  Column<ModalTables> all(arena, static_cast<std::size_t>(model.n_fields));
  for (std::int32_t f = 0; f < model.n_fields && in.good(); ++f) {
    ModalTables tables = {};
    load_tables(in, arena, "field", static_cast<std::size_t>(model.shared.n_centers) + 3 + n_even,
                model.fields[f], model.n_output, tables);
    const auto needed = static_cast<std::size_t>(model.shared.n_centers + 3 + n_even + tables.n_modes +
                                                 model.fields[f].n_modes);
    model.n_field_scratch = model.n_field_scratch > needed ? model.n_field_scratch : needed;
    all.set(static_cast<std::size_t>(f), node.of_field[f] = tables);
  }
  node.fields = all.get();
}

const ModalTables* load_level_fields(TextReader& in, Arena& arena, const phn_model& level, const LoadedModal& full) {
  Column<ModalTables> all(arena, static_cast<std::size_t>(level.n_fields));
  for (std::int32_t f = 0; f < level.n_fields && in.good(); ++f) {
    ModalTables tables = full.of_field[f];
    load_level_weights(in, arena, "field", static_cast<std::size_t>(level.shared.n_centers) + 3 + n_even, tables);
    all.set(static_cast<std::size_t>(f), tables);
  }
  return all.get();
}

void modal_field(const phn_model& model, const ModalResponse& node, std::int32_t field, const double* d,
                 double* scratch, double* out) {
  const SharedField& shared = model.fields[field];
  const ModalTables& tables = node.fields[field];
  const std::int32_t n_centers = model.shared.n_centers, n_basis = n_centers + 3 + n_even;
  double x[3], *basis = scratch, *amplitude = basis + n_basis;
  cut(d, model.max_displacement, largest_modal, x);
  const ModalKernels& kernels = best_modal_kernels();
  kernels.basis(model.shared, x, basis);
  even_basis(x, shared.degree, basis + n_centers + 3);
  kernels.amplitudes(tables, n_basis, basis, amplitude);
  kernels.field(shared, tables, nullptr, amplitude, amplitude + tables.n_modes, out);
  for (std::int32_t o = 0; o < model.n_output; ++o) out[o] = std::fmax(0.0, shared.scale * out[o]);
}

}  // namespace PHN_RUNTIME
