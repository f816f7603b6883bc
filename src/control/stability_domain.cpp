// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/stability_domain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>

// g++ 12 warns inside Eigen's AVX-512 code; the matrices here are tiny.
#ifndef EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_VECTORIZE
#endif
#include <Eigen/Eigenvalues>

#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

using Complex = std::complex<double>;

/// u' = z u at every point of a line, each with a z of its own; species 0 and 1 are the real and the imaginary part.
class TestEquation final : public RightHandSide {
 public:
  TestEquation(const Grid& grid, std::span<const Complex> z) : boundary_(Boundary::natural(grid)), z_(z) {}
  void evaluate(double, Field& u, Field& du) override { multiply(u, du); }
  const Boundary& boundary() const override { return boundary_; }
  void multiply(const Field& u, Field& du) const {
    for (int i = 0; i < u.n_x(); ++i) {
      const Complex z = z_[static_cast<std::size_t>(i)];
      const double re = u.at(0, i), im = u.at(1, i);
      du.at(0, i) = z.real() * re - z.imag() * im;
      du.at(1, i) = z.real() * im + z.imag() * re;
    }
  }

 private:
  Boundary boundary_;
  std::span<const Complex> z_;
};

class TestPart final : public ImplicitPart {
 public:
  TestPart(TestSplitting splitting, std::span<const Complex> z) : splitting_(splitting), z_(z) {}
  void solve(double, double h, const Field&, Field& b, Work&) override {
    for (int i = 0; i < b.n_x(); ++i) {
      const Complex z = z_[static_cast<std::size_t>(i)];
      const Complex x = Complex(b.at(0, i), b.at(1, i)) / (1.0 - h * Complex(splitting_.real * z.real(), splitting_.imaginary * z.imag()));
      b.at(0, i) = x.real();
      b.at(1, i) = x.imag();
    }
  }

 private:
  TestSplitting splitting_;
  std::span<const Complex> z_;
};

/// What a method keeps from step to step, to be read and replaced.
class History final : public StateVisitor {
 public:
  void read(Method& method) { replaces_ = false, method.visit_state(*this); }
  void replace(Method& method) { replaces_ = true, method.visit_state(*this); }

  void numbers(const std::string& name, std::vector<double>& values) override {
    if (!replaces_) lists[name] = values;
    if (replaces_) values = lists.at(name);
  }
  void field(const std::string& name, Field& values) override {
    auto place = fields.find(name);
    if (place == fields.end()) place = fields.emplace(name, values.similar()).first;
    replaces_ ? values.copy_interior(place->second) : place->second.copy_interior(values);
  }
  void cells(const std::string&, std::vector<double>&) override {}

  std::map<std::string, std::vector<double>> lists;
  std::map<std::string, Field> fields;

 private:
  bool replaces_ = false;
};

void set(Field& u, double value) {
  for (int i = 0; i < u.n_x(); ++i) u.at(0, i) = value, u.at(1, i) = 0.0;
}

/// The largest modulus of an eigenvalue.
double spectral_radius(const Eigen::MatrixXcd& a) {
  if (!a.allFinite()) return std::numeric_limits<double>::infinity();
  return Eigen::ComplexEigenSolver<Eigen::MatrixXcd>(a, false).eigenvalues().cwiseAbs().maxCoeff();
}

/// The first place along a way that is not stable. @param samples places in order; place: their z
std::optional<double> first_exit(const SpectralDeferredCorrectionOptions& o, TestSplitting splitting, std::vector<double> samples,
                                 const std::function<Complex(double)>& place) {
  std::optional<double> exit;
  for (int pass = 0; pass < 4; ++pass) {
    std::vector<Complex> z;
    for (double s : samples) z.push_back(place(s));
    const std::vector<double> radii = amplification(o, splitting, z);
    const auto unstable = std::find_if(radii.begin(), radii.end(), [](double r) { return !is_stable(r); });
    if (unstable == radii.end()) return exit;
    const auto k = static_cast<std::size_t>(unstable - radii.begin());
    exit = samples[k];
    if (k == 0) return exit;
    const double from = samples[k - 1], to = samples[k];
    samples.clear();
    for (int i = 0; i <= 50; ++i) samples.push_back(from + (to - from) * i / 50.0);
  }
  return exit;
}

}  // namespace

