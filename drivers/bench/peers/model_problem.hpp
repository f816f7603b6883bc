// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <stdexcept>

#include "peer_problem.hpp"
#include "stiffront/core/dual.hpp"
#include "stiffront/core/simd.hpp"
#include "stiffront/model/model.hpp"

namespace peers {

using stiffront::Dual;
using stiffront::Pack;
using stiffront::pack_size;
using stiffront::Place;

/// The functions of a Problem for the rates of one model.
template <class Model>
class ModelProblem final : public Problem {
 public:
  ModelProblem(const Setup& setup, const Model& model) : Problem(setup, Model::n_species), model_(model) {}

  void reaction(double t, const double* u, double* f) const override {
    for_each_pack(t, [&](int k, int count, const Place<Pack>& place) {
      Pack v[m], r[m];
      load(u, k, count, v);
      model_.rates(v, r, place);
      store(r, f, k, count);
    });
  }

  void right_hand_side(double t, const double* u, double* f) const override {
    reaction(t, u, f);
    add_diffusion(u, f);
  }

  void jacobian_product(double t, const double* u, const double* v, double* jv) const override {
    for_each_pack(t, [&](int k, int count, const Place<Pack>& place) {
      Pack value[m], direction[m], product[m];
      Dual<Pack, 1> a[m], r[m];
      load(u, k, count, value);
      load(v, k, count, direction);
      for (int s = 0; s < m; ++s) {
        a[s].value = value[s];
        a[s].derivative[0] = direction[s];
      }
      model_.rates(a, r, place);
      for (int s = 0; s < m; ++s) product[s] = r[s].derivative[0];
      store(product, jv, k, count);
    });
    add_diffusion(v, jv);
  }

  std::size_t size_of_blocks() const override {
    return static_cast<std::size_t>((n_x_ + pack_size - 1) / pack_size) * static_cast<std::size_t>(n_y_ * m * m * pack_size);
  }
  void invert_blocks(double t, const double* u, double gamma, bool with_diffusion, double* blocks) const override {
    for_each_pack(t, [&](int k, int count, const Place<Pack>& place) {
      Pack a[m][m], inverse[m][m];
      implicit_block(u, k, count, place, gamma, with_diffusion, a);
      invert(a, inverse);
      for (int r = 0; r < m; ++r) {
        for (int c = 0; c < m; ++c, blocks += pack_size) inverse[r][c].store(blocks);
      }
    });
  }

  void apply_blocks(const double* blocks, const double* r, double* z) const override {
    for_each_pack(0.0, [&](int k, int count, const Place<Pack>&) {
      Pack in[m], out[m];
      load(r, k, count, in);
      for (int i = 0; i < m; ++i) {
        out[i] = Pack(0.0);
        for (int j = 0; j < m; ++j, blocks += pack_size) out[i] += Pack::load(blocks) * in[j];
      }
      store(out, z, k, count);
    });
  }

  void solve_reaction(double t, const double* u, double gamma, const double* r, double* z) const override {
    for_each_pack(t, [&](int k, int count, const Place<Pack>& place) {
      Pack a[m][m], x[m];
      implicit_block(u, k, count, place, gamma, false, a);
      load(r, k, count, x);
      for (int c = 0; c < m; ++c) {
        const Pack reciprocal = Pack(1.0) / a[c][c];
        for (int i = c + 1; i < m; ++i) {
          const Pack factor = a[i][c] * reciprocal;
          for (int j = c + 1; j < m; ++j) a[i][j] -= factor * a[c][j];
          x[i] -= factor * x[c];
        }
      }
      for (int i = m - 1; i >= 0; --i) {
        for (int j = i + 1; j < m; ++j) x[i] -= a[i][j] * x[j];
        x[i] /= a[i][i];
      }
      store(x, z, k, count);
    });
  }

  void interleaved_right_hand_side(double t, const double* u, double* f) const override {
    const double* c = u;
    for (int k = 0; k < n_; ++k, c += m, f += m) {
      model_.rates(c, f, place_of(t, k));
      const int i = k % n_x_;
      const double* left = i > 0 ? c - m : (periodic_x_ ? c + m * (n_x_ - 1) : c + m);
      const double* right = i < n_x_ - 1 ? c + m : (periodic_x_ ? c - m * (n_x_ - 1) : c - m);
      for (int s = 0; s < m; ++s) f[s] += k_x(s) * (left[s] - 2.0 * c[s] + right[s]);
      if (n_y_ == 1) continue;
      const int j = k / n_x_, row = m * n_x_;
      const double* down = j > 0 ? c - row : (periodic_y_ ? c + static_cast<std::ptrdiff_t>(row) * (n_y_ - 1) : c + row);
      const double* up = j < n_y_ - 1 ? c + row : (periodic_y_ ? c - static_cast<std::ptrdiff_t>(row) * (n_y_ - 1) : c - row);
      for (int s = 0; s < m; ++s) f[s] += k_y(s) * (down[s] - 2.0 * c[s] + up[s]);
    }
  }

