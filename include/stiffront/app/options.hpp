// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "stiffront/control/sbdf_tables.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/splitting/composition.hpp"

/// Every entry of a case file as plain data, with its default. docs/input.md, made from the same table that parses a
/// case file, says what each one means. All times are in the model's time unit, lengths in its length unit.
namespace stiffront::app {

/// Name and value pairs in the order the user wrote them.
template <typename T>
using NamedList = std::vector<std::pair<std::string, T>>;

/// A number, or an expression that gives one.
using Value = std::variant<double, std::string>;

/// One tolerance for all species, or one per species.
using Tolerance = std::variant<double, NamedList<double>>;

/// [grid]: vertex-centred uniform grid; one entry per direction, x first.
struct GridOptions {
  std::vector<std::int64_t> points;
  std::vector<double> lower;            ///< default 0
  std::vector<double> upper;            ///< default 1
  std::vector<std::int64_t> processes;  ///< ranks per direction; 0 = chosen by the program

  int dimension() const { return static_cast<int>(points.size()); }
  bool operator==(const GridOptions&) const = default;
};

/// What holds on one side of the domain.
struct SideOptions {
  BoundaryKind kind = BoundaryKind::neumann;
  NamedList<Value> values;  ///< dirichlet: one entry per species, in the model's order

  bool operator==(const SideOptions&) const = default;
};

/// [boundary]: sides[direction][0 = lower, 1 = upper].
struct BoundaryOptions {
  std::array<std::array<SideOptions, 2>, 3> sides;

  bool has_dirichlet() const {
    for (const auto& [lower, upper] : sides) {
      if (lower.kind == BoundaryKind::dirichlet || upper.kind == BoundaryKind::dirichlet) return true;
    }
    return false;
  }

  bool operator==(const BoundaryOptions&) const = default;
};

/// [space]
struct SpaceOptions {
  int order = 2;
  std::optional<int> quadrature_order;  ///< complete case: always set

  bool operator==(const SpaceOptions&) const = default;
};

/// One reaction of [[model.reactions]].
struct ReactionOptions {
  std::string equation;
  Value rate;                         ///< coefficient of the law of mass action, or the whole rate
  std::optional<Value> reverse_rate;  ///< of the backward direction of "<->"
  bool mass_action = true;

  bool operator==(const ReactionOptions&) const = default;
};

/// [model]. In a complete case `parameters` and `diffusion` have every entry of the model.
struct ModelOptions {
  std::string name;
  std::vector<std::string> species;  ///< the model's own, or those of a custom model
  NamedList<double> parameters;
  NamedList<Value> diffusion;              ///< one entry per species, in the order of `species`
  NamedList<std::string> reaction;         ///< custom: expressions; without `reactions` one per species, in their order
  std::vector<ReactionOptions> reactions;  ///< custom: a reaction network, added to `reaction`
  NamedList<std::string> units;            ///< of x, t and species, for pictures; those not named have none

  bool is_custom() const { return name == "custom"; }
  bool operator==(const ModelOptions&) const = default;
};

/// [initial]: exactly one of the three is given.
struct InitialOptions {
  std::string profile;
  NamedList<Value> expressions;  ///< one entry per species, in the model's order
  std::string file;

  bool operator==(const InitialOptions&) const = default;
};

/// [time]
struct TimeOptions {
  double start = 0.0;
  double end = 0.0;
  std::vector<double> breakpoints;  ///< increasing, inside (start, end)
  struct RestartStep {
    double period = 0.0;  ///< 0 = never
    double step = 0.0;
    bool operator==(const RestartStep&) const = default;
  } restart_step;

  bool operator==(const TimeOptions&) const = default;
};

/// method.name = "lie"
struct LieOptions {
  double step = 0.0;
  SplittingOrder order = SplittingOrder::reaction_last;

  bool operator==(const LieOptions&) const = default;
};

/// method.name = "strang"
struct StrangOptions {
  double step = 0.0;
  SplittingOrder order = SplittingOrder::reaction_last;

