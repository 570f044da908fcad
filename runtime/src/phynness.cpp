// The C interface: argument checks and statuses; the work is in load.cpp and evaluate.cpp. Tools anywhere: touch.cpp.
#include <phynness/phynness.h>

#include <cmath>

#include "arena.hpp"
#include "arguments.hpp"
#include "evaluate.hpp"
#include "modal.hpp"
#include "model.hpp"

using phynness::runtime::ActiveNode;
using phynness::runtime::Arena;
using phynness::runtime::finite;
using phynness::runtime::overlap;
using phynness::runtime::refuse;
using phynness::runtime::warnings;

namespace {

/// A node at the level of the data, and a copy of its displacement: an output may be the memory of that.
struct Asked {
  const ActiveNode* node;
  double d[3];
};

/// Checks the arguments of a response of one node.
int find_node(const phn_model* model, const phn_data* data, std::int32_t node, const double* d,
              const double* out, Asked& asked) {
  if (model == nullptr || data == nullptr || data->model != model || d == nullptr || out == nullptr) {
    return PHN_ERROR_ARGUMENT;
  }
  const std::int32_t at = phynness::runtime::find_active(*model, node);
  if (at < 0) return PHN_ERROR_NOT_ACTIVE;
  if (!finite(d)) return PHN_ERROR_NOT_FINITE;
  asked = {&data->level->active[at], {d[0], d[1], d[2]}};
  return PHN_OK;
}

struct DataParts {
  phn_data* data;
  phn_data value;
};

DataParts lay_out(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  DataParts parts = {};
  const auto n_output = static_cast<std::size_t>(model.n_output);
  parts.data = arena.take<phn_data>(1);
  parts.value.model = parts.value.level = &model;
  parts.value.max_tools = max_tools;
  parts.value.scratch = arena.take<double>(model.n_scratch);
  parts.value.field = arena.take<double>(3 * n_output);
  parts.value.nearest = arena.take<double>(n_output);
  parts.value.weight_sum = arena.take<double>(n_output);
  parts.value.asked_nodes = arena.take<std::int32_t>(static_cast<std::size_t>(max_tools));
  parts.value.asked = arena.take<double>(static_cast<std::size_t>(max_tools), 3);
  parts.value.coupling = phynness::runtime::lay_out_coupling(arena, model, max_tools);
  parts.value.prepared = phynness::runtime::lay_out_prepared(arena, model, max_tools);
  return parts;
}

/// Copies the tools of a deformation into the data and checks them. @return a status of phynness.h
int read_tools(const phn_model& model, phn_data& data, std::int32_t n_tools, const std::int32_t* nodes,
               const double* displacements) {
  if (nodes == nullptr || displacements == nullptr) return PHN_ERROR_ARGUMENT;
  if (n_tools > data.max_tools) return PHN_ERROR_TOOLS;
  int status = PHN_OK;
  for (std::int32_t t = 0; t < n_tools; ++t) {
    double* d = data.asked + 3 * static_cast<std::size_t>(t);
    data.asked_nodes[t] = nodes[t];
    for (int k = 0; k < 3; ++k) d[k] = displacements[3 * static_cast<std::size_t>(t) + k];
    const std::int32_t at = phynness::runtime::find_active(model, data.asked_nodes[t]);
    if (at < 0) return PHN_ERROR_NOT_ACTIVE;
    if (!finite(d)) return PHN_ERROR_NOT_FINITE;
    for (std::int32_t s = 0; s < t; ++s) {
      if (data.asked_nodes[s] == data.asked_nodes[t]) return PHN_ERROR_SAME_NODE;
    }
    if (!phynness::runtime::has_deformation(model, model.active[at])) return PHN_ERROR_UNDEFINED;
    status |= warnings(model, model.active[at], d);
  }
  return status;
}

}  // namespace

