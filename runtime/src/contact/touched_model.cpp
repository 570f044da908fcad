// Contact with a model: of nodes, or of a round tool.
#include "contact/contact.hpp"
#include "core/evaluate.hpp"
#include "tools/coupled.hpp"
#include "tools/triangle.hpp"

using namespace PHN_RUNTIME;

namespace {

class TouchedModel final : public Touched {
 public:
  TouchedModel(const phn_model& model, phn_data& data) : _model(model), _data(data) {
    has_energy = model.has_energy;
    max_displacement_m = model.max_displacement_m;
  }
  int hold(std::int32_t n, std::int32_t, const phn_tool* tools, const double*, double* forces,
           phn_coupled& result) override {
    return phn_couple(&_model, &_data, n, tools, forces, &result);
  }
  Matrix stiffness(std::int32_t i) const override {
    const Coupling& coupling = *_data.coupling;
    if (coupling.n_tools > 1) return coupling.stiffness(i, i);
    const Constraint& point = coupling.point[i];
    if (!needs_no_coupling(_model, point)) return point.stiffness;
    // phn_couple computes no coupling stiffness for a tool that it answers alone.
    const Mean mean = mean_at(_model, {}, point);
    Matrix sum = {};
    for (std::int32_t n = 0; n < mean.n; ++n) {
      const Matrix stiffness = stiffness_at_rest(_model, _model.active[mean.active[n]]);
      for (int k = 0; k < 9; ++k) sum.a[k] += mean.weight[n] * stiffness.a[k] / (mean.transmission * mean.transmission);
    }
    return sum;
  }

 private:
  const phn_model& _model;
  phn_data& _data;
};

WholeSurface surface_of(const phn_model& model) {
  return {model.n_output + model.n_fixed, model.n_output, model.n_triangles, model.triangles};
}

/// See ContactSurface::active.
std::int32_t active_of(const phn_model& model, std::int32_t vertex) {
  Corner corner[3];
  const std::int32_t n = find_corners(model, vertex_node(model, vertex), corner);
  bool moves = n > 0;
  for (std::int32_t i = 0; i < n; ++i) {
    const ActiveNode& node = model.active[corner[i].active];
    moves = moves && node.output >= 0 && has_deformation(model, node);
  }
  if (moves) return n == 1 ? corner[0].active : several;
  return n > 0 || vertex < model.n_output ? -2 : -1;
}

int lay_out(Arena& arena, const phn_model& model, std::int32_t max_tools, ContactParts& parts) {
  const int refused = lay_out_contact(arena, surface_of(model), max_tools, parts);
  if (refused != PHN_OK) return refused;
  parts.made.data = make_data(arena, model, max_tools);
  return arena.overflow() ? PHN_ERROR_BUFFER : PHN_OK;
}

}  // namespace

int PHN_RUNTIME::step_on_model(phn_contact& contact, std::int32_t n_tools, const phn_contact_tool* tools,
                               const phn_contact_state* states, const phn_contact_report* report,
                               phn_contact_report& made) {
  if (n_tools > 1 && has_round_tools(*contact.data->coupling)) return PHN_ERROR_ROUND_TOOLS;
  TouchedModel touched(*contact.data->model, *contact.data);
  phn_coupled coupled = {0, 0};
  const int status = step_contact(contact, touched, n_tools, tools, states, report, coupled);
  made.energy = coupled.energy;
  made.residual_m = coupled.residual;
  return status;
}

extern "C" {

int phn_contact_size(const phn_model* model, int32_t max_tools, size_t* bytes) {
  return size_of_contact(lay_out, model, max_tools, bytes);
}

int phn_contact_init(void* memory, size_t bytes, const phn_model* model, int32_t max_tools, phn_contact** contact) {
  if (contact == nullptr) return PHN_ERROR_ARGUMENT;
  *contact = nullptr;
  if (memory == nullptr || model == nullptr) return PHN_ERROR_ARGUMENT;
  if (overlap(memory, bytes, model, model->bytes) || overlap(memory, bytes, contact, sizeof *contact))
    return PHN_ERROR_OVERLAP;
  const WholeSurface whole = surface_of(*model);
  Arena arena(memory, bytes);
  ContactParts parts;
  const int status = lay_out(arena, *model, max_tools, parts);
  if (status != PHN_OK) return status;
  const ContactSurface& surface = parts.made.surface;
  for (std::int32_t v = 0; v < whole.n_vertices; ++v) {
    for (int k = 0; k < 3; ++k) row(surface.rest, v)[k] = vertex_point(*model, v)[k];
    surface.node[v] = vertex_node(*model, v);
    surface.active[v] = active_of(*model, v);
  }
  return build_contact(whole, parts, contact);
}

}  // extern "C"
