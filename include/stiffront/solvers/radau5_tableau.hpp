// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>

/// Radau IIA of order 5 in the form in which it is solved.
///
/// With z_i = u_i - u the three stages of a step h read  h^-1 A^-1 z = F(z),  F_i = f(t + c_i h, u + z_i). The eigenvalues of A^-1 are
///
///     gamma = 3 + g,  alpha -+ i beta = 3 - g/2 -+ i (sqrt(3)/2) (9^(1/3) + 3^(1/3)),   g = 9^(1/3) - 3^(1/3),
///
/// the zeros of the denominator 60 - 36 z + 9 z^2 - z^3 of the stability function. Let T hold the real eigenvector and the real and the
/// negative imaginary part of the complex one, both scaled to a last component of 1. Then T^-1 A^-1 T is block diagonal,
///
///     Lambda = [gamma 0 0; 0 alpha -beta; 0 beta alpha],
///
/// and in w = T^-1 z a Newton step is one real and one complex system of the size of f. The last row of T is (1, 1, 0): the new
/// solution is u + w_1 + w_2, and the second row of T^-1 is (0, 0, 1) minus the first.
///
/// The embedded formula of order 3 with the weight 1/gamma at f(t, u) gives the estimate
/// (gamma/h - J)^-1 (f(t, u) + (e_1 z_1 + e_2 z_2 + e_3 z_3)/h), e = (-13 - 7 sqrt(6), -13 + 7 sqrt(6), -1)/3.
///
/// @see Hairer & Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.5 (5.13) for A and IV.8 for the procedure.
namespace stiffront::radau5_tableau {

using Row = std::array<double, 3>;

inline constexpr Row c{0.15505102572168219018, 0.64494897427831780982, 1.0};  // (4 -+ sqrt(6))/10, 1

inline constexpr double gamma = 3.6378342527444957322;
inline constexpr double alpha = 2.6810828736277521339;
inline constexpr double beta = 3.0504301992474105694;

inline constexpr std::array<Row, 3> t{{{0.094438762488975241487, -0.14125529502095420843, -0.030029194105147424492},
                                       {0.25021312296533331138, 0.204129352293799932, 0.3829421127572619378},
                                       {1.0, 1.0, 0.0}}};
inline constexpr std::array<Row, 3> t_inverse{{{4.1787185915519047273, 0.32768282076106238708, 0.52337644549944954804},
                                               {-4.1787185915519047273, -0.32768282076106238708, 0.47662355450055045196},
                                               {-0.50287263494578687595, 2.5719269498556054292, -0.59603920482822492497}}};
/// e T, the error estimate's weights of w.
inline constexpr Row error_weights{-0.93650020789262414518, 1.3682501039463120726, 0.83103830636172115813};

}  // namespace stiffront::radau5_tableau
