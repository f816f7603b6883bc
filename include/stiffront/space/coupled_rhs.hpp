// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/model/reaction_term.hpp"
#include "stiffront/space/diffusion_operator.hpp"
#include "stiffront/space/right_hand_side.hpp"

namespace stiffront {

/// The full right-hand side F(t, u) = D Laplacian(u) + rates(t, x, y, u).
class CoupledRhs final : public RightHandSide {
 public:
  CoupledRhs(const Decomposition& decomposition, const DiffusionOperator& diffusion, const ReactionTerm& reaction);

  /// du = F(t, u). Dirichlet points get du = 0. The halo of u is brought up to date. @mpi collective.
  void evaluate(double t, Field& u, Field& du) override;
  const Boundary& boundary() const override { return diffusion_->boundary(); }

  const DiffusionOperator& diffusion() const { return *diffusion_; }
  const ReactionTerm& reaction() const { return *reaction_; }
  const FreeBox& free_box() const { return free_; }
  std::int64_t evaluations() const { return halo_.count(); }

 private:
  const DiffusionOperator* diffusion_;
  const ReactionTerm* reaction_;
  FreeBox free_;
  HaloExchange halo_;
};

}  // namespace stiffront