  void point_jacobian(double t, int k, const double* u, double* jacobian) const override {
    double rates[m], rows[m][m];
    stiffront::rates_and_jacobian(model_, u, rates, rows, place_of(t, k));
    std::copy(&rows[0][0], &rows[0][0] + m * m, jacobian);
  }

 private:
  static constexpr int m = Model::n_species;

  Place<double> place_of(double t, int k) const { return {t, lower_x_ + k % n_x_ * dx_, lower_y_ + k / n_x_ * dy_}; }

  template <class F>
  [[gnu::always_inline]] void for_each_pack(double t, F f) const {
    Pack lanes(0.0);
    for (int l = 0; l < pack_size; ++l) lanes.set(l, l * dx_);
    for (int j = 0; j < n_y_; ++j) {
      for (int i = 0; i < n_x_; i += pack_size) {
        f(j * n_x_ + i, std::min(pack_size, n_x_ - i), Place<Pack>{t, Pack(lower_x_ + i * dx_) + lanes, Pack(lower_y_ + j * dy_)});
      }
    }
  }
  [[gnu::always_inline]] static Pack load_one(const double* p, int count) {
    return count == pack_size ? Pack::load(p) : Pack::load_partial(p, count);
  }
  [[gnu::always_inline]] static void store_one(Pack v, double* p, int count) {
    if (count == pack_size) {
      v.store(p);
    } else {
      v.store_partial(p, count);
    }
  }
  [[gnu::always_inline]] void load(const double* u, int k, int count, Pack* v) const {
    for (int s = 0; s < m; ++s) v[s] = load_one(u + static_cast<std::ptrdiff_t>(s) * n_ + k, count);
  }
  [[gnu::always_inline]] void store(const Pack* v, double* f, int k, int count) const {
    for (int s = 0; s < m; ++s) store_one(v[s], f + static_cast<std::ptrdiff_t>(s) * n_ + k, count);
  }

  [[gnu::always_inline]] void implicit_block(const double* u, int k, int count, const Place<Pack>& place, double gamma, bool with_diffusion,
                                             Pack (*a)[m]) const {
    Pack v[m], r[m];
    load(u, k, count, v);
    stiffront::rates_and_jacobian(model_, v, r, a, place);
    for (int i = 0; i < m; ++i) {
      if (with_diffusion) a[i][i] -= Pack(2.0 * (k_x(i) + k_y(i)));
      for (int j = 0; j < m; ++j) a[i][j] = Pack(i == j ? 1.0 : 0.0) - Pack(gamma) * a[i][j];
    }
  }

  /// Gauss-Jordan without pivoting: I - gamma J is far from singular where an integrator works.
  [[gnu::always_inline]] static void invert(Pack (*a)[m], Pack (*inverse)[m]) {
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < m; ++j) inverse[i][j] = Pack(i == j ? 1.0 : 0.0);
    }
    for (int c = 0; c < m; ++c) {
      const Pack reciprocal = Pack(1.0) / a[c][c];
      for (int j = 0; j < m; ++j) {
        a[c][j] *= reciprocal;
        inverse[c][j] *= reciprocal;
      }
      for (int i = 0; i < m; ++i) {
        if (i == c) continue;
        const Pack factor = a[i][c];
        for (int j = 0; j < m; ++j) {
          a[i][j] -= factor * a[c][j];
          inverse[i][j] -= factor * inverse[c][j];
        }
      }
    }
  }

  Model model_;
};

/// A model with the parameters of the setup.
template <class Model>
std::unique_ptr<Problem> problem_of(const Setup& setup) {
  Model model;
  for (const auto& [name, value] : setup.parameters) {
    const auto known = std::find_if(Model::parameters.begin(), Model::parameters.end(), [&](const auto& p) { return p.name == name; });
    if (known == Model::parameters.end()) throw std::runtime_error("model " + setup.model + " has no parameter " + name);
    model.*(known->member) = value;
  }
  return std::make_unique<ModelProblem<Model>>(setup, model);
}

}  // namespace peers
