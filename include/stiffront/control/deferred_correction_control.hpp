// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

namespace stiffront {

/// Parameters of DC-S by the paper's symbols.
struct DeferredCorrectionOptions {
  enum class StepRule {
    k,     ///< (44): from the iterations done
    kmax,  ///< (46): as if all iterations had been done
    min,   ///< the smaller of the two
  };
  enum class Exponent {
    observed,   ///< 1/(k + p + 1), the power of the step the error has; with the rule k also the best k for its cost
    published,  ///< 1/k as in (44), 1/kmax as in (46): oscillates, see docs/dcs.md
  };

  double tolerance = 1e-4;      ///< eta; ignored with a fixed step
  double fixed_step = 0.0;      ///< if positive: this step and `iterations` corrections, no error control
  int iterations = 0;           ///< k of fixed steps
  bool refuse_unstable = true;  ///< fixed steps: whether one beyond the limit of stability is an error, or left to be looked at
  int stages = 3;               ///< s, 2 .. 5
  int max_iterations = 4;       ///< kmax; 0: the splitting alone, with (47)
  bool strang = false;          ///< Strang (p = 2) inside instead of Lie (p = 1); reaction last in both
  StepRule step_rule = StepRule::k;
  Exponent exponent = Exponent::observed;
  double safety = 0.9;        ///< nu: the next step aims at an error of nu eta; with published exponents, a factor on the step
  bool predict = true;        ///< give up early when the remaining iterations cannot reach the tolerance (section 5.1)
  double initial_step = 0.0;  ///< 0: from the fastest time scale
  double max_growth = 5.0;    ///< of the step
  std::vector<int> species;   ///< in the error norm; empty: all
};

/// Decides after every iterate of an attempt what to do next, and how long the next step is: equations (43), (44), (46), (47), section 5.1
/// and what was added to make them safe. Numbers only; the same on all ranks if its input is.
///
/// @see Duarte & Emmett 2016, section 5; docs/dcs.md for what was changed and why
class DeferredCorrectionControl {
 public:
  /// What was measured of the iterate v^k, in the norm of the method.
  struct Iterate {
    double residual = 0.0;    ///< e_k = |ubar^k - v_s^k|, ubar^k the quadrature over the step
    double distance = 0.0;    ///< |ubar^k - v_s^0|
    double quadrature = 0.0;  ///< estimate of the error of the quadrature itself, which the residuals cannot see
  };
  enum class Verdict {
    correct,            ///< make another correction
    accept,             ///< v^k is the result
    accept_prediction,  ///< v^0 is the result: good enough, and the corrections do not improve it
    reject,
  };

  /// Below this, in the relative norm, differences of iterates are round-off: the iteration has converged as far as it can.
  static constexpr double round_off_floor = 2e-14;
  /// Tolerances below this are taken for it: three floors.
  static constexpr double least_tolerance = 6e-14;

  /// @param stability_limits largest |z| for k = 0 .. kmax corrections
  DeferredCorrectionControl(const DeferredCorrectionOptions& options, std::vector<double> stability_limits);

  /// A new attempt. @param rate bound on |lambda| of diffusion and reaction together
  void begin(double dt, double rate);
  Verdict judge(const Iterate& iterate);

  /// After accept, accept_prediction and reject. Positive; below dt after a rejection.
  double dt_next() const { return dt_next_; }
  /// Estimate of the error of what was accepted, or the last one.
  double error() const { return error_; }
  /// Why the attempt was rejected.
  const char* reason() const { return reason_; }
  /// The attempt was no good for another reason (values that are not finite or refused): try half.
  void refuse() { finish(Verdict::reject, 0.5 * dt_); }

  /// What is remembered from step to step; state of the run.
  struct Memory {
    int hold = 0;  ///< accepted steps in which the step stays below rejected_step, with no more corrections than now
    double rejected_step = 0.0;
    int iterations = 0;             ///< of the last accepted step
    double step = 0.0;              ///< the last accepted one
    double prediction_step = 0.0;   ///< of the attempt whose prediction_error was measured
    double prediction_error = 0.0;  ///< e_0
    double prediction_power = 0.0;  ///< power of the step with which e_0 was seen to grow; 0: not seen yet
  };
  Memory& memory() { return memory_; }

 private:
  Verdict finish(Verdict verdict, double dt_new);
  void observe_power();
  double after_prediction() const;
  double proposed_step(const Iterate& iterate) const;
  double by_best_iterations(double aim, double bracket, double convergent) const;
  double by_quadrature(double quadrature) const;

  DeferredCorrectionOptions options_;
  std::vector<double> limits_;
  double eta_;
  double p_;
  double dt_ = 0.0;
  double rate_ = 0.0;
  int k_ = -1;
  int k_allowed_ = 0;
  double first_residual_ = 0.0;
  double last_residual_ = 0.0;
  double zeta_ = 0.0;         // residual quotient over dt
  double contraction_ = 0.0;  // r = sigma_k dt^k
  double error_ = 0.0;
  double dt_next_ = 0.0;
  const char* reason_ = "";
  Memory memory_;
  std::vector<double> estimates_;
};

}  // namespace stiffront
