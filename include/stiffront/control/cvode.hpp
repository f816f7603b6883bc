// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <vector>

#include "stiffront/control/method.hpp"
#include "stiffront/space/coupled_rhs.hpp"

namespace stiffront {

/// Parameters of the fully coupled solver.
struct CvodeOptions {
  enum class LinearSolver { band, gmres };
  double relative_tolerance = 1e-6;
  std::vector<double> absolute_tolerance;  ///< one per species
  LinearSolver linear_solver = LinearSolver::gmres;
};

/// The coupled system du/dt = D Laplacian(u) + rates by SUNDIALS' variable-order BDF: a reference for errors and a peer for cost.
///
/// Newton's method with the exact Jacobian: banded LU in one dimension on one rank, otherwise GMRES with the diagonal blocks of
/// the cells as preconditioner and exact products. Every attempt is one internal step of CVODE and is accepted; steps end at the
/// times asked for. Sums are order-free, so steps and bits do not depend on the number of ranks (for GMRES; the band solver needs one).
/// A restarted run begins with a fresh CVODE, which is accurate but not bitwise the same.
/// @see Hindmarsh et al., ACM TOMS 31(3), 2005
class Cvode final : public Method {
 public:
  /// @throws Error(input) for the band solver in two dimensions, on a periodic grid or on several ranks.
  Cvode(const Field& shape, CoupledRhs& rhs, CvodeOptions options);
  ~Cvode() override;

  double first_step(double t, double t_end, Field& u) override;
  Attempt attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) override;
  void restart(double t) override;

 private:
  class Solver;
  std::unique_ptr<Solver> solver_;
};

}  // namespace stiffront
