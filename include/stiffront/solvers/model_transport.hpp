// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <utility>

#include "stiffront/core/dual.hpp"
#include "stiffront/model/model.hpp"
#include "stiffront/model/transport_term.hpp"
#include "stiffront/space/laplacian.hpp"

namespace stiffront {

/// The transport of a model that has one.
template <ModelWithTransport M>
class ModelTransport final : public TransportTerm {
 public:
  explicit ModelTransport(M model) : model_(std::move(model)) {}

  void add(double t, const Field& u, const Field& u_x, const Field& u_xx, Field& du, const FreeBox& box) const override {
    const Decomposition& d = u.decomposition();
    for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
      Pack v[m], v_x[m], v_xx[m], dv[m];
      for (int s = 0; s < m; ++s) {
        v[s] = Pack::load_partial(u.row(s, 0) + i, n);
        v_x[s] = Pack::load_partial(u_x.row(s, 0) + i, n);
        v_xx[s] = Pack::load_partial(u_xx.row(s, 0) + i, n);
      }
      model_.transport(v, v_x, v_xx, dv, place_of_pack(d, t, i, 0, n));
      for (int s = 0; s < m; ++s) {
        double* out = du.row(s, 0) + i;
        (Pack::load_partial(out, n) + dv[s]).store_partial(out, n);
      }
    });
  }

  void advection(double t, const Field& u, const Field& u_x, Field& a, const FreeBox& box) const override {
    using D = Dual<Pack, m>;
    const Decomposition& d = u.decomposition();
    for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
      D v[m], v_x[m], v_xx[m], dv[m];
      for (int s = 0; s < m; ++s) {
        v[s] = D(Pack::load_partial(u.row(s, 0) + i, n));
        v_x[s] = D::variable(Pack::load_partial(u_x.row(s, 0) + i, n), s);
        v_xx[s] = D(0.0);
      }
      model_.transport(v, v_x, v_xx, dv, place_of_pack(d, t, i, 0, n));
      for (int s = 0; s < m; ++s) dv[s].derivative[s].store_partial(a.row(s, 0) + i, n);
    });
  }

 private:
  static constexpr int m = M::n_species;
  M model_;
};

}  // namespace stiffront
