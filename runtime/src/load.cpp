// model.txt -> phn_model. Follows formats/model.md section by section.
#include <initializer_list>

#include "evaluate.hpp"
#include "load_parts.hpp"
#include "trained.hpp"

namespace PHN_RUNTIME {
namespace {

// Sums of outputs stay this far from the largest double, so that no addition of a few of them overflows.
constexpr double largest_output = 1e300;

struct Tables {
  std::int32_t n_displacements = 0;
  const double *displacements = nullptr, *output_points = nullptr;
};

std::int32_t ascending_node(TextReader& in, std::int32_t n_nodes, std::int32_t& previous) {
  const std::int32_t node = in.integer(0, n_nodes - 1);
  if (node <= previous) in.fail(PHN_ERROR_RANGE);
  return previous = node;
}

/// Table of n rows of 3 numbers over a divisor, read to an array.
const double* vector_table(TextReader& in, Arena& arena, std::int32_t n, double divisor) {
  Column<double> rows(arena, 3 * n);
  for (std::int32_t i = 0; i < n && in.good(); ++i) {
    for (int k = 0; k < 3; ++k) rows.set(3 * i + k, in.real() / divisor);
    in.end_line();
  }
  return rows.get();
}

/// The displacement, and of 6 inputs the output node, where neuron i is centered. @param center  to be set, or null
void read_center(TextReader& in, const Network& net, const Tables& tables, std::int32_t n_output, std::int32_t i,
                 Real* const* center) {
  const std::int32_t displacement = in.integer(0, tables.n_displacements - 1);
  const std::int32_t output = net.n_inputs == 6 ? in.integer(0, n_output - 1) : 0;
  for (int k = 0; k < net.n_inputs && center != nullptr && in.good(); ++k) {
    const double value = k < 3 ? tables.displacements[3 * displacement + k] : tables.output_points[3 * output + k - 3];
    const double scaled = (value - net.input_center[k]) / net.input_half_range[k];
    if (!(std::fabs(scaled) <= largest_input)) in.fail(PHN_ERROR_RANGE);
    center[k][i] = static_cast<Real>(scaled);
  }
}

/// The lines of a network's neurons. @param tables  null: lines hold weights alone. @param center  see read_center
void read_neurons(TextReader& in, Arena& arena, Network& net, const Tables* tables, std::int32_t n_output,
                  Real* const* center) {
  Real* weight[3];
  double largest[3];
  const std::int32_t n_whole = whole_blocks(net.n_neurons);
  for (int k = 0; k < 3; ++k) {
    net.weight[k] = weight[k] = arena.take<Real>(static_cast<std::size_t>(n_whole));
    largest[k] = std::fabs(net.bias[k]);
  }
  const bool fill = has_memory(arena);
  for (int k = 0; k < 3; ++k) {
    for (std::int32_t i = net.n_neurons; fill && i < n_whole; ++i) weight[k][i] = 0;
  }
  for (std::int32_t i = 0; i < net.n_neurons && in.good(); ++i) {
    if (tables != nullptr) read_center(in, net, *tables, n_output, i, center);
    for (int k = 0; k < 3; ++k) {
      const double value = in.real();
      largest[k] += std::fabs(value);
      if (!(std::fabs(value) <= largest_weight)) in.fail(PHN_ERROR_RANGE);
      if (fill) weight[k][i] = static_cast<Real>(value);
    }
    in.end_line();
  }
  for (int k = 0; k < 3; ++k) {
    const double bound = std::fabs(net.output_center[k]) + net.output_half_range[k] * largest[k];
    if (in.good() && !(bound < largest_output)) in.fail(PHN_ERROR_RANGE);
    // Forces are scaled in double after they were summed, displacements before.
    if (in.good() && net.n_inputs == 6 && !(bound <= largest_displacement_sum)) in.fail(PHN_ERROR_RANGE);
  }
}

void network(TextReader& in, Arena& arena, const char* keyword, int n_inputs, const Tables& tables,
             std::int32_t n_output, Network& net) {
  net.n_neurons = net.n_prepared = count_line(in, keyword, 0);
  net.n_inputs = n_inputs;
  real_line(in, "input_center", net.input_center, n_inputs, false);
  real_line(in, "input_half_range", net.input_half_range, n_inputs, true);
  for (int k = 0; k < n_inputs; ++k) net.inverse_half_range[k] = std::fmin(1 / net.input_half_range[k], DBL_MAX);
  real_line(in, "output_center", net.output_center, 3, false);
  real_line(in, "output_half_range", net.output_half_range, 3, true);
  const double spread = width_line(in, "spread");
  net.inverse_square_spread = 1 / (spread * spread);
  real_line(in, "bias", net.bias, 3, false);

  Real* center[6];
  const std::int32_t n_whole = whole_blocks(net.n_neurons);
  for (int k = 0; k < n_inputs; ++k) net.center[k] = center[k] = arena.take<Real>(static_cast<std::size_t>(n_whole));
  const bool fill = has_memory(arena);
  for (int k = 0; k < n_inputs; ++k) {
    for (std::int32_t i = net.n_neurons; fill && i < n_whole; ++i) center[k][i] = 0;
  }
  read_neurons(in, arena, net, &tables, n_output, fill ? center : nullptr);
}

/// What the first neurons of a network do alone.
void network_level(TextReader& in, Arena& arena, const char* keyword, Network& net) {
  const std::int32_t n_full = net.n_neurons;
  net.n_neurons = count_line(in, keyword, 0);
  if (net.n_neurons > n_full) in.fail(PHN_ERROR_RANGE);
  real_line(in, "bias", net.bias, 3, false);
  read_neurons(in, arena, net, nullptr, 0, nullptr);
}

Networks networks_level(TextReader& in, Arena& arena, const Networks& full) {
  Networks nets = full;
  network_level(in, arena, "force", nets.force);
  network_level(in, arena, "deformation", nets.deformation);
  return nets;
}

Networks networks(TextReader& in, Arena& arena, const Tables& tables, std::int32_t n_output, std::size_t& n_basis) {
  Networks nets = {};
  network(in, arena, "force", 3, tables, n_output, nets.force);
  network(in, arena, "deformation", 6, tables, n_output, nets.deformation);
  const auto needed = static_cast<std::size_t>(nets.deformation.n_neurons);
  n_basis = n_basis > needed ? n_basis : needed;
  return nets;
}

const LinearResponse* linear_response(TextReader& in, Arena& arena, std::int32_t n_output) {
  LinearResponse linear = {};
  stiffness_line(in, linear.stiffness);
  in.keyword("unit_responses");
  in.end_line();
  double* unit[3];
  for (int axis = 0; axis < 3; ++axis) {
    linear.unit_response[axis] = unit[axis] = arena.take<double>(3 * static_cast<std::size_t>(n_output));
  }
  const bool fill = has_memory(arena);
  for (std::int32_t o = 0; o < n_output && in.good(); ++o) {
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 0; k < 3; ++k) {
        const double value = linear_entry(in);
        if (fill) unit[axis][3 * static_cast<std::size_t>(o) + static_cast<std::size_t>(k)] = value;
      }
    }
    in.end_line();
  }
  return place(arena, linear);
}

