// The C interface of phynness.h without tools, which are in tools/one_tool.cpp. The model is read in load.cpp.
#include <phynness/phynness.h>

#include <cmath>

#include "core/families.hpp"
#include "core/text_lines.hpp"

using namespace PHN_RUNTIME;

namespace {

/// In the order of their numbers, up to 5: _UNSETTLED with another warning.
const char* const messages[] = {
    "the image holds doubles, but this code is for images of floats: phynness export --float",
    "the image holds floats, but this code is for images of doubles: phynness export without --float",
    "more than 8 tools in one call, or fewer than 9 modes of the body for each of them",
    "the surface has a triangle with equal corners, or coordinates that are too large for contact",
    "the result has more bytes or numbers than this machine can address",
    "an output overlaps another output or a large input in memory",
    "the model's family is unknown to this version",
    "a count, index or value of the model is out of range",
    "a word or number of the model is malformed",
    "the model is damaged: its checksum is wrong",
    "the model is incomplete at its end",
    // NOLINTNEXTLINE(bugprone-suspicious-missing-comma): two lines of one text
    "the model, or a struct whose reserved words are not 0, has another version; train, reduce or export it again with "
    "this version, or compile the program with its headers",
    "this is not a phynness model (or body, where one is read)",
    "the time of a step is not later than that of the step before",
    "the model's family or the node has no such response, such as an energy, a deformation or a bound",
    // NOLINTNEXTLINE(bugprone-suspicious-missing-comma): two lines of one text
    "a model of round tools answers one tool; several need the reduced body that phynness run makes of a scene with "
    "tools = 2 to 8 in [probe], of the elements p1-p1 and es-p1-p1",
    "more tools than the phn_data or phn_contact was made for, or than the max_tools of an Organ",
    "the memory is smaller than the size function returned",
    "a displacement, position or size is NaN or infinite",
    "the node, or all that the tool touches, cannot be touched in this model",
    "a null pointer, a number out of range, or data made for another model",
    "success",
    "the tool is deeper than trained in its direction, or at a place that was not trained or beside fixed nodes",
    "this node was not trained to the full depth in all directions",
    "the tool is deeper than trained in its direction or at a place that was not trained, and a node was not trained "
    "to the full depth in all directions",
    "tools are not followed: they are too close together, or moved faster than the body settles",
    "tools are not followed, and a displacement is outside of the trained range or a node was not "
    "trained to the full depth in all directions",
};
constexpr int first_message = PHN_ERROR_IMAGE_OF_DOUBLES, last_message = PHN_WARNING_UNSETTLED + 1;
constexpr int all_warnings =
    PHN_WARNING_RELAXATION | PHN_WARNING_NEAR | PHN_WARNING_UNSETTLED | PHN_WARNING_OUTSIDE | PHN_WARNING_INCOMPLETE;
static_assert(sizeof messages / sizeof *messages == last_message - first_message + 1);

const phn_model& level_of(const phn_model& model, std::int32_t level) {
  return level + 1 < model.n_levels ? model.smaller[level] : model;
}

/// The largest value of f over the active nodes.
template <class Count>
std::int32_t most(const phn_model& model, Count f) {
  std::int32_t largest = 0;
  for (std::int32_t i = 0; i < model.n_active; ++i) {
    const std::int32_t n = f(model.active[i]);
    largest = n > largest ? n : largest;
  }
  return largest;
}

std::int32_t force_centers(const ActiveNode& node) {
  return node.networks ? node.networks->force.n_neurons : node.modal ? node.modal->force.n_centers : 0;
}
std::int32_t neurons(const ActiveNode& node) { return node.networks ? node.networks->deformation.n_neurons : 0; }
std::int32_t modes(const ActiveNode& node) { return node.modal ? node.modal->n_modes : 0; }

}  // namespace

extern "C" {

const char* phn_version(void) { return PHYNNESS_VERSION; }

const char* phn_status_message(int status) {
  if (status <= PHN_ERROR_SETTING) return "a setting of the loop is out of its range (phn_loop_trip_message)";
  if (status < first_message || status > all_warnings) return "unknown status";
  if (status == PHN_WARNING_NEAR)
    return "the tools are nearer to each other than half a radius: springs join them, and their forces may be off "
           "by a third and more";
  if (status == PHN_WARNING_RELAXATION)
    return "the relaxing force is approximate: the place moves, or the tool has left the body";
  if (status > PHN_WARNING_RELAXATION)
    return "the relaxing force is approximate: the place moves, or the tool has left; and the elastic force has a "
           "warning";
  if (status > PHN_WARNING_NEAR)
    return "the tools are nearer to each other than half a radius, outside of the trained range, or not yet settled";
  return messages[(status < last_message ? status : last_message) - first_message];
}

int phn_model_size(const char* text, size_t length, size_t* bytes, size_t* wrong_byte) {
  return size_of_text<phn_model>(load_model, text, length, bytes, wrong_byte);
}

int phn_model_init(void* memory, size_t bytes, const char* text, size_t length, const phn_model** model,
                   size_t* wrong_byte) {
  return init_of_text<phn_model>(load_model, memory, bytes, text, length, model, wrong_byte);
}

int phn_model_info(const phn_model* model, phn_info* info) {
  if (info == nullptr) return PHN_ERROR_ARGUMENT;
  *info = {};
  if (model == nullptr) return PHN_ERROR_ARGUMENT;
  *info = *model;
  return PHN_OK;
}

int phn_data_size(const phn_model* model, int32_t max_tools, size_t* bytes) {
  if (bytes == nullptr) return PHN_ERROR_ARGUMENT;
  *bytes = 0;
  if (model == nullptr || max_tools < 1) return PHN_ERROR_ARGUMENT;
  Arena arena;
  make_data(arena, *model, max_tools);
  if (arena.overflow()) return PHN_ERROR_TOO_LARGE;
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
  phn_data* made = make_data(arena, *model, max_tools);
  if (arena.overflow()) return PHN_ERROR_BUFFER;
  *data = made;
  return PHN_OK;
}

int phn_level_info(const phn_model* model, int32_t level, phn_level* info) {
  if (info == nullptr) return PHN_ERROR_ARGUMENT;
  *info = {};
  if (model == nullptr || level < 0 || level >= model->n_levels) return PHN_ERROR_ARGUMENT;
  const phn_model& of_level = level_of(*model, level);
  info->force_centers = most(of_level, force_centers);
  info->deformation_centers =
      phynness::schema::traits(model->kind).has_modes ? of_level.shared.n_centers : most(of_level, neurons);
  info->modes = most(of_level, modes);
  info->error_force = of_level.errors.force;
  info->error_displacement = of_level.errors.displacement;
  return PHN_OK;
}

int phn_set_level(const phn_model* model, phn_data* data, int32_t level) {
  if (model == nullptr || data == nullptr || data->model != model || level < 0 || level >= model->n_levels)
    return PHN_ERROR_ARGUMENT;
  data->level = &level_of(*model, level);
  return PHN_OK;
}

}  // extern "C"
