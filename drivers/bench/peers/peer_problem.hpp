// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

/// What a code that solves stiff systems is given: du/dt = D lap u + R(t, x, y, u) on a uniform grid, second-order centred
/// differences, no flux or periodic, as functions on packs of points that are as fast as those of the program under test.
///
/// Planar layout, unless a function says otherwise: the values of a species are consecutive, x fastest. "Interleaved": the species
/// of a point are consecutive, which keeps the band of a coupled matrix narrow.
namespace peers {

/// A run, from KEY=VALUE arguments.
struct Setup {
  std::string model;
  std::map<std::string, double> parameters;
  std::vector<double> diffusion;
  int n_x = 1, n_y = 1;
  double lower_x = 0.0, upper_x = 1.0, lower_y = 0.0, upper_y = 1.0;
  bool periodic_x = false, periodic_y = false;
  double start = 0.0, end = 1.0;
  double relative_tolerance = 1e-4, absolute_tolerance = 1e-6;
  std::string initial, final;                ///< files of raw doubles, planar
  std::map<std::string, std::string> other;  ///< for one solver only: its order, its linear solver

  static Setup parse(int argc, char** argv);
  int points() const { return n_x * n_y; }
  std::vector<double> read_initial(int n_species) const;
  void write_final(const double* u, int n_species) const;
};

class Problem {
 public:
  virtual ~Problem() = default;
  int n_species() const { return m_; }
  int points() const { return n_; }
  /// Diffusion coefficient over squared spacing.
  double k_x(int s) const { return k_x_[static_cast<std::size_t>(s)]; }
  double k_y(int s) const { return k_y_[static_cast<std::size_t>(s)]; }

  virtual void reaction(double t, const double* u, double* f) const = 0;
  /// f += D lap u
  void add_diffusion(const double* u, double* f) const;
  virtual void right_hand_side(double t, const double* u, double* f) const = 0;
  /// jv = (J_R + D lap) v
  virtual void jacobian_product(double t, const double* u, const double* v, double* jv) const = 0;
  /// Inverses of the points' I - gamma (J_R + diagonal of D lap), or without diffusion: one stream of packs, in the order they are used.
  virtual std::size_t size_of_blocks() const = 0;
  virtual void invert_blocks(double t, const double* u, double gamma, bool with_diffusion, double* blocks) const = 0;
  virtual void apply_blocks(const double* blocks, const double* r, double* z) const = 0;
  /// z = (I - gamma J_R)^-1 r, nothing stored.
  virtual void solve_reaction(double t, const double* u, double gamma, const double* r, double* z) const = 0;

  virtual void interleaved_right_hand_side(double t, const double* u, double* f) const = 0;
  /// jacobian[r * n_species + c] of the reaction at point k.
  virtual void point_jacobian(double t, int k, const double* u, double* jacobian) const = 0;

 protected:
  Problem(const Setup& setup, int n_species);

  int m_, n_, n_x_, n_y_;
  bool periodic_x_, periodic_y_;
  double lower_x_, dx_, lower_y_, dy_;
  std::vector<double> k_x_, k_y_;
};

std::unique_ptr<Problem> make_problem(const Setup& setup);

void interleave(int n_species, int points, const double* planar, double* interleaved);
void separate(int n_species, int points, const double* interleaved, double* planar);

}  // namespace peers
