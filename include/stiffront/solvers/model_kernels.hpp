// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fmt/format.h>

#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "stiffront/core/error.hpp"
#include "stiffront/model/model.hpp"
#include "stiffront/model/reaction_term.hpp"
#include "stiffront/solvers/model_transport.hpp"
#include "stiffront/solvers/node_sweep.hpp"
#include "stiffront/solvers/radau5.hpp"
#include "stiffront/solvers/sbdf_equations.hpp"
#include "stiffront/solvers/sbdf_kernel.hpp"
#include "stiffront/solvers/sbdf_line.hpp"
#include "stiffront/solvers/spectral_bound.hpp"
#include "stiffront/space/laplacian.hpp"

namespace stiffront {

/// A model with its parameters, ready for use: the virtual face of everything that is compiled for one model's cell loop.
class ModelKernels : public ReactionTerm {
 public:
  virtual const ModelDescription& description() const = 0;
  int n_species() const override { return description().n_species(); }
  /// Fills the interior of u with a built-in profile. @throws Error(input) for a name the model does not have.
  virtual void initialise(const std::string& profile, Field& u) const = 0;
  /// @throws Error(bug) for tolerances that are not one positive number per species
  virtual std::unique_ptr<ReactionSolver> make_radau5(const CellTolerances& tolerances) const = 0;
  /// Null for models without first derivatives. @pre of what it is used for: the grid has one dimension
  virtual std::unique_ptr<TransportTerm> make_transport() const = 0;
  /// The sweeps of the method sbdf.
  virtual std::unique_ptr<SbdfKernel> make_sbdf() const = 0;
  /// The sweeps of the method sdc with all nodes of a step in parallel.
  virtual std::unique_ptr<NodeSweepKernel> make_node_sweep() const = 0;
  /// Newton iterations of sbdf on lines. @pre the grid has one dimension
  virtual std::unique_ptr<SbdfLine> make_sbdf_line(const Decomposition& decomposition) const = 0;
  /// What its corrections on coarser grids need. @pre the grid has two dimensions
  virtual std::unique_ptr<SbdfEquations> make_sbdf_equations() const = 0;
};

template <Model M>
class ModelKernelsOf final : public ModelKernels {
 public:
  /// @throws Error(input) for a parameter the model does not have.
  explicit ModelKernelsOf(const std::map<std::string, double>& parameters) : description_(describe<M>()) {
    for (const auto& [name, value] : parameters) {
      bool found = false;
      for (const Parameter<M>& p : M::parameters) {
        if (name == p.name) {
          model_.*p.member = value;
          found = true;
        }
      }
      if (!found) throw Error(ErrorKind::input, fmt::format("model.parameters.{}: the model \"{}\" has no such parameter", name, M::name));
    }
  }
  /// A model that was made elsewhere, with a description of its own (models written in case files).
  ModelKernelsOf(M model, ModelDescription description) : model_(std::move(model)), description_(std::move(description)) {}

  const ModelDescription& description() const override { return description_; }

  std::unique_ptr<ReactionSolver> make_radau5(const CellTolerances& tolerances) const override {
    return std::make_unique<Radau5<M>>(model_, tolerances);
  }

  std::unique_ptr<TransportTerm> make_transport() const override {
    if constexpr (ModelWithTransport<M>) {
      return std::make_unique<ModelTransport<M>>(model_);
    } else {
      return nullptr;
    }
  }

  std::unique_ptr<SbdfKernel> make_sbdf() const override { return std::make_unique<SbdfKernelOf<M>>(model_); }
  std::unique_ptr<NodeSweepKernel> make_node_sweep() const override { return std::make_unique<NodeSweepKernelOf<M>>(model_); }
  std::unique_ptr<SbdfLine> make_sbdf_line(const Decomposition& decomposition) const override {
    return std::make_unique<SbdfLineOf<M>>(model_, decomposition);
  }
  std::unique_ptr<SbdfEquations> make_sbdf_equations() const override { return std::make_unique<SbdfEquationsOf<M>>(model_); }

  void initialise(const std::string& profile, Field& u) const override {
    for (const Profile<M>& p : M::profiles) {
      if (profile != p.name) continue;
      const Decomposition& d = u.decomposition();
      if (d.grid().dimension < p.dimension) {
        throw Error(ErrorKind::input, fmt::format("initial.profile: \"{}\" needs a grid of {} dimensions", profile, p.dimension));
      }
      double cell[M::n_species];
      const Grid& grid = d.grid();
      const Grid uniform = grid.uniform();
      for (int j = 0; j < u.n_y(); ++j) {
        for (int i = 0; i < u.n_x(); ++i) {
          const std::int64_t at_i = d.offset_x() + i;
          const std::int64_t at_j = d.offset_y() + j;
          if (grid.is_sub_cell(0, at_i) || grid.is_sub_cell(1, at_j)) {
            p.evaluate(model_, grid, at_i, at_j, cell);
          } else {
            p.evaluate(model_, uniform, grid.uniform_index(0, at_i), grid.uniform_index(1, at_j), cell);
          }
          for (int s = 0; s < M::n_species; ++s) u.at(s, i, j) = cell[s];
        }
      }
      return;
    }
    throw Error(ErrorKind::input, fmt::format("initial.profile: the model \"{}\" has no profile \"{}\"", description_.name, profile));
  }

