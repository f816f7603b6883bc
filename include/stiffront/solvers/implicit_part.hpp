// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "stiffront/mesh/field.hpp"
#include "stiffront/model/reaction_term.hpp"
#include "stiffront/model/transport_term.hpp"
#include "stiffront/solvers/work.hpp"
#include "stiffront/space/diffusion_operator.hpp"

namespace stiffront {

/// The linear operator P of the splitting F(v) = -P v + (F(v) + P v), of which the first part is treated implicitly.
///
/// @see Hagstrom & Zhou, Commun. Appl. Math. Comput. Sci. 1(1), 2006, eq. (5-1)
class ImplicitPart {
 public:
  virtual ~ImplicitPart() = default;
  /// Solves (1 + h P) x = b for P at the state `at` and the time t; b becomes x. At Dirichlet points b holds x already. A singular
  /// matrix gives a solution that is not finite. @pre b is not `at`. @mpi collective.
  virtual void solve(double t, double h, const Field& at, Field& b, Work& work) = 0;
  /// What the user should know of the whole run, in one sentence; empty if nothing.
  virtual std::string closing_note() const { return {}; }
};

/// What P = -(reaction Jacobian + gamma_diffusion D Laplacian + gamma_advection a d/dx) is made of, with a from TransportTerm::advection. The
/// derivatives are those of three points per direction, whatever the order of the differences in F: twice of them (gamma = 2) outweigh
/// those of any order.
struct ImplicitTerms {
  bool reaction = true;
  double gamma_diffusion = 1.0;
  double gamma_advection = 0.0;
  bool stiff_rates_only = false;  ///< of the reaction, what the model calls stiff
};

/// Of the Laplacian only the diagonal: every cell by itself. Without communication, but as a correction it needs h times the spectral
/// radius of the diffusion to be moderate.
std::unique_ptr<ImplicitPart> make_cell_local_part(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction,
                                                   ImplicitTerms terms);

/// The whole P in one dimension, solved directly by block cyclic reduction (solvers/block_tridiagonal.hpp).
/// @param transport null for models without first derivatives
/// @throws Error(input) in two dimensions
std::unique_ptr<ImplicitPart> make_block_tridiagonal_part(const Field& shape, const DiffusionOperator& diffusion,
                                                          const ReactionTerm& reaction, ImplicitTerms terms,
                                                          const TransportTerm* transport = nullptr);

/// The whole P in two dimensions, by GMRES. The preconditioner is a V-cycle of multigrid with damped cell-Jacobi steps: cell blocks hold
/// the reaction's Jacobian and the diagonal of the Laplacian, coarser grids see means of the Jacobian, and a direction is coarsened only
/// where its coupling is strong (solvers/coarse_grids.hpp). Inner products are reproducible sums and all else is computed point by point,
/// so the bits do not depend on the ranks or their layout.
/// @param relative_tolerance on the preconditioned residual, each species relative to its own change
/// @throws Error(input) in one dimension
/// @cost   per iteration about 4 products with a matrix of 5 points and m^2 + 4 m entries each, and one reduction; 2 m^2 + 15 m fields
/// @see    Saad & Schultz, SIAM J. Sci. Stat. Comput. 7(3), 1986 (GMRES); Trottenberg, Oosterlee & Schueller, Multigrid, 2001, sections 2 and 5
std::unique_ptr<ImplicitPart> make_multigrid_part(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction,
                                                  ImplicitTerms terms, double relative_tolerance);

}  // namespace stiffront
