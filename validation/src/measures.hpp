// Work on all measures of a template that describes itself, such as PairMeasures: samples to statistics, member by
// member.
#pragma once

#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/error_statistics.hpp>

namespace phynness {

template <template <class> class Measures, class A, class B, class Work>
void member_by_member(Measures<A>& a, const Measures<B>& b, const Work& work) {
  std::vector<A*> of_a;
  Measures<A>::describe(a, [&](const auto&, A& value, const char* = nullptr) { of_a.push_back(&value); });
  auto at = of_a.begin();
  Measures<B>::describe(b, [&](const auto&, const B& value, const char* = nullptr) { work(**at++, value); });
}

/// Of the samples of all ranks, on rank 0. Collective.
template <template <class> class Measures>
Measures<ErrorStatistics> statistics(const SolverSession& session, const Measures<std::vector<double>>& samples) {
  Measures<ErrorStatistics> out;
  member_by_member(out, samples, [&](auto& of, const auto& list) { of = ErrorStatistics::of(session.gather(list)); });
  return out;
}

template <template <class> class Measures>
Measures<ErrorStatistics> statistics(const Measures<std::vector<double>>& samples) {
  Measures<ErrorStatistics> out;
  member_by_member(out, samples, [](auto& of, const auto& list) { of = ErrorStatistics::of(list); });
  return out;
}

}  // namespace phynness
