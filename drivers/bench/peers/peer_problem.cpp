// SPDX-License-Identifier: BSD-3-Clause
#include "peer_problem.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace peers {

namespace {

std::vector<double> numbers(const std::string& text) {
  std::vector<double> result;
  std::stringstream stream(text);
  for (std::string item; std::getline(stream, item, ',');) result.push_back(std::stod(item));
  return result;
}

}  // namespace

Setup Setup::parse(int argc, char** argv) {
  Setup s;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const std::size_t equals = argument.find('=');
    if (equals == std::string::npos) throw std::runtime_error(argument + " is not KEY=VALUE");
    const std::string key = argument.substr(0, equals);
    const std::string value = argument.substr(equals + 1);
    if (key.starts_with("parameters."))
      s.parameters[key.substr(11)] = std::stod(value);
    else if (key == "model")
      s.model = value;
    else if (key == "diffusion")
      s.diffusion = numbers(value);
    else if (key == "points") {
      const auto n = numbers(value);
      s.n_x = static_cast<int>(n.at(0));
      s.n_y = n.size() > 1 ? static_cast<int>(n[1]) : 1;
    } else if (key == "lower") {
      const auto n = numbers(value);
      s.lower_x = n.at(0);
      s.lower_y = n.size() > 1 ? n[1] : 0.0;
    } else if (key == "upper") {
      const auto n = numbers(value);
      s.upper_x = n.at(0);
      s.upper_y = n.size() > 1 ? n[1] : 1.0;
    } else if (key == "periodic") {
      const auto n = numbers(value);
      s.periodic_x = n.at(0) != 0.0;
      s.periodic_y = n.size() > 1 && n[1] != 0.0;
    } else if (key == "start")
      s.start = std::stod(value);
    else if (key == "end")
      s.end = std::stod(value);
    else if (key == "relative_tolerance")
      s.relative_tolerance = std::stod(value);
    else if (key == "absolute_tolerance")
      s.absolute_tolerance = std::stod(value);
    else if (key == "initial")
      s.initial = value;
    else if (key == "final")
      s.final = value;
    else
      s.other[key] = value;
  }
  return s;
}

std::vector<double> Setup::read_initial(int n_species) const {
  std::vector<double> u(static_cast<std::size_t>(n_species) * static_cast<std::size_t>(points()));
  std::ifstream file(initial, std::ios::binary);
  file.read(reinterpret_cast<char*>(u.data()), static_cast<std::streamsize>(u.size() * sizeof(double)));
  if (!file) throw std::runtime_error("cannot read " + initial);
  return u;
}

void Setup::write_final(const double* u, int n_species) const {
  const std::size_t n = static_cast<std::size_t>(n_species) * static_cast<std::size_t>(points());
  std::ofstream file(final, std::ios::binary);
  file.write(reinterpret_cast<const char*>(u), static_cast<std::streamsize>(n * sizeof(double)));
  if (!file) throw std::runtime_error("cannot write " + final);
}

Problem::Problem(const Setup& s, int n_species)
    : m_(n_species),
      n_(s.points()),
      n_x_(s.n_x),
      n_y_(s.n_y),
      periodic_x_(s.periodic_x),
      periodic_y_(s.periodic_y),
      lower_x_(s.lower_x),
      dx_((s.upper_x - s.lower_x) / (s.n_x - (s.periodic_x ? 0 : 1))),
      lower_y_(s.n_y > 1 ? s.lower_y : 0.0),
      dy_(s.n_y > 1 ? (s.upper_y - s.lower_y) / (s.n_y - (s.periodic_y ? 0 : 1)) : 1.0) {
  if (static_cast<int>(s.diffusion.size()) != m_) throw std::runtime_error("diffusion needs a number for each species");
  for (double d : s.diffusion) {
    k_x_.push_back(d / (dx_ * dx_));
    k_y_.push_back(n_y_ > 1 ? d / (dy_ * dy_) : 0.0);
  }
}

void Problem::add_diffusion(const double* u, double* f) const {
  for (int s = 0; s < m_; ++s) {
    const double kx = k_x(s), ky = k_y(s), centre = 2.0 * (kx + ky);
    if (centre == 0.0) continue;
    const double* plane = u + static_cast<std::ptrdiff_t>(s) * n_;
    double* out_plane = f + static_cast<std::ptrdiff_t>(s) * n_;
    for (int j = 0; j < n_y_; ++j) {
      const std::ptrdiff_t row = n_x_;
      const double* c = plane + j * row;
      const double* d = n_y_ == 1 ? c : (j > 0 ? c - row : (periodic_y_ ? c + row * (n_y_ - 1) : c + row));
      const double* e = n_y_ == 1 ? c : (j < n_y_ - 1 ? c + row : (periodic_y_ ? c - row * (n_y_ - 1) : c - row));
      double* o = out_plane + j * row;
      const int last = n_x_ - 1;
      o[0] += kx * (c[1] + (periodic_x_ ? c[last] : c[1])) - centre * c[0] + ky * (d[0] + e[0]);
      o[last] += kx * (c[last - 1] + (periodic_x_ ? c[0] : c[last - 1])) - centre * c[last] + ky * (d[last] + e[last]);
#pragma GCC ivdep
      for (int i = 1; i < last; ++i) o[i] += kx * (c[i - 1] + c[i + 1]) - centre * c[i] + ky * (d[i] + e[i]);
    }
  }
}

void interleave(int n_species, int points, const double* planar, double* interleaved) {
  for (std::ptrdiff_t k = 0; k < points; ++k) {
    for (int s = 0; s < n_species; ++s) interleaved[k * n_species + s] = planar[static_cast<std::ptrdiff_t>(s) * points + k];
  }
}

void separate(int n_species, int points, const double* interleaved, double* planar) {
  for (std::ptrdiff_t k = 0; k < points; ++k) {
    for (int s = 0; s < n_species; ++s) planar[static_cast<std::ptrdiff_t>(s) * points + k] = interleaved[k * n_species + s];
  }
}

}  // namespace peers
