// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/plane_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::scatter;
using testing::unit_grid;

/// Two species coupled linearly.
struct Linear {
  static constexpr int n_species = 2;
  static constexpr const char* name = "linear";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 2> species{"u", "v"};
  static constexpr std::array<double, 2> diffusion{1.0, 1.0};
  static constexpr std::array<Parameter<Linear>, 0> parameters{};
  static constexpr std::array<Profile<Linear>, 0> profiles{};

  template <class T, class P>
  void rates(const T* u, T* du, const P& place) const {
    const auto rate = place.x + place.y + 1.0;
    du[0] = (u[0] * -300.0 + u[1] * 200.0) * T(rate);
    du[1] = u[0] * 50.0 - u[1] * 80.0;
  }
};

struct Setting {
  const char* name;
  Grid grid;
  BoundaryKind x, y;
  int order;
};
void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }

class PlaneCorrections : public ::testing::TestWithParam<Setting> {};

TEST_P(PlaneCorrections, WithTheirSweepsLeaveLittleOfAnyErrorHoweverStiffDiffusionIs) {
  const Setting& setting = GetParam();
  const Communicator comm(MPI_COMM_SELF);
  const auto zero = [](double, double, double) { return 0.0; };
  for (const std::vector<double>& coefficients : {std::vector<double>{3.0, 3.0}, {3.0, 0.003}, {0.0, 3.0}}) {
    const DiffusionProblem problem(comm, setting.grid, {both_sides(setting.x, 2, zero), both_sides(setting.y, 2, zero)}, coefficients,
                                   setting.order);
    const ModelKernelsOf<Linear> model({});
    const auto kernel = model.make_sbdf();
    const auto equations = model.make_sbdf_equations();
    const auto plane = make_plane_correction(problem.field(), problem.diffusion);
    HaloExchange halo(problem.decomposition, problem.boundary, 2, 1, problem.diffusion.halo_width(), problem.diffusion.diffusing_species());
    const FreeBox box = problem.boundary.free_box(problem.decomposition);
    for (double stiffness : {10.0, 300.0, 1e4, 1e6}) {
      // The solution is 0: what is left of v is error.
      Field v = problem.field([](int s, double x, double y) { return scatter(std::lround(1e6 * x), std::lround(1e6 * y), s); });
      Field out = v.similar();
      const Field r = v.similar();
      problem.boundary.impose(v, 0.0);
      SbdfSweep sweep;
      sweep.gamma = stiffness / problem.diffusion.spectral_radius();
      sweep.decomposition = &v.decomposition();
      sweep.r = rows_of(r);
      const auto size = [&] {
        double sum = 0.0;
        for (int s = 0; s < 2; ++s) {
          for (int j = box.j_begin; j < box.j_end; ++j) {
            for (int i = box.i_begin; i < box.i_end; ++i) sum += v.at(s, i, j) * v.at(s, i, j);
          }
        }
        return std::sqrt(sum);
      };
      double before = size();
      // Repeated it shows the modes damped least.
      for (int repetition = 0; repetition < 6; ++repetition) {
        for (std::size_t g = 0; g < PlaneCorrection::groups; ++g) {
          halo.exchange(v);
          sweep.v = rows_of(std::as_const(v));
          if (g == 1) plane->prepare(*equations, sweep);
          if (g > 0) plane->correct(*equations, sweep, v);
          for (double shift : plane->shifts(g)) {
            halo.exchange(v);
            sweep.v = rows_of(std::as_const(v));
            sweep.out = rows_of(out);
            sweep.shift = shift;
            kernel->sweep(problem.diffusion, sweep, box);
            swap(v, out);
          }
        }
        const double after = size();
        // BDF5 bears 1/28.
        EXPECT_LT(after, before / 36.0) << "stiffness " << stiffness << ", repetition " << repetition << ", D " << coefficients[0] << ' '
                                        << coefficients[1];
        before = after;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, PlaneCorrections,
    ::testing::Values(Setting{"neumann_2", unit_grid(65, 65), BoundaryKind::neumann, BoundaryKind::neumann, 2},
                      Setting{"neumann_even_4", unit_grid(90, 60), BoundaryKind::neumann, BoundaryKind::neumann, 4},
                      Setting{"periodic_2", unit_grid(64, 64, true, true), BoundaryKind::periodic, BoundaryKind::periodic, 2},
                      Setting{"neumann_even_all_the_way_2", unit_grid(128, 66), BoundaryKind::neumann, BoundaryKind::neumann, 2},
                      Setting{"periodic_short_end_2", unit_grid(65, 65, true, true), BoundaryKind::periodic, BoundaryKind::periodic, 2},
                      Setting{"periodic_odd_4", unit_grid(51, 51, true, true), BoundaryKind::periodic, BoundaryKind::periodic, 4},
                      Setting{"dirichlet_2", unit_grid(65, 50), BoundaryKind::dirichlet, BoundaryKind::dirichlet, 2},
                      Setting{"dirichlet_4", unit_grid(66, 47), BoundaryKind::dirichlet, BoundaryKind::dirichlet, 4},
                      Setting{"mixed_4", unit_grid(50, 34, false, true), BoundaryKind::dirichlet, BoundaryKind::periodic, 4},
                      Setting{"narrow_2", unit_grid(101, 5), BoundaryKind::neumann, BoundaryKind::neumann, 2},
                      Setting{"two_rows_2", unit_grid(40, 3), BoundaryKind::neumann, BoundaryKind::neumann, 2},
                      Setting{"somewhat_flat_4", unit_grid(97, 65), BoundaryKind::neumann, BoundaryKind::neumann, 4},
                      Setting{"flat_2", unit_grid(129, 65), BoundaryKind::neumann, BoundaryKind::dirichlet, 2}),
    [](const auto& parameter) { return std::string(parameter.param.name); });

}  // namespace
}  // namespace stiffront
