// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <optional>

#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/model/reaction_term.hpp"
#include "stiffront/model/transport_term.hpp"
#include "stiffront/space/diffusion_operator.hpp"
#include "stiffront/space/line_derivatives.hpp"
#include "stiffront/space/right_hand_side.hpp"

namespace stiffront {

/// The full right-hand side F(t, u) = D Laplacian(u) + rates(t, x, y, u), and in one dimension a model's transport(t, x, u, u_x, u_xx).
class CoupledRhs final : public RightHandSide {
 public:
  /// @param transport null for models without
  /// @throws Error(input) for transport in two dimensions
  CoupledRhs(const Decomposition& decomposition, const DiffusionOperator& diffusion, const ReactionTerm& reaction,
             const TransportTerm* transport = nullptr);

  /// du = F(t, u). Dirichlet points get du = 0. The halo of u is brought up to date. @mpi collective.
  void evaluate(double t, Field& u, Field& du) override;
  /// The same without the rates.
  void evaluate_without_rates(double t, Field& u, Field& du);
  const Boundary& boundary() const override { return diffusion_->boundary(); }

  const DiffusionOperator& diffusion() const { return *diffusion_; }
  const ReactionTerm& reaction() const { return *reaction_; }
  /// Null if there is none.
  const TransportTerm* transport() const { return transport_; }
  const FreeBox& free_box() const { return free_; }
  std::int64_t evaluations() const { return halo_.count(); }

 private:
  /// What transport needs, for fields of one shape.
  struct Derivatives {
    LineDerivatives of;
    Field u_x;
    Field u_xx;
  };

  const DiffusionOperator* diffusion_;
  const ReactionTerm* reaction_;
  const TransportTerm* transport_;
  FreeBox free_;
  HaloExchange halo_;
  std::optional<Derivatives> derivatives_;
};

}  // namespace stiffront