extern "C" {

const char* phn_version(void) { return PHYNNESS_VERSION; }
int32_t phn_precision(void) { return 8 * static_cast<int32_t>(sizeof(phynness::runtime::Real)); }

const char* phn_status_message(int status) {
  switch (status) {
    case PHN_OK:
      return "good";
    case PHN_WARNING_UNSETTLED:
      return "coupled tools are too near each other: not all of them are followed";
    case PHN_WARNING_UNSETTLED | PHN_WARNING_OUTSIDE:
    case PHN_WARNING_UNSETTLED | PHN_WARNING_INCOMPLETE:
    case PHN_WARNING_UNSETTLED | PHN_WARNING_OUTSIDE | PHN_WARNING_INCOMPLETE:
      return "coupled tools are too near each other, at displacements beyond or beside what was trained";
    case PHN_WARNING_OUTSIDE:
      return "displacement is beyond the depth trained in its direction";
    case PHN_WARNING_INCOMPLETE:
      return "in training some directions of this node stopped short of the full depth";
    case PHN_WARNING_OUTSIDE | PHN_WARNING_INCOMPLETE:
      return "displacement is beyond the trained depth, and some directions of this node stopped short in "
             "training";
    case PHN_ERROR_ARGUMENT:
      return "null pointer, number out of range, or data made for another model";
    case PHN_ERROR_NOT_ACTIVE:
      return "the node is not an active node of this model";
    case PHN_ERROR_NOT_FINITE:
      return "a displacement, place or size is NaN or infinite";
    case PHN_ERROR_BUFFER:
      return "memory is smaller than the size function asked for";
    case PHN_ERROR_TOOLS:
      return "more tools than the data was made for";
    case PHN_ERROR_SAME_NODE:
      return "two tools at the same node";
    case PHN_ERROR_UNDEFINED:
      return "this model does not define what was asked for: its family or node has no such response";
    case PHN_ERROR_BUDGET:
      return "not even the smallest level fits into the time";
    case PHN_ERROR_CLOCK:
      return "the clock gives NaN, runs backwards or stands still";
    case PHN_ERROR_NOT_A_MODEL:
      return "the text is not a phynness model";
    case PHN_ERROR_VERSION:
      return "the model text has another version";
    case PHN_ERROR_TRUNCATED:
      return "the model text ends early";
    case PHN_ERROR_CHECKSUM:
      return "the model text is damaged: its checksum differs";
    case PHN_ERROR_SYNTAX:
      return "a word or number of the model text is malformed";
    case PHN_ERROR_RANGE:
      return "a count, index or value of the model text is out of range";
    case PHN_ERROR_FAMILY:
      return "the model text holds a family that this version does not know";
    case PHN_ERROR_OVERLAP:
      return "an output lies in the memory of another output, or of an input too large to be copied first";
    default:
      return "unknown status";
  }
}

int phn_model_size(const char* text, size_t length, size_t* bytes) {
  if (bytes == nullptr) return PHN_ERROR_ARGUMENT;
  Arena arena;
  const phn_model* none = nullptr;
  int status =
      text == nullptr ? PHN_ERROR_ARGUMENT : phynness::runtime::load_model(text, length, arena, &none);
  if (arena.overflow()) status = PHN_ERROR_RANGE;
  *bytes = status == PHN_OK ? arena.needed() : 0;
  return status;
}

int phn_model_init(void* memory, size_t bytes, const char* text, size_t length, const phn_model** model) {
  if (model == nullptr) return PHN_ERROR_ARGUMENT;
  const phn_model* loaded = nullptr;
  int status = PHN_ERROR_ARGUMENT;
  if (overlap(memory, bytes, text, length) || overlap(memory, bytes, model, sizeof *model)) {
    status = PHN_ERROR_OVERLAP;
  } else if (memory != nullptr && text != nullptr) {
    Arena arena(memory, bytes);
    status = phynness::runtime::load_model(text, length, arena, &loaded);
  }
  *model = loaded;
  return status;
}

int phn_data_size(const phn_model* model, int32_t max_tools, size_t* bytes) {
  if (bytes == nullptr) return PHN_ERROR_ARGUMENT;
  *bytes = 0;
  if (model == nullptr || max_tools < 1) return PHN_ERROR_ARGUMENT;
  Arena arena;
  lay_out(arena, *model, max_tools);
  if (arena.overflow()) return PHN_ERROR_RANGE;
  *bytes = arena.needed();
  return PHN_OK;
}

int phn_data_init(void* memory, size_t bytes, const phn_model* model, int32_t max_tools, phn_data** data) {
  if (data == nullptr) return PHN_ERROR_ARGUMENT;
  *data = nullptr;
  if (memory == nullptr || model == nullptr || max_tools < 1) return PHN_ERROR_ARGUMENT;
  if (overlap(memory, bytes, model, model->bytes) || overlap(memory, bytes, data, sizeof *data))
    return PHN_ERROR_OVERLAP;
  Arena arena(memory, bytes);
  const DataParts parts = lay_out(arena, *model, max_tools);
  if (arena.overflow()) return PHN_ERROR_BUFFER;
  *parts.data = parts.value;
  *data = parts.data;
  return PHN_OK;
}

int32_t phn_n_nodes(const phn_model* model) { return model ? model->n_nodes : 0; }
int32_t phn_n_active(const phn_model* model) { return model ? model->n_active : 0; }
int32_t phn_n_output(const phn_model* model) { return model ? model->n_output : 0; }
const int32_t* phn_active_nodes(const phn_model* model) { return model ? model->active_nodes : nullptr; }
const int32_t* phn_output_nodes(const phn_model* model) { return model ? model->output_nodes : nullptr; }
const double* phn_output_points(const phn_model* model) { return model ? model->output_points : nullptr; }
int32_t phn_n_triangles(const phn_model* model) { return model ? model->n_triangles : 0; }
const int32_t* phn_triangles(const phn_model* model) { return model ? model->triangles : nullptr; }
int32_t phn_n_fixed(const phn_model* model) { return model ? model->n_fixed : 0; }
const int32_t* phn_fixed_nodes(const phn_model* model) { return model ? model->fixed_nodes : nullptr; }
const double* phn_fixed_points(const phn_model* model) { return model ? model->fixed_points : nullptr; }

int phn_force(const phn_model* model, phn_data* data, int32_t node, const double d[3], double force[3]) {
  Asked asked;
  const int refused = find_node(model, data, node, d, force, asked);
  if (refused != PHN_OK) return refuse(refused, force, 3);
  phynness::runtime::evaluate_force(*data->level, *asked.node, asked.d, force);
  return warnings(*model, *asked.node, asked.d);
}

int phn_energy(const phn_model* model, phn_data* data, int32_t node, const double d[3], double* energy) {
  Asked asked;
  const int refused = find_node(model, data, node, d, energy, asked);
  if (refused != PHN_OK) return refuse(refused, energy, 1);
  if (!phynness::runtime::has_energy(*model)) return refuse(PHN_ERROR_UNDEFINED, energy, 1);
  *energy = phynness::runtime::evaluate_energy(*data->level, *asked.node, asked.d);
  return warnings(*model, *asked.node, asked.d);
}

int phn_stiffness(const phn_model* model, phn_data* data, int32_t node, const double d[3],
                  double stiffness[9]) {
  Asked asked;
  const int refused = find_node(model, data, node, d, stiffness, asked);
  if (refused != PHN_OK) return refuse(refused, stiffness, 9);
  if (!phynness::runtime::has_energy(*model)) return refuse(PHN_ERROR_UNDEFINED, stiffness, 9);
  phynness::runtime::evaluate_stiffness(*data->level, *asked.node, asked.d, stiffness);
  return warnings(*model, *asked.node, asked.d);
}

int phn_deform(const phn_model* model, phn_data* data, int32_t n_tools, const int32_t* nodes,
               const double* displacements, double* out) {
  if (model == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  int status = PHN_OK;
  if (data == nullptr || data->model != model || n_tools < 0) {
    status = PHN_ERROR_ARGUMENT;
  } else if (n_tools > 0) {
    status = read_tools(*model, *data, n_tools, nodes, displacements);
  }
  if (status < 0 || n_tools == 0) return refuse(status, out, 3 * model->n_output);
  if (n_tools == 1) {
    const int32_t at = phynness::runtime::find_active(*model, data->asked_nodes[0]);
    phynness::runtime::evaluate_deformation(*data->level, *data, at, data->asked, out);
  } else {
    phynness::runtime::blend_tools(*data->level, *data, n_tools, data->asked_nodes, data->asked, out);
  }
  return status;
}

int phn_prepare(const phn_model* model, phn_data* data, int32_t node) {
  if (model == nullptr || data == nullptr || data->model != model) return PHN_ERROR_ARGUMENT;
  const int32_t at = phynness::runtime::find_active(*model, node);
  if (at < 0) return PHN_ERROR_NOT_ACTIVE;
  phynness::runtime::prepare(*model, data->prepared, at);
  return PHN_OK;
}

int32_t phn_n_fields(const phn_model* model) { return model ? model->n_fields : 0; }
const char* phn_field_name(const phn_model* model, int32_t field) {
  return model && field >= 0 && field < model->n_fields ? model->fields[field].name : nullptr;
}
const char* phn_field_unit(const phn_model* model, int32_t field) {
  return model && field >= 0 && field < model->n_fields ? model->fields[field].unit : nullptr;
}

int phn_field(const phn_model* model, phn_data* data, int32_t node, const double d[3], int32_t field,
              double* out) {
  if (model == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  if (field < 0 || field >= model->n_fields) return refuse(PHN_ERROR_ARGUMENT, out, model->n_output);
  Asked asked;
  int refused = find_node(model, data, node, d, out, asked);
  if (refused == PHN_OK && asked.node->modal->fields[field].n_modes == 0) refused = PHN_ERROR_UNDEFINED;
  if (refused != PHN_OK) return refuse(refused, out, model->n_output);
  phynness::runtime::modal_field(*data->level, *asked.node->modal, field, asked.d, data->scratch, out);
  return warnings(*model, *asked.node, asked.d);
}

int phn_trained_depth(const phn_model* model, int32_t node, const double d[3], double* depth) {
  if (model == nullptr || d == nullptr || depth == nullptr) return refuse(PHN_ERROR_ARGUMENT, depth, 1);
  const int32_t at = phynness::runtime::find_active(*model, node);
  if (at < 0) return refuse(PHN_ERROR_NOT_ACTIVE, depth, 1);
  if (!finite(d)) return refuse(PHN_ERROR_NOT_FINITE, depth, 1);
  const int status = warnings(*model, model->active[at], d) & PHN_WARNING_OUTSIDE;
  *depth = phynness::runtime::trained_depth(*model, model->active[at], d);
  return status;
}

}  // extern "C"