  bool operator==(const StrangOptions&) const = default;
};

/// method.name = "adaptive-strang" (Descombes, Duarte, Dumont, Louvet, Massot, Confluentes Math. 3(3), 2011,
/// section 5.3)
struct AdaptiveStrangOptions {
  double tolerance = 1e-4;    ///< eta
  double initial_step = 0.0;  ///< 0 = chosen by the program
  double epsilon = 0.05;      ///< shift of the embedded splitting, at the start
  double epsilon_max = 0.49;  ///< below 1/2: beyond it a substep of the reaction would run backwards
  bool critical_step = true;
  int period = 10;               ///< N: accepted steps between two estimates of the critical step
  double safety = 0.9;           ///< upsilon
  double critical_safety = 0.9;  ///< zeta
  double beta = 0.1;
  double gamma = 0.95;
  double theta = 10.0;
  double max_growth = 5.0;            ///< of the step from one attempt to the next
  std::optional<double> final_error;  ///< of the whole run, in tolerances; 0 = neither estimated nor kept; complete case: set
  SplittingOrder order = SplittingOrder::reaction_last;
  std::vector<std::string> species;  ///< those that enter the error; complete case: never empty

  bool operator==(const AdaptiveStrangOptions&) const = default;
};

enum class Splitting { lie, strang };

/// Which rule gives the next step of DC-S: with the corrections done, with the most that may be done, or the smaller
/// one.
enum class StepRule { k, kmax, min };
enum class StepExponent { observed, published };

/// method.name = "dcs" (Duarte, Emmett, deferred correction of splittings). Exactly one of tolerance and step is set.
struct DcsOptions {
  std::optional<double> tolerance;  ///< eta
  std::optional<double> step;
  Splitting splitting = Splitting::lie;
  int stages = 3;                     ///< of Radau IIA
  std::optional<int> max_iterations;  ///< complete case: always set
  std::optional<int> iterations;      ///< fixed number, with step; complete case: set if step is
  StepRule step_rule = StepRule::k;
  StepExponent exponent = StepExponent::observed;  ///< of the step rules
  double safety = 0.9;                             ///< nu
  bool predict = true;
  double initial_step = 0.0;  ///< 0 = chosen by the program

  bool operator==(const DcsOptions&) const = default;
};

enum class NodeFamily { gauss_legendre, gauss_lobatto, gauss_radau };
enum class SdcSplitting { preconditioned, imex, lie, strang, diagonal };
enum class SdcImplicit { diffusion, reaction };
enum class SdcSolver { automatic, cell_local, block_tridiagonal, multigrid };
enum class SdcCorrection { standard, alternative };
enum class SdcFinalUpdate { automatic, last_node, quadrature, extrapolation };

/// method.name = "sdc" (Hagstrom, Zhou, CAMCoS 1(1), 2006). Exactly one of tolerance and step is set.
struct SdcOptions {
  NodeFamily nodes = NodeFamily::gauss_radau;
  int node_count = 4;
  std::optional<double> step;
  std::optional<double> tolerance;
  double initial_step = 0.0;          ///< 0 = chosen by the program
  std::optional<int> starting_order;  ///< complete case: always set
  std::optional<int> corrections;     ///< complete case: always set
  bool consistent = true;
  SdcCorrection correction = SdcCorrection::standard;
  SdcFinalUpdate final_update = SdcFinalUpdate::automatic;
  bool acceleration = false;
  std::optional<double> gamma_diffusion;  ///< complete case: always set
  double gamma_advection = 0.0;
  SdcSplitting splitting = SdcSplitting::preconditioned;
  SdcImplicit implicit = SdcImplicit::diffusion;
  SdcSolver implicit_solver = SdcSolver::automatic;
  double linear_tolerance = 1e-5;

  bool operator==(const SdcOptions&) const = default;
};

/// method.name = "sbdf"
struct SbdfOptions {
  double relative_tolerance = 1e-4;
  std::optional<Tolerance> absolute_tolerance;  ///< complete case: always set
  int max_order = sbdf_max_order;
  int max_sweeps = sbdf_max_sweeps;
  double initial_step = 0.0;  ///< 0 = chosen by the program

