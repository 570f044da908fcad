// What the run found, in sentences: every number and every case in them is computed from its measurements.
#pragma once

#include "parts.hpp"

namespace phynness::study {

/// "a 1.20 %, b 0.80 %, ratio 1.5"; fractions.
std::string against(const std::string& a, double of_a, const std::string& b, double of_b);

/// "WHAT: Case 3: ...; Case 4: ... ." or nothing where no case has something to say.
class Finding {
 public:
  explicit Finding(std::string what) : _what(std::move(what)) {}
  void add(const CaseResult& of, const std::string& words);
  std::string sentence() const;

 private:
  std::string _what, _words;
};

/// Where most pairs lie, by neurons.
std::string peaks_of_histograms(const std::vector<const CaseResult*>& cases);
/// Fresh probes against the paper's test and the linear predictor, with the most neurons.
std::string fresh_against_held(const std::vector<const CaseResult*>& cases, NodeCurve curve,
                               double PredictorAtNode::*linear);
/// The x with the smallest median error, as the paper and fresh.
std::string best_x(const std::vector<const CaseResult*>& cases, NodeCurve curve, const std::string& x);
/// The error with the last x against the first.
std::string last_against_first(const std::vector<const CaseResult*>& cases, NodeCurve curve, const std::string& x);
/// At how many nodes no size keeps the largest force error within what a hand notices.
std::string never_enough(const std::vector<const CaseResult*>& cases);
/// What a vertex more costs, by slopes of lines.
std::string slopes(const RuntimeTimes& times);
/// Two tools at the deepest measured depth.
std::string deepest_pairs(const CaseResult& result);
/// Stiffness of one element over another's, and how well networks learn each.
std::string locking(const CaseResult& locked, const CaseResult& free, const std::vector<double>& ratios);
/// Times of Tables 1 and 2 beside a plain loop.
std::string plain_loop_against_ours(const RuntimeTimes& times);
std::string finest_level(const RuntimeTimes& times);

}  // namespace phynness::study
