// The tables of the study of extremes; each function prints one table.
#pragma once

#include <phynness/precompute/probe_solver.hpp>

namespace phynness::extremes {

// Finite elements only.
void incompressibility(const SolverSession& session);
void displacements(const SolverSession& session);
void origin(const SolverSession& session);
void slivers(const SolverSession& session);
// Models compared with finite elements.
void rest(const SolverSession& session);
void far_models(const SolverSession& session);
void extrapolation(const SolverSession& session);
void missing(const SolverSession& session);
void floats(const SolverSession& session);
void overfitting(const SolverSession& session);
void tools(const SolverSession& session);

}  // namespace phynness::extremes