bool is_stable(double radius) { return radius <= 1.0 + 1e-8; }

std::vector<double> amplification(const SpectralDeferredCorrectionOptions& given, TestSplitting splitting, std::span<const Complex> z) {
  if (!(given.fixed_step > 0.0) || given.accelerate) {
    throw Error(ErrorKind::input, "amplification matrices are those of fixed steps without acceleration");
  }
  SpectralDeferredCorrectionOptions o = given;
  o.fixed_step = 1.0;  // z includes it
  const Communicator self(MPI_COMM_SELF);
  Grid grid;
  grid.points = {static_cast<std::int64_t>(z.size()), 1};
  const Decomposition line(self, grid, {1, 1}, 1);
  TestEquation equation(grid, z);
  TestPart part(splitting, z);
  Field u(line, 2, 0);
  SpectralDeferredCorrection method(u, equation, part, nullptr, o);

  Field u_new = u.similar();
  std::uint64_t flags = 0;
  const auto step = [&] {
    method.attempt(0.0, 1.0, u, u_new, flags);
    method.accept(u, u_new);
  };
  step();  // of zeros: fills the history
  History history;
  history.read(method);
  const std::size_t k = history.lists.at("history_times").size() + 1;
  const auto state_name = [](std::size_t i) { return fmt::format("history-state-{}", i); };
  const auto slope_name = [](std::size_t i) { return fmt::format("history-slope-{}", i); };

  std::vector<Eigen::MatrixXcd> matrices(z.size(), Eigen::MatrixXcd(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k)));
  for (std::size_t column = 0; column < k; ++column) {
    set(u, column == 0 ? 1.0 : 0.0);
    history.lists["has_slope"] = {0.0};
    for (std::size_t i = 1; i < k; ++i) {
      set(history.fields.at(state_name(i)), i == column ? 1.0 : 0.0);
      equation.multiply(history.fields.at(state_name(i)), history.fields.at(slope_name(i)));
    }
    history.replace(method);
    step();
    history.read(method);
    for (std::size_t row = 0; row < k; ++row) {
      const Field& v = row == 0 ? u : history.fields.at(state_name(row));
      for (std::size_t i = 0; i < z.size(); ++i) {
        const auto x = static_cast<int>(i);
        matrices[i](static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) = {v.at(0, x), v.at(1, x)};
      }
    }
  }
  std::vector<double> radii;
  for (const Eigen::MatrixXcd& a : matrices) radii.push_back(spectral_radius(a));
  return radii;
}

StabilityDomain stability_domain(const SpectralDeferredCorrectionOptions& o, TestSplitting splitting, std::vector<double> at) {
  StabilityDomain d;
  constexpr int n = StabilityDomain::cells;
  std::vector<Complex> z;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) z.emplace_back(d.raster_left * (1.0 - (i + 0.5) / n), d.raster_top * (j + 0.5) / n);
  }
  d.raster = amplification(o, splitting, z);
  const auto stable = static_cast<double>(std::count_if(d.raster.begin(), d.raster.end(), is_stable));
  d.area = stable * (-d.raster_left / n) * (d.raster_top / n);

  std::vector<double> along_axis;
  for (int i = 0; i <= 8000; ++i) along_axis.push_back(std::pow(10.0, -2.0 + 6.0 * i / 8000.0));
  d.real_axis = first_exit(o, splitting, along_axis, [](double s) { return Complex(-s, 0.0); });
  std::vector<double> upwards;
  for (int i = 0; i <= 8000; ++i) upwards.push_back(d.strip_end * i / 8000.0);
  for (double alpha : at) d.beta.push_back(first_exit(o, splitting, upwards, [alpha](double s) { return Complex(alpha, s); }));
  d.at = std::move(at);
  const Complex far(-1e8, 0.0);
  d.at_infinity = amplification(o, splitting, std::span(&far, 1)).front();
  return d;
}

}  // namespace stiffront
