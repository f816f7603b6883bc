// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/sundials_vector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "stiffront/core/reproducible_sum.hpp"

namespace stiffront {
namespace {

struct Content {
  const Communicator* comm;
  std::int64_t global_length;
  std::vector<double> values;
};

Content& content(N_Vector v) { return *static_cast<Content*>(v->content); }
std::vector<double>& values(N_Vector v) { return content(v).values; }

template <class F>
void map(N_Vector z, F f) {
  std::vector<double>& out = values(z);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = f(i);
}

template <class F>
double reproducible(N_Vector v, F term) {
  Agreement a(1, 0);
  const std::size_t n = values(v).size();
  std::size_t i = 0;
  for (; i + pack_size <= n; i += pack_size) {
    Pack p;
    for (int l = 0; l < pack_size; ++l) p.set(l, term(i + static_cast<std::size_t>(l)));
    a.sums[0].add(p);
  }
  for (; i < n; ++i) a.sums[0].add(term(i));
  content(v).comm->agree(a);
  return a.sums[0].value();
}

N_Vector clone(N_Vector w);

void destroy(N_Vector v) {
  delete static_cast<Content*>(v->content);
  v->content = nullptr;
  N_VFreeEmpty(v);
}

realtype* array(N_Vector v) { return values(v).data(); }
sunindextype length(N_Vector v) { return content(v).global_length; }
N_Vector_ID parallel_id(N_Vector) { return SUNDIALS_NVEC_CUSTOM; }
N_Vector_ID serial_id(N_Vector) { return SUNDIALS_NVEC_SERIAL; }

void space(N_Vector v, sunindextype* reals, sunindextype* integers) {
  *reals = static_cast<sunindextype>(values(v).size());
  *integers = 2;
}

void linear_sum(realtype a, N_Vector x, realtype b, N_Vector y, N_Vector z) {
  const double* p = array(x);
  const double* q = array(y);
  map(z, [=](std::size_t i) { return a * p[i] + b * q[i]; });
}
void constant(realtype c, N_Vector z) { std::fill(values(z).begin(), values(z).end(), c); }
void product(N_Vector x, N_Vector y, N_Vector z) {
  map(z, [p = array(x), q = array(y)](std::size_t i) { return p[i] * q[i]; });
}
void quotient(N_Vector x, N_Vector y, N_Vector z) {
  map(z, [p = array(x), q = array(y)](std::size_t i) { return p[i] / q[i]; });
}
void scale(realtype c, N_Vector x, N_Vector z) {
  map(z, [c, p = array(x)](std::size_t i) { return c * p[i]; });
}
void absolute(N_Vector x, N_Vector z) {
  map(z, [p = array(x)](std::size_t i) { return std::abs(p[i]); });
}
void inverse(N_Vector x, N_Vector z) {
  map(z, [p = array(x)](std::size_t i) { return 1.0 / p[i]; });
}
void add_constant(N_Vector x, realtype b, N_Vector z) {
  map(z, [b, p = array(x)](std::size_t i) { return p[i] + b; });
}
realtype dot(N_Vector x, N_Vector y) {
  return reproducible(x, [p = array(x), q = array(y)](std::size_t i) { return p[i] * q[i]; });
}
realtype max_norm(N_Vector x) {
  double m = 0.0;
  for (double v : values(x)) m = std::max(m, std::abs(v));
  return content(x).comm->max(m);
}
realtype wrms_norm(N_Vector x, N_Vector w) {
  const double sum = reproducible(x, [p = array(x), q = array(w)](std::size_t i) {
    const double r = p[i] * q[i];
    return r * r;
  });
  return std::sqrt(sum / static_cast<double>(content(x).global_length));
}
realtype minimum(N_Vector x) {
  double m = std::numeric_limits<double>::max();
  for (double v : values(x)) m = std::min(m, v);
  return -content(x).comm->max(-m);
}

N_Vector make(SUNContext context, const Communicator& comm, std::size_t n, std::int64_t global_length) {
  N_Vector v = N_VNewEmpty(context);
  v->content = new Content{&comm, global_length, std::vector<double>(n, 0.0)};
  N_Vector_Ops ops = v->ops;
  ops->nvgetvectorid = comm.size() == 1 ? serial_id : parallel_id;
  ops->nvclone = clone;
  ops->nvcloneempty = clone;
  ops->nvdestroy = destroy;
  ops->nvspace = space;
  ops->nvgetarraypointer = array;
  ops->nvgetlength = length;
  ops->nvlinearsum = linear_sum;
  ops->nvconst = constant;
  ops->nvprod = product;
  ops->nvdiv = quotient;
  ops->nvscale = scale;
  ops->nvabs = absolute;
  ops->nvinv = inverse;
  ops->nvaddconst = add_constant;
  ops->nvdotprod = dot;
  ops->nvmaxnorm = max_norm;
  ops->nvwrmsnorm = wrms_norm;
  ops->nvmin = minimum;
  return v;
}

N_Vector clone(N_Vector w) { return make(w->sunctx, *content(w).comm, values(w).size(), content(w).global_length); }

}  // namespace

N_Vector make_sundials_vector(const Communicator& comm, std::int64_t length, std::int64_t global_length, SUNContext context) {
  return make(context, comm, static_cast<std::size_t>(length), global_length);
}

}  // namespace stiffront