void prescribed(TextReader& in, Arena& arena, std::int32_t n_nodes, const phn_model& model,
                ActiveNode& node) {
  const std::int32_t n = count_line(in, "prescribed", 1);
  Column<std::int32_t> positions(arena, n);
  Column<double> weights(arena, n);
  std::int32_t previous = -1, kept = 0;
  for (std::int32_t i = 0; i < n && in.good(); ++i) {
    const std::int32_t number = ascending_node(in, n_nodes, previous);
    const double weight = in.real();
    if (!(std::fabs(weight) <= 1)) in.fail(PHN_ERROR_RANGE);
    in.end_line();
    // Only output nodes are ever asked for.
    const std::int32_t at = model.output_nodes ? find_sorted(model.output_nodes, model.n_output, number) : -1;
    if (at < 0) continue;
    positions.set(kept, at);
    weights.set(kept++, weight);
  }
  node.n_prescribed = kept;
  node.prescribed = positions.get();
  node.prescribed_weight = weights.get();
}

/// The depths of the node before, which most nodes have, too: stored once.
struct Depths {
  TextReader text;  ///< where they begin
  const double* values;
  double least, fill_distance;
  bool known;
};

bool same_depths(TextReader a, TextReader b, std::int32_t n) {
  for (std::int32_t i = 0; i < n; ++i) {
    if (a.real() != b.real()) return false;
    a.end_line();
    b.end_line();
    if (!a.good() || !b.good()) return false;
  }
  return true;
}

void trained_depths(TextReader& in, Arena& arena, const phn_model& model, Depths& depths) {
  const std::int32_t n = model.n_directions;
  const bool same = depths.known && same_depths(in, depths.text, n);
  depths.text = in;
  Column<double> depth(arena, same ? 0 : n);
  for (std::int32_t i = 0; i < n && in.good(); ++i) {
    const double value = in.real();
    if (!(value >= 0)) in.fail(PHN_ERROR_RANGE);
    depths.least = i == 0 ? value : std::fmin(value, depths.least);
    if (!same) depth.set(i, value);
    in.end_line();
  }
  if (!same) depths.values = depth.get();
  if (!same && in.good() && has_memory(arena)) depths.fill_distance = fill_distance(model, depths.values);
  depths.known = true;
}

