// Sentences about the results of a run. All numbers and cases in them are computed from its measurements.
#pragma once

#include "parts.hpp"

namespace phynness::study {

/// "a 1.20 %, b 0.80 %, ratio 1.5"; fractions.
std::string against(const std::string& a, double of_a, const std::string& b, double of_b);

/// "WHAT: Case 3: ...; Case 4: ... ."; empty if there is no case with a result.
class Finding {
 public:
  explicit Finding(std::string what) : _what(std::move(what)) {}
  void add(const CaseResult& of, const std::string& words);
  std::string sentence() const;

 private:
  std::string _what, _words;
};

/// Errors at which the histograms have their maximum, by number of neurons.
std::string peaks_of_histograms(const std::vector<const CaseResult*>& cases);
/// Errors of new probes compared with the paper's test and the linear predictor, with the most neurons.
std::string fresh_against_held(const std::vector<const CaseResult*>& cases, NodeCurve curve,
                               double PredictorAtNode::*linear);
/// The x with the smallest median error, in the paper's test and for new probes.
std::string best_x(const std::vector<const CaseResult*>& cases, NodeCurve curve, const std::string& x);
/// The error at the last x compared with that at the first x.
std::string last_against_first(const std::vector<const CaseResult*>& cases, NodeCurve curve, const std::string& x);
/// Numbers of nodes at which no network size keeps the largest force error below the noticeable difference.
std::string never_enough(const std::vector<const CaseResult*>& cases);
/// Time per additional vertex, from slopes of lines.
std::string slopes(const RuntimeTimes& times);
/// Two tools at the largest measured depth.
std::string deepest_pairs(const CaseResult& result);
/// Stiffness of one element over that of another, and errors of networks for both.
std::string locking(const CaseResult& locked, const CaseResult& free, const std::vector<double>& ratios);
/// Times of Tables 1 and 2 compared with a plain loop.
std::string plain_loop_against_ours(const RuntimeTimes& times);
std::string finest_level(const RuntimeTimes& times);

}  // namespace phynness::study
