// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <string>

#include "stiffront/app/problem.hpp"
#include "stiffront/control/deferred_correction.hpp"
#include "stiffront/control/method.hpp"
#include "stiffront/control/spectral_deferred_correction.hpp"
#include "stiffront/core/timer.hpp"
#include "stiffront/solvers/implicit_part.hpp"
#include "stiffront/splitting/reaction_flow.hpp"

namespace stiffront::app {

/// The method of a case together with the flows it is made of.
///
/// @throws Error(input) for what a case may say but the problem at hand does not allow.
class MethodStack {
 public:
  enum class Purpose {
    run,
    single_step,  ///< a step of an order study: one that is not stable is no error, since its modes are amplified just once
  };

  MethodStack(const Case& c, Problem& problem, Purpose purpose = Purpose::run);

  Method& method() { return *method_; }
  /// Null unless the method is dcs.
  DeferredCorrection* deferred_correction() const { return deferred_correction_; }
  /// Null for methods that do not split.
  const ReactionFlow* reaction_flow() const { return reaction_.get(); }
  /// Relative tolerance the reaction is integrated with; 0 for methods that do not split.
  double reaction_tolerance() const { return reaction_tolerance_; }
  /// Adds the time spent in the flows so far.
  void add_seconds(PhaseSeconds& phases) const;
  /// What balancing the reaction has done; nothing if there is no reaction flow or it does not balance. @mpi collective
  std::optional<BalanceCounts> balance() { return reaction_ ? reaction_->balance() : std::nullopt; }
  /// The method's options: those of the case, unless the program chose.
  const MethodOptions& chosen() const { return chosen_; }
  /// A sentence for the log and the summary when the method was chosen by the program; otherwise empty.
  const std::string& choice() const { return choice_; }

 private:
  /// Inner solvers must be finer than what they are there to reveal, whatever the case says. @return the larger of their tolerances
  double make_flows(const Case& c, Problem& problem, double finest_reaction, double finest_diffusion);
  void make(const Case& c, const LieOptions& o, Problem& problem);
  void make(const Case& c, const StrangOptions& o, Problem& problem);
  void make(const Case& c, const AdaptiveStrangOptions& o, Problem& problem);
  void make(const Case& c, const DcsOptions& o, Problem& problem);
  void make(const Case& c, const SdcOptions& o, Problem& problem);
  void make(const Case& c, const SbdfOptions& o, Problem& problem);
  void make(const Case& c, const CvodeOptions& o, Problem& problem);
  void make(const Case& c, const AutoOptions& o, Problem& problem);

  Purpose purpose_ = Purpose::run;
  double reaction_tolerance_ = 0.0;
  double diffusion_seconds_ = 0.0;
  std::unique_ptr<ReactionFlow> reaction_;
  std::unique_ptr<Flow> untimed_diffusion_;
  std::unique_ptr<Flow> diffusion_;
  std::unique_ptr<DiffusionOperator> quadrature_diffusion_;  // dcs with a higher order in its quadrature
  std::unique_ptr<CoupledRhs> quadrature_rhs_;
  std::unique_ptr<ImplicitPart> implicit_part_;  // sdc
  std::unique_ptr<StepPropagator> propagator_;   // sdc with a composition of flows
  std::unique_ptr<Method> method_;
  DeferredCorrection* deferred_correction_ = nullptr;
  MethodOptions chosen_;
  std::string choice_;
};

}  // namespace stiffront::app
