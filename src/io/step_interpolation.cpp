// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/step_interpolation.hpp"

#include <algorithm>
#include <cmath>

namespace stiffront {

double interpolate_in_step(double theta, double u0, double d0, double u1, double d1) {
  const double change = u1 - u0;
  // u(theta) = u0 + theta change + theta (1-theta) ((1-theta) a - theta b)
  double a = d0 - change;
  double b = d1 - change;
  const bool monotone = change >= 0.0 ? d0 >= 0.0 && d1 >= 0.0 && d0 <= 3.0 * change && d1 <= 3.0 * change
                                      : d0 <= 0.0 && d1 <= 0.0 && d0 >= 3.0 * change && d1 >= 3.0 * change;
  if (!monotone) {
    if (a * b < 0.0 && std::isfinite(a) && std::isfinite(b)) {
      const double limit_a = 4.0 * std::abs(b);
      const double limit_b = 4.0 * std::abs(a);
      a = std::clamp(a, -limit_a, limit_a);
      b = std::clamp(b, -limit_b, limit_b);
    } else {
      a = 0.0;
      b = 0.0;
    }
  }
  return u0 + theta * change + theta * (1.0 - theta) * ((1.0 - theta) * a - theta * b);
}

StepInterpolation::StepInterpolation(CoupledRhs& rhs, double t, Field& u, double t_new, Field& u_new)
    : rhs_(&rhs), t_(t), t_new_(t_new), u_(&u), u_new_(&u_new), slope_(u.similar()), slope_new_(u.similar()) {
  rhs.evaluate(t, u, slope_);
  rhs.evaluate(t_new, u_new, slope_new_);
}

void StepInterpolation::at(double time, Field& result) const {
  const double dt = t_new_ - t_;
  const double theta = (time - t_) / dt;
  for (int s = 0; s < result.n_species(); ++s) {
    for (int j = 0; j < result.n_y(); ++j) {
      const double* u0 = u_->row(s, j);
      const double* u1 = u_new_->row(s, j);
      const double* f0 = slope_.row(s, j);
      const double* f1 = slope_new_.row(s, j);
      double* out = result.row(s, j);
      for (int i = 0; i < result.n_x(); ++i) out[i] = interpolate_in_step(theta, u0[i], dt * f0[i], u1[i], dt * f1[i]);
    }
  }
  rhs_->diffusion().boundary().impose(result, time);
}

}  // namespace stiffront
