// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include "custom_model_of.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/io/result_file.hpp"
#include "stiffront/model/expression.hpp"
#include "stiffront/model/space_expression.hpp"
#include "stiffront/solvers/halo_depth.hpp"
#include "stiffront/solvers/rock4.hpp"
#include "stiffront/space/sub_cell_closure.hpp"

namespace stiffront::app {
namespace {

Grid make_grid(const Case& c) {
  Grid g;
  g.dimension = c.grid.dimension();
  for (std::size_t d = 0; d < c.grid.points.size(); ++d) {
    g.points[d] = c.grid.points[d];
    g.lower[d] = c.grid.lower[d];
    g.upper[d] = c.grid.upper[d];
    g.periodic[d] = c.boundary.sides[d][0].kind == BoundaryKind::periodic;
    for (std::size_t side = 0; side < 2 && c.space.order == 8; ++side) {
      g.sub_cell[d][side] = c.boundary.sides[d][side].kind == BoundaryKind::dirichlet;
      if (g.sub_cell[d][side]) ++g.points[d];
    }
  }
  return g;
}

/// Of the widest stencil used.
int halo_width(const Case& c) { return std::max(c.space.order, c.space.quadrature_order.value_or(c.space.order)) / 2; }

/// The fewest points of a rank's part: the differences next to a sub-cell stay within it.
int fewest_points_of_a_part(const Case& c) {
  const bool closed = c.space.order == 8 && c.boundary.has_dirichlet();
  return closed ? SubCellClosure::columns : halo_width(c);
}

/// Of the states: room for several stages of the diffusion flow per exchange, where there is such a flow and others to exchange with.
int halo_of_states(const Case& c, const Decomposition& decomposition, const Boundary& boundary) {
  const int width = halo_width(c);
  const bool splits = std::holds_alternative<LieOptions>(c.method) || std::holds_alternative<StrangOptions>(c.method) ||
                      std::holds_alternative<AdaptiveStrangOptions>(c.method) || std::holds_alternative<DcsOptions>(c.method);
  if (!splits || c.diffusion_solver.name != DiffusionSolver::rock4 || c.space.order == 8) return width;
  const int asked = c.diffusion_solver.halo_depth > 0 ? c.diffusion_solver.halo_depth : Rock4::automatic_depth;
  return std::max(width, c.space.order / 2 * std::min(asked, largest_halo_depth(decomposition, boundary, c.space.order / 2)));
}

std::array<int, 2> processes(const Case& c) {
  std::array<int, 2> p{1, 1};
  for (std::size_t d = 0; d < c.grid.processes.size(); ++d) p[d] = static_cast<int>(c.grid.processes[d]);
  return p;
}

std::map<std::string, double> parameters(const Case& c) { return {c.model.parameters.begin(), c.model.parameters.end()}; }

/// Runs f; what is wrong with an expression in it is reported under the key it stands at.
template <class F>
auto at_key(const Case& c, const std::string& key, F f) {
  try {
    return f();
  } catch (const ExpressionError& e) {
    throw Error(ErrorKind::input, fmt::format("{}: {}: {}", c.file, key, e.what()));
  }
}

Boundary make_boundary(const Case& c) {
  const std::map<std::string, double> known = parameters(c);
  std::array<std::array<BoundarySide, 2>, 2> sides;
  for (std::size_t d = 0; d < 2; ++d) {
    for (std::size_t side = 0; side < 2; ++side) {
      const SideOptions& o = c.boundary.sides[d][side];
      BoundarySide& b = sides[d][side];
      switch (o.kind) {
        case BoundaryKind::neumann:
          b.kind = stiffront::BoundaryKind::neumann;
          break;
        case BoundaryKind::periodic:
          b.kind = stiffront::BoundaryKind::periodic;
          break;
        case BoundaryKind::dirichlet:
          b.kind = stiffront::BoundaryKind::dirichlet;
          break;
      }
      for (const auto& of_species : o.values) {
        const std::string key = fmt::format("boundary.{}_{}.{}", d == 0 ? "x" : "y", side == 0 ? "lower" : "upper", of_species.first);
        const SpaceExpression expression = at_key(c, key, [&] { return SpaceExpression(of_species.second, known); });
        b.values.emplace_back(expression);
        b.depends_on_time = b.depends_on_time || expression.depends_on_time();
      }
    }
  }
  return Boundary(std::move(sides));
}

std::unique_ptr<ModelKernels> make_model(const Case& c, const ModelRegistry& models) {
  if (!c.model.is_custom()) return models.make(c.model.name, parameters(c));
  return make_custom_model(custom_model_of(c.model));  // compiled once before, when the case was read
}

/// @return a sentence for the log, or nothing.
std::string initialise(const Case& c, const ModelKernels& model, Field& u) {
  if (!c.initial.profile.empty()) {
    model.initialise(c.initial.profile, u);
  } else if (!c.initial.file.empty()) {
    return read_state(c.initial.file, model.description().species, u).note;
  } else {
    const std::map<std::string, double> known = parameters(c);
    for (int s = 0; s < model.n_species(); ++s) {
      const auto& [species, value] = c.initial.expressions[static_cast<std::size_t>(s)];
      evaluate(at_key(c, "initial." + species, [&, &v = value] { return SpaceExpression(v, known); }), c.time.start, u, s);
    }
  }
  return {};
}

}  // namespace

std::vector<double> diffusion_coefficients(const Case& c) {
  const std::map<std::string, double> known = parameters(c);
  std::vector<double> d;
  for (const auto& [species, value] : c.model.diffusion) {
    d.push_back(at_key(c, "model.diffusion." + species, [&, &v = value] { return constant_expression(v, known); }));
  }
  return d;
}

Problem::Problem(const Case& c, const ModelRegistry& models, const Communicator& comm_in)
    : options(c),
      comm(comm_in),
      grid(make_grid(c)),
      decomposition(comm, grid, processes(c), fewest_points_of_a_part(c)),
      boundary(make_boundary(c)),
      model(make_model(c, models)),
      transport(model->make_transport()),
      diffusion(grid, boundary, diffusion_coefficients(c), c.space.order),
      rhs(decomposition, diffusion, *model, transport.get()),
      state(decomposition, model->n_species(), halo_of_states(c, decomposition, boundary)) {
  note_ = initialise(c, *model, state);
  boundary.impose(state, c.time.start);

  Agreement largest(0, model->n_species());
  for (int s = 0; s < model->n_species(); ++s) {
    double& m = largest.maxima[static_cast<std::size_t>(s)];
    for (int j = 0; j < state.n_y(); ++j) {
      for (int i = 0; i < state.n_x(); ++i) m = std::max(m, std::abs(state.at(s, i, j)));
    }
  }
  comm.agree(largest);
  scales_ = largest.maxima;
  for (double& scale : scales_) scale = scale > 0.0 ? scale : 1.0;
}

}  // namespace stiffront::app
