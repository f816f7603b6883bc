// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Repetitively pulsed gas discharge in air at atmospheric pressure, cm and s: electrons ne, positive ions np, negative ions nn,
///
///     dne/dt = (alpha - eta) |v| ne - beta ne np
///     dnp/dt = alpha |v| ne - beta np (ne + nn)
///     dnn/dt = eta |v| ne - beta np nn
///
/// with a field on x <= electrode during the first `pulse` seconds of every `period`, and none elsewhere and afterwards: then only
/// recombination and diffusion remain. The charge np - ne - nn is conserved by the reactions. Runs should restart at every
/// change of the field (time.breakpoints).
/// @see Descombes et al. 2011, eq. (6.4), whose recombination terms of the first two lines have the wrong sign; coefficients of
///      Morrow & Lowke, J. Phys. D 30, 1997, Appendix, as functions of field over gas density (the paper takes the attachment
///      from another source).
struct Discharge {
  static constexpr int n_species = 3;
  static constexpr const char* name = "discharge";
  static constexpr const char* source = "pulsed gas discharge in air; Descombes et al. 2011, section 6.2; Morrow & Lowke 1997";
  static constexpr std::array<const char*, 3> species{"ne", "np", "nn"};
  static constexpr std::array<double, 3> diffusion{50.0, 50.0, 50.0};
  static const std::array<Parameter<Discharge>, 6> parameters;
  static const std::array<Profile<Discharge>, 1> profiles;

  double field = 4e4;            ///< V/cm
  double gas_density = 2.45e19;  ///< 1/cm^3
  double electrode = 0.01;       ///< cm
  double period = 1e-6;          ///< s
  double pulse = 1e-8;           ///< s
  double recombination = 2e-7;   ///< beta, of electrons and of negative ions with positive ions, cm^3/s

  /// The end of the electrode, to which a grid point there belongs whatever its rounding.
  double end_of_electrode() const { return electrode * (1.0 + 1e-9); }

  /// Drift speed of electrons, cm/s. @param x field over gas density, V cm^2
  static double speed(double x) {
    if (x > 2e-15) return 7.4e21 * x + 7.1e6;
    if (x > 1e-16) return 1.03e22 * x + 1.3e6;
    if (x > 2.6e-17) return 7.2973e21 * x + 1.63e6;
    return 6.87e22 * x + 3.38e4;
  }
  /// Ionisation over gas density, cm^2.
  static double ionisation(double x) { return x > 1.5e-15 ? 2e-16 * std::exp(-7.248e-15 / x) : 6.619e-17 * std::exp(-5.593e-15 / x); }
  /// Attachment in collisions of two, over gas density, cm^2.
  static double two_body_attachment(double x) { return x > 1.05e-15 ? 8.889e-5 * x + 2.567e-19 : std::max(0.0, 6.089e-4 * x - 2.893e-19); }
  /// Attachment in collisions of three, over the square of the gas density, cm^5.
  static double three_body_attachment(double x) { return 4.7778e-59 * std::pow(x, -1.2749); }

  /// Ionisations per electron and second in the field.
  double ionisation_rate() const {
    const double x = field / gas_density;
    return ionisation(x) * gas_density * speed(x);
  }
  /// Attachments per electron and second in the field.
  double attachment_rate() const {
    const double x = field / gas_density;
    return (two_body_attachment(x) + three_body_attachment(x) * gas_density) * gas_density * speed(x);
  }

  /// Whether the field is on. A switching time belongs to what comes before it, as far as rounding goes: the last stage of a
  /// step that ends there must see the rates of the step. (Steps between restarts begin further behind it than that.)
  template <class Real>
  auto on(const Real& t, const Real& x) const {
    constexpr double nearest_integer = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds, subtracting it gives the integer
    const double half = 0.5 * pulse / period;
    const Real cycles = t / period - half;
    const Real from_middle = cycles - ((cycles + nearest_integer) - nearest_integer);
    const Real rounding = (4.0 * std::numeric_limits<double>::epsilon()) * (cycles + 3.0 * half);
    return (from_middle > rounding - half) && (from_middle <= rounding + half) && (x <= end_of_electrode());
  }

  template <class T, class P>
  void rates(const T* u, T* du, const P& place) const {
    using Real = std::remove_cvref_t<decltype(place.x)>;
    const auto fed = on<Real>(place.t, place.x);
    Real born(0.0);
    Real attached(0.0);
    if (field > 0.0 && any(fed)) {
      born = select(fed, Real(ionisation_rate()), born);
      attached = select(fed, Real(attachment_rate()), attached);
    }
    const T lost = recombination * u[1];
    du[0] = (born - attached) * u[0] - lost * u[0];
    du[1] = born * u[0] - lost * (u[0] + u[2]);
    du[2] = attached * u[0] - lost * u[2];
  }

  static void seed(const Discharge& m, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    u[0] = u[1] = grid.position(0, i) <= m.end_of_electrode() ? 1e14 : 1e9;
    u[2] = 0.0;
  }
};

inline constexpr std::array<Parameter<Discharge>, 6> Discharge::parameters{{{"field", &Discharge::field},
                                                                            {"gas_density", &Discharge::gas_density},
                                                                            {"electrode", &Discharge::electrode},
                                                                            {"period", &Discharge::period},
                                                                            {"pulse", &Discharge::pulse},
                                                                            {"recombination", &Discharge::recombination}}};
inline constexpr std::array<Profile<Discharge>, 1> Discharge::profiles{
    {{"discharge-seed", "ne = np = 1e14 at the electrode, 1e9 elsewhere", &Discharge::seed}}};

}  // namespace stiffront