  void add_rates(double t, const Field& u, Field& du, const FreeBox& box) const override {
    constexpr int m = M::n_species;
    const Decomposition& d = u.decomposition();
    for (int j = box.j_begin; j < box.j_end; ++j) {
      for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
        Pack v[m];
        Pack dv[m];
        for (int s = 0; s < m; ++s) v[s] = Pack::load_partial(u.row(s, j) + i, n);
        model_.rates(v, dv, place_of_pack(d, t, i, j, n));
        for (int s = 0; s < m; ++s) {
          double* out = du.row(s, j) + i;
          (Pack::load_partial(out, n) + dv[s]).store_partial(out, n);
        }
      });
    }
  }

  void add_jacobian_product(double t, const Field& u, const Field& direction, Field& product, const FreeBox& box) const override {
    constexpr int m = M::n_species;
    const Decomposition& d = u.decomposition();
    for (int j = box.j_begin; j < box.j_end; ++j) {
      for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
        // One dual variable along the direction: the derivative of the rates is the product.
        Dual<Pack, 1> v[m];
        Dual<Pack, 1> dv[m];
        for (int s = 0; s < m; ++s) {
          v[s].value = Pack::load_partial(u.row(s, j) + i, n);
          v[s].derivative[0] = Pack::load_partial(direction.row(s, j) + i, n);
        }
        model_.rates(v, dv, place_of_pack(d, t, i, j));
        for (int s = 0; s < m; ++s) {
          double* out = product.row(s, j) + i;
          (Pack::load_partial(out, n) + dv[s].derivative[0]).store_partial(out, n);
        }
      });
    }
  }

  void jacobian(double t, const Field& u, Field& result, const FreeBox& box) const override {
    constexpr int m = M::n_species;
    const Decomposition& d = u.decomposition();
    for (int j = box.j_begin; j < box.j_end; ++j) {
      for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
        Pack v[m];
        Pack dv[m];
        Pack entries[m][m];
        for (int s = 0; s < m; ++s) v[s] = Pack::load_partial(u.row(s, j) + i, n);
        rates_and_jacobian(model_, v, dv, entries, place_of_pack(d, t, i, j, n));
        for (int k = 0; k < m * m; ++k) entries[k / m][k % m].store_partial(result.row(k, j) + i, n);
      });
    }
  }

  void stiff_jacobian(double t, const Field& u, Field& result, const FreeBox& box) const override {
    if constexpr (ModelWithStiffRates<M>) {
      using D = Dual<Pack, M::n_species>;
      constexpr int m = M::n_species;
      const Decomposition& d = u.decomposition();
      for (int j = box.j_begin; j < box.j_end; ++j) {
        for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
          D v[m];
          D dv[m];
          for (int s = 0; s < m; ++s) v[s] = D::variable(Pack::load_partial(u.row(s, j) + i, n), s);
          model_.stiff_rates(v, dv, place_of_pack(d, t, i, j, n));
          for (int k = 0; k < m * m; ++k) dv[k / m].derivative[k % m].store_partial(result.row(k, j) + i, n);
        });
      }
    } else {
      jacobian(t, u, result, box);
    }
  }

  double jacobian_bound(double t, const Field& u, const FreeBox& box) const override {
    constexpr int m = M::n_species;
    const Decomposition& d = u.decomposition();
    Pack largest(0.0);
    Mask finite(true);
    for (int j = box.j_begin; j < box.j_end; ++j) {
      for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
        Pack v[m];
        Pack dv[m];
        Pack jacobian[m][m];
        for (int s = 0; s < m; ++s) v[s] = Pack::load_partial(u.row(s, j) + i, n);
        rates_and_jacobian(model_, v, dv, jacobian, place_of_pack(d, t, i, j, n));
        const Pack bound = spectral_bound<m>(jacobian);
        finite &= is_finite(bound);
        largest = max(largest, bound);
      });
    }
    return all(finite) ? max_lane(largest) : std::numeric_limits<double>::infinity();
  }

  void rates_at(double t, double x, double y, const double* u, double* du) const override { cell_rates(model_, t, x, y, u, du); }
  void jacobian_at(double t, double x, double y, const double* u, double* jacobian) const override {
    cell_jacobian(model_, t, x, y, u, jacobian);
  }

 private:
  M model_{};
  ModelDescription description_;
};

}  // namespace stiffront
