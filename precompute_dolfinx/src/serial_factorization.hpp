// LDL^T on a single process.
#pragma once

#include <optional>

#include "linear_solver.hpp"
#include "multifrontal.hpp"

namespace phynness {

class SerialFactorization : public LinearSolver {
 public:
  bool factorize(Mat matrix) override;
  bool solve(Vec b, Vec x) override;
  int negative_pivots() override;
  void reset() override;

 private:
  std::optional<Multifrontal> _factors;
  bool _good = false;
};

}  // namespace phynness