  bool operator==(const SbdfOptions&) const = default;
};

enum class LinearSolver { band, gmres };

/// method.name = "cvode"
struct CvodeOptions {
  double relative_tolerance = 1e-6;
  std::optional<Tolerance> absolute_tolerance;  ///< complete case: always set
  std::optional<LinearSolver> linear_solver;    ///< complete case: always set

  bool operator==(const CvodeOptions&) const = default;
};

/// method.name = "auto"
struct AutoOptions {
  double tolerance = 1e-4;

  bool operator==(const AutoOptions&) const = default;
};

/// [method]: the alternative is the name.
using MethodOptions =
    std::variant<AdaptiveStrangOptions, LieOptions, StrangOptions, DcsOptions, SdcOptions, SbdfOptions, CvodeOptions, AutoOptions>;

enum class DiffusionSolver { rock4, crank_nicolson };

/// [diffusion_solver]
struct DiffusionSolverOptions {
  DiffusionSolver name = DiffusionSolver::rock4;
  double tolerance = 1e-5;
  int halo_depth = 0;  ///< 0 = chosen by the program

  bool operator==(const DiffusionSolverOptions&) const = default;
};

enum class ReactionSolver { radau5, cvode, trapezoidal };
enum class Balance { automatic, off };
enum class Positivity { report, reject_step };

/// [reaction_solver]
struct ReactionSolverOptions {
  ReactionSolver name = ReactionSolver::radau5;
  double tolerance = 1e-5;
  Balance balance = Balance::automatic;
  Positivity positivity = Positivity::report;

  bool operator==(const ReactionSolverOptions&) const = default;
};

enum class OutputMode { interpolate, land };
enum class OnFailure { stop, proceed };

/// output.checkpoint
struct CheckpointOptions {
  double every_seconds = 600.0;  ///< 0 = never
  std::int64_t every_steps = 0;  ///< 0 = never
  int keep = 2;
  bool at_end = false;
  OnFailure on_failure = OnFailure::stop;

  bool operator==(const CheckpointOptions&) const = default;
};

/// [output]: at most one of times, every and steps is given.
struct OutputOptions {
  std::string directory = "out";
  std::vector<double> times;  ///< increasing, inside [start, end]
  double every = 0.0;         ///< 0 = off
  std::int64_t steps = 0;     ///< 0 = off
  OutputMode mode = OutputMode::interpolate;
  std::vector<std::vector<double>> probes;
  CheckpointOptions checkpoint;

  bool operator==(const OutputOptions&) const = default;
};

/// [limits]
struct LimitsOptions {
  double wall_time = 0.0;        ///< seconds; 0 = none
  std::int64_t max_steps = 0;    ///< 0 = none
  double stall_limit_s = 600.0;  ///< 0 = none

  bool operator==(const LimitsOptions&) const = default;
};

enum class ConvergenceKind { global, local };

/// converge.reference: exactly one of method and file is given.
struct ReferenceOptions {
  std::string method;               ///< "cvode" or "sdc"
  std::optional<double> tolerance;  ///< cvode; complete case: set for it
  std::optional<double> step;       ///< sdc
  std::string file;

  bool operator==(const ReferenceOptions&) const = default;
};

/// [converge]
struct ConvergeOptions {
  std::vector<double> steps;
  ConvergenceKind kind = ConvergenceKind::global;
  std::vector<int> iterations;  ///< dcs only
  ReferenceOptions reference;

  bool operator==(const ConvergeOptions&) const = default;
};

/// A complete, valid case: what a run needs to know and nothing it has to look up again.
struct Case {
  std::string title;
  GridOptions grid;
  BoundaryOptions boundary;
  SpaceOptions space;
  ModelOptions model;
  InitialOptions initial;
  TimeOptions time;
  MethodOptions method;
  DiffusionSolverOptions diffusion_solver;
  ReactionSolverOptions reaction_solver;
  OutputOptions output;
  LimitsOptions limits;
  std::optional<ConvergeOptions> converge;

  std::string file;                    ///< as the user named it, for messages
  std::string text;                    ///< the case file as it was read
  std::vector<std::string> overrides;  ///< KEY=VALUE in the order given

  /// Equal options; where they came from does not matter.
  bool same_options(const Case& other) const;
};

}  // namespace stiffront::app
