// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "species_count.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/solvers/implicit_part.hpp"
#include "stiffront/solvers/line_coupling.hpp"
#include "stiffront/space/three_point.hpp"

namespace stiffront {
namespace {

/// The coefficient of every species' own first derivative, minus its velocity, at a state.
class Advection {
 public:
  Advection(const Field& shape, const DiffusionOperator& diffusion, const TransportTerm& transport)
      : transport_(&transport),
        spacing_(shape.decomposition().grid().spacing(0)),
        halo_(shape.decomposition(), diffusion.boundary(), shape.n_species(), 1, 1),
        u_(shape.similar()),
        u_x_(shape.decomposition(), shape.n_species(), 0),
        coefficient_(shape.decomposition(), shape.n_species(), 0) {
    const Decomposition& d = shape.decomposition();
    for (int i = 0; i < shape.n_x(); ++i) weights_.push_back(three_point_first(d.grid(), 0, d.offset_x() + i));
  }

  void evaluate(double t, const Field& at, const FreeBox& box) {
    u_.copy_interior(at);
    halo_.exchange(u_);
    for (int s = 0; s < u_.n_species(); ++s) {
      const double* const u = u_.row(s, 0);
      double* const u_x = u_x_.row(s, 0);
      for (int i = box.i_begin; i < box.i_end; ++i) {
        const ThreePoint& w = weights_[static_cast<std::size_t>(i)];
        u_x[i] = (w.before * (u[i - 1] - u[i]) + w.after * (u[i + 1] - u[i])) / spacing_;
      }
    }
    transport_->advection(t, u_, u_x_, coefficient_, box);
  }
  const double* coefficient(int species) const { return coefficient_.row(species, 0); }
  const ThreePoint& weights(int i) const { return weights_[static_cast<std::size_t>(i)]; }
  double spacing() const { return spacing_; }

 private:
  const TransportTerm* transport_;
  double spacing_;
  HaloExchange halo_;
  Field u_, u_x_, coefficient_;
  std::vector<ThreePoint> weights_;
};

template <int m>
class LinePart final : public ImplicitPart {
 public:
  LinePart(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction, ImplicitTerms terms,
           const TransportTerm* transport)
      : reaction_(&reaction),
        terms_(terms),
        decomposition_(&shape.decomposition()),
        free_(diffusion.boundary().free_box(*decomposition_)),
        jacobian_(*decomposition_, m * m, 0),
        system_(*decomposition_, decomposition_->grid().periodic[0]) {
    for (int s = 0; s < m; ++s) k_[s] = terms.gamma_diffusion * diffusion.k_x(s);
    for (int i = 0; i < shape.n_x(); ++i) weights_.push_back(three_point_second(decomposition_->grid(), 0, decomposition_->offset_x() + i));
    if (transport != nullptr && terms.gamma_advection > 0.0) advection_ = std::make_unique<Advection>(shape, diffusion, *transport);
  }

  void solve(double t, double h, const Field& at, Field& b, Work& work) override {
    if (terms_.reaction && terms_.stiff_rates_only) {
      reaction_->stiff_jacobian(t, at, jacobian_, free_);
    } else if (terms_.reaction) {
      reaction_->jacobian(t, at, jacobian_, free_);
    }
    if (advection_) advection_->evaluate(t, at, free_);
    const int n = b.n_x();
    for (int r = 0; r < m; ++r) {
      for (int c = 0; c < m; ++c) {
        double* to = system_.diagonal(r, c);
        const double* from = jacobian_.row(r * m + c, 0);
        for (int i = 0; i < n; ++i) to[i] = -h * from[i];
      }
      const double hk = h * k_[r];
      double* const lower = system_.lower(r);
      double* const diagonal = system_.diagonal(r, r);
      double* const upper = system_.upper(r);
      for (int i = 0; i < n; ++i) {
        const ThreePoint& w = weights_[static_cast<std::size_t>(i)];
        lower[i] = -(hk * w.before);
        diagonal[i] = (1.0 + hk * (w.before + w.after)) + diagonal[i];
        upper[i] = -(hk * w.after);
      }
      if (advection_) add_advection(h, r);
      std::copy_n(b.row(r, 0), n, system_.right_side(r));
    }
    fix_points(system_, free_, n);
    system_.factor_and_solve();
    for (int r = 0; r < m; ++r) std::copy_n(system_.right_side(r), n, b.row(r, 0));
    if (terms_.reaction) work.reaction_jacobians += free_.i_end - free_.i_begin;
    if (advection_) ++work.halo_exchanges;
    ++work.line_solves;
  }

 private:
  void add_advection(double h, int r) {
    const double factor = h * terms_.gamma_advection / advection_->spacing();
    const double* const a = advection_->coefficient(r);
    double* const lower = system_.lower(r);
    double* const diagonal = system_.diagonal(r, r);
    double* const upper = system_.upper(r);
    for (int i = free_.i_begin; i < free_.i_end; ++i) {
      const ThreePoint& w = advection_->weights(i);
      lower[i] -= factor * a[i] * w.before;
      diagonal[i] += factor * a[i] * (w.before + w.after);
      upper[i] -= factor * a[i] * w.after;
    }
  }

  const ReactionTerm* reaction_;
  ImplicitTerms terms_;
  const Decomposition* decomposition_;
  FreeBox free_;
  Field jacobian_;  // zero if the reaction is no part
  BlockTridiagonal<m> system_;
  double k_[m];
  std::vector<ThreePoint> weights_;
  std::unique_ptr<Advection> advection_;
};

}  // namespace

std::unique_ptr<ImplicitPart> make_block_tridiagonal_part(const Field& shape, const DiffusionOperator& diffusion,
                                                          const ReactionTerm& reaction, ImplicitTerms terms,
                                                          const TransportTerm* transport) {
  if (diffusion.dimension() != 1) throw Error(ErrorKind::input, "method.implicit_solver: \"block-tridiagonal\" is for one dimension");
  return for_species_count<std::unique_ptr<ImplicitPart>>(
      shape.n_species(), [&]<int m>() { return std::make_unique<LinePart<m>>(shape, diffusion, reaction, terms, transport); });
}

}  // namespace stiffront