/// Reads the response of a node at every level. @param at  which node it is
void responses(TextReader& in, Arena& arena, const Tables& tables, phn_model& model, const Levels& levels,
               std::int32_t at, ActiveNode& node) {
  const auto keep = [&](std::int32_t l, const ActiveNode& of_level) {
    if (levels.active[l]) levels.active[l][at] = of_level;
  };
  ActiveNode of_level = node;
  switch (model.family) {
    case Family::rbfn: {
      const Networks full = networks(in, arena, tables, model.n_output, model.n_basis);
      node.networks = place(arena, full);
      for (std::int32_t l = 0; l < levels.n_smaller && in.good(); ++l) {
        of_level.networks = place(arena, networks_level(in, arena, full));
        keep(l, of_level);
      }
      break;
    }
    case Family::linear:
      node.linear = linear_response(in, arena, model.n_output);
      break;
    case Family::modal: {
      const LoadedModal full = load_modal(in, arena, tables.n_displacements, model);
      node.modal = place<ModalResponse>(arena, full);
      for (std::int32_t l = 0; l < levels.n_smaller && in.good(); ++l) {
        of_level.modal =
            place(arena, load_modal_level(in, arena, tables.n_displacements, levels.level[l], full));
        keep(l, of_level);
      }
      break;
    }
  }
}

void active_node(TextReader& in, Arena& arena, const Tables& tables, phn_model& model, const Levels& levels,
                 std::int32_t at, std::int32_t number, Depths& depths, ActiveNode& node) {
  in.keyword("point");
  for (double& x : node.point) x = coordinate(in);
  in.end_line();
  node.output = model.output_nodes ? find_sorted(model.output_nodes, model.n_output, number) : -1;
  prescribed(in, arena, model.n_nodes, model, node);
  in.keyword("incomplete");
  node.incomplete = in.integer(0, model.n_directions) > 0;
  in.end_line();
  in.keyword("trained_depth");
  in.end_line();
  trained_depths(in, arena, model, depths);
  node.trained_depth = depths.values;
  node.least_depth = depths.least;
  node.fill_distance = depths.fill_distance;
  responses(in, arena, tables, model, levels, at, node);
}

/// Ascending node numbers with reference coordinates. @return their number
std::int32_t nodes_and_points(TextReader& in, Arena& arena, const char* keyword, std::int32_t n_nodes,
                              const std::int32_t*& nodes, const double*& points) {
  const std::int32_t n = count_line(in, keyword, 0);
  Column<std::int32_t> numbers(arena, n);
  Column<double> coordinates(arena, 3 * static_cast<std::size_t>(n));
  std::int32_t previous = -1;
  for (std::int32_t i = 0; i < n && in.good(); ++i) {
    numbers.set(i, ascending_node(in, n_nodes, previous));
    for (int k = 0; k < 3; ++k) coordinates.set(3 * static_cast<std::size_t>(i) + k, coordinate(in));
    in.end_line();
  }
  nodes = numbers.get();
  points = coordinates.get();
  return n;
}

/// Triangles, their corners turned from node numbers to vertices. Without memory there is nothing to look up.
void surface(TextReader& in, Arena& arena, phn_model& model) {
  model.n_triangles = count_line(in, "surface", 0);
  Column<std::int32_t> corners(arena, 3 * static_cast<std::size_t>(model.n_triangles));
  for (std::int32_t t = 0; t < model.n_triangles && in.good(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t node = in.integer(0, model.n_nodes - 1);
      if (!has_memory(arena)) continue;
      const std::int32_t vertex = find_vertex(model, node);
      if (vertex < 0) in.fail(PHN_ERROR_RANGE);
      corners.set(3 * static_cast<std::size_t>(t) + k, vertex);
    }
    in.end_line();
  }
  model.triangles = corners.get();
}

/// The word after `family`, or false.
bool family_word(TextReader& in, Family& family) {
  for (const Family known : {Family::rbfn, Family::linear, Family::modal}) {
    TextReader attempt = in;
    attempt.keyword(name(known));
    if (!attempt.good()) continue;
    in = attempt;
    family = known;
    return true;
  }
  return false;
}

}  // namespace

std::int32_t find_vertex(const phn_model& model, std::int32_t node) {
  const std::int32_t output = find_sorted(model.output_nodes, model.n_output, node);
  if (output >= 0) return output;
  const std::int32_t fixed = find_sorted(model.fixed_nodes, model.n_fixed, node);
  return fixed < 0 ? -1 : model.n_output + fixed;
}

std::int32_t find_active(const phn_model& model, std::int32_t node) {
  return find_sorted(model.active_nodes, model.n_active, node);
}

namespace {

int load_parts(TextReader& in, Arena& arena, const phn_model** result) {
  phn_model model = {};
  model.n_basis = 3;
  model.n_levels = 1;
  auto* placed = arena.take<phn_model>(1);

  in.rest_of_line();
  in.end_line();
  in.keyword("family");
  if (!in.good()) return in.status();
  if (!family_word(in, model.family)) in.fail_next(PHN_ERROR_FAMILY);
  in.end_line();
  const auto line = [&](const char* key) {
    in.keyword(key);
    const TextReader::Word words = in.rest_of_line();
    in.end_line();
    return words;
  };
  model.title = place_word(arena, line("title"));
  line("software");
  model.mesh_hash = place_word(arena, line("mesh_hash"));
  line("physics_hash");
  real_line(in, "max_displacement_m", &model.max_displacement, 1, true);
  const bool modal = model.family == Family::modal;
  if (modal && !(model.max_displacement >= 1 / largest_max_displacement &&
                 model.max_displacement <= largest_max_displacement)) {
    in.fail(PHN_ERROR_RANGE);
  }
  in.keyword("mesh_nodes");
  model.n_nodes = in.integer(1, INT32_MAX);
  in.end_line();
  model.n_directions = count_line(in, "directions", 1);
  model.directions = vector_table(in, arena, model.n_directions, 1);
  Tables tables;
  tables.n_displacements = count_line(in, "displacements", 1);
  if (in.good() && tables.n_displacements % model.n_directions != 0) in.fail(PHN_ERROR_RANGE);
  model.n_displacements = tables.n_displacements;
  model.displacements = tables.displacements =
      vector_table(in, arena, tables.n_displacements, modal ? model.max_displacement : 1);
  model.first_increment = model.max_displacement / 10;
  if (has_memory(arena) && in.good()) {
    const double first = length(model.displacements) * (modal ? model.max_displacement : 1);
    if (first > 1e-6 * model.max_displacement && first < 1e3 * model.max_displacement) model.first_increment = first;
  }

  model.n_fixed = nodes_and_points(in, arena, "fixed", model.n_nodes, model.fixed_nodes, model.fixed_points);
  model.n_output = nodes_and_points(in, arena, "output", model.n_nodes, model.output_nodes, model.output_points);
  tables.output_points = model.output_points;
  surface(in, arena, model);
  if (modal) load_shared(in, arena, tables.n_displacements, model);
  if (modal) load_fields(in, arena, model);
  Levels levels = {};
  load_levels(in, arena, tables.n_displacements, model, levels);
  auto* smaller = arena.take<phn_model>(static_cast<std::size_t>(levels.n_smaller));

  model.n_active = count_line(in, "active", 0);
  Column<std::int32_t> active_nodes(arena, model.n_active);
  Column<ActiveNode> active(arena, model.n_active);
  for (std::int32_t l = 0; l < levels.n_smaller; ++l)
    levels.active[l] = arena.take<ActiveNode>(static_cast<std::size_t>(model.n_active));
  Depths depths{in, nullptr, 0, 0, false};
  std::int32_t previous = -1;
  for (std::int32_t i = 0; i < model.n_active && in.good(); ++i) {
    in.keyword("node");
    const std::int32_t number = ascending_node(in, model.n_nodes, previous);
    in.end_line();
    active_nodes.set(i, number);
    ActiveNode node = {};
    active_node(in, arena, tables, model, levels, i, number, depths, node);
    active.set(i, node);
    if (arena.overflow()) return PHN_ERROR_BUFFER;
  }
  const auto n_kernels = static_cast<std::size_t>(model.shared.n_centers) + 3;
  const auto n_shared = static_cast<std::size_t>(model.shared.n_modes);
  model.n_scratch = n_kernels > n_shared ? n_kernels : n_shared;
  if (model.family == Family::rbfn) model.n_scratch = 3 * model.n_basis;
  model.n_scratch += model.n_basis;
  if (model.n_scratch < model.n_field_scratch) model.n_scratch = model.n_field_scratch;
  model.active_nodes = active_nodes.get();
  model.active = active.get();
  if (in.good() && !in.at_end()) in.fail(PHN_ERROR_SYNTAX);
  if (!in.good()) return in.status();
  if (arena.overflow()) return PHN_ERROR_BUFFER;
  if (placed) {
    model.full = placed;
    model.smaller = smaller;
    model.bytes = arena.used();
    place_levels(model, levels, smaller);
    *placed = model;
    *result = placed;
  }
  return PHN_OK;
}

}  // namespace

int load_model(const char* text, std::size_t length, Arena& arena, const phn_model** result, std::size_t& wrong_byte) {
  *result = nullptr;
  const int envelope = check_envelope(text, length, wrong_byte);
  if (envelope != PHN_OK) return envelope;
  TextReader in(text, length);
  const int status = load_parts(in, arena, result);
  wrong_byte = in.wrong_byte();
  return status;
}

}  // namespace PHN_RUNTIME
