// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/mpi.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "stiffront/core/error.hpp"
#include "stiffront/core/timer.hpp"

namespace stiffront {

void check_mpi(int status, const char* call) {
  if (status == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING];
  int length = 0;
  MPI_Error_string(status, text, &length);
  throw Error(ErrorKind::mpi, fmt::format("{}: {}", call, std::string(text, static_cast<std::size_t>(length))));
}

namespace {

/// An agreement travels as an array of units that describe themselves, since a reduction may be cut anywhere between them.
struct Unit {
  enum Kind : std::int64_t { sum, maxima };
  static constexpr int maxima_per_unit = 8;

  std::int64_t kind;
  union {
    ReproducibleSum::Wire sum_;
    double maxima_[maxima_per_unit];
  };
  std::uint64_t flags;
};

void combine(void* in, void* inout, int* count, MPI_Datatype*) {
  const auto* a = static_cast<const Unit*>(in);
  auto* b = static_cast<Unit*>(inout);
  for (int n = 0; n < *count; ++n) {
    if (a[n].kind == Unit::sum) {
      ReproducibleSum s = ReproducibleSum::from_wire(a[n].sum_);
      s.merge(ReproducibleSum::from_wire(b[n].sum_));
      b[n].sum_ = s.wire();
    } else {
      for (int i = 0; i < Unit::maxima_per_unit; ++i) {
        if (a[n].maxima_[i] > b[n].maxima_[i]) b[n].maxima_[i] = a[n].maxima_[i];
      }
    }
    b[n].flags |= a[n].flags;
  }
}

void to_units(const Agreement& a, std::vector<Unit>& units) {
  units.clear();
  for (const ReproducibleSum& s : a.sums) {
    Unit u{};
    u.kind = Unit::sum;
    u.sum_ = s.wire();
    units.push_back(u);
  }
  for (std::size_t i = 0; i < a.maxima.size() || units.empty(); i += Unit::maxima_per_unit) {
    Unit u{};
    u.kind = Unit::maxima;
    for (std::size_t k = 0; k < Unit::maxima_per_unit; ++k) u.maxima_[k] = 0.0;
    for (std::size_t k = 0; k < Unit::maxima_per_unit && i + k < a.maxima.size(); ++k) {
      u.maxima_[k] = std::isnan(a.maxima[i + k]) ? std::numeric_limits<double>::infinity() : a.maxima[i + k];
    }
    units.push_back(u);
  }
  units[0].flags = a.flags;
}

void from_units(const std::vector<Unit>& units, Agreement& a) {
  std::size_t n = 0;
  for (ReproducibleSum& s : a.sums) s = ReproducibleSum::from_wire(units[n++].sum_);
  for (std::size_t i = 0; i < a.maxima.size(); ++i) a.maxima[i] = units[n + i / Unit::maxima_per_unit].maxima_[i % Unit::maxima_per_unit];
  a.flags = units[0].flags;
}

/// The datatype and operation of an agreement, made at first use.
struct AgreementOperation {
  MPI_Datatype type = MPI_DATATYPE_NULL;
  MPI_Op op = MPI_OP_NULL;

  static AgreementOperation& instance() {
    static AgreementOperation it;
    return it;
  }

  void ensure() {
    if (op != MPI_OP_NULL) return;
    check_mpi(MPI_Type_contiguous(static_cast<int>(sizeof(Unit)), MPI_BYTE, &type), "MPI_Type_contiguous");
    check_mpi(MPI_Type_commit(&type), "MPI_Type_commit");
    check_mpi(MPI_Op_create(&combine, 1, &op), "MPI_Op_create");
    // MPI_Finalize first deletes the attributes of MPI_COMM_SELF (MPI 3.1, section 8.7.1): the place to free both.
    int key = MPI_KEYVAL_INVALID;
    check_mpi(MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, &AgreementOperation::free, &key, nullptr),
              "MPI_Comm_create_keyval");
    check_mpi(MPI_Comm_set_attr(MPI_COMM_SELF, key, this), "MPI_Comm_set_attr");
    check_mpi(MPI_Comm_free_keyval(&key), "MPI_Comm_free_keyval");
  }

  static int free(MPI_Comm, int, void* attribute, void*) {
    auto* self = static_cast<AgreementOperation*>(attribute);
    MPI_Op_free(&self->op);
    MPI_Type_free(&self->type);
    return MPI_SUCCESS;
  }
};

template <class T>
T all_reduce(T x, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  T result = x;
  check_mpi(MPI_Allreduce(&x, &result, 1, type, op, comm), "MPI_Allreduce");
  return result;
}

}  // namespace

Communicator::Communicator(MPI_Comm comm) {
  check_mpi(MPI_Comm_dup(comm, &comm_), "MPI_Comm_dup");
  measure();
}

Communicator Communicator::split(int colour) const {
  Communicator part;
  check_mpi(MPI_Comm_split(comm_, colour, rank_, &part.comm_), "MPI_Comm_split");
  part.measure();
  return part;
}

void Communicator::measure() {
  MPI_Comm_set_errhandler(comm_, MPI_ERRORS_RETURN);
  check_mpi(MPI_Comm_rank(comm_, &rank_), "MPI_Comm_rank");
  check_mpi(MPI_Comm_size(comm_, &size_), "MPI_Comm_size");
}

Communicator::Communicator(Communicator&& other) noexcept
    : comm_(std::exchange(other.comm_, MPI_COMM_NULL)), rank_(other.rank_), size_(other.size_), traffic_(other.traffic_) {}

Communicator& Communicator::operator=(Communicator&& other) noexcept {
  std::swap(comm_, other.comm_);
  rank_ = other.rank_;
  size_ = other.size_;
  traffic_ = other.traffic_;
  return *this;
}

Communicator::~Communicator() {
  if (comm_ == MPI_COMM_NULL) return;
  // A run that ends by an exception may outlive MPI_Finalize.
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (!finalized) MPI_Comm_free(&comm_);
}

void Communicator::agree(Agreement& a) const {
  ++traffic_.reductions;
  if (size_ == 1) {
    for (double& m : a.maxima) m = std::isnan(m) ? std::numeric_limits<double>::infinity() : m;
    return;
  }
  const ScopedTimer reducing(traffic_.seconds_waiting);
  AgreementOperation& operation = AgreementOperation::instance();
  operation.ensure();
  // Kept from one agreement to the next: every step has one, and takes no memory for it.
  static std::vector<Unit> mine;
  static std::vector<Unit> agreed;
  to_units(a, mine);
  agreed.resize(mine.size());
  check_mpi(MPI_Allreduce(mine.data(), agreed.data(), static_cast<int>(mine.size()), operation.type, operation.op, comm_),
            "MPI_Allreduce");
  from_units(agreed, a);
}

double Communicator::max(double x) const {
  ++traffic_.reductions;
  return all_reduce(x, MPI_DOUBLE, MPI_MAX, comm_);
}

std::int64_t Communicator::max(std::int64_t x) const {
  ++traffic_.reductions;
  return all_reduce(x, MPI_INT64_T, MPI_MAX, comm_);
}

std::int64_t Communicator::sum(std::int64_t x) const {
  ++traffic_.reductions;
  return all_reduce(x, MPI_INT64_T, MPI_SUM, comm_);
}

void Communicator::barrier() const { check_mpi(MPI_Barrier(comm_), "MPI_Barrier"); }

std::string Communicator::broadcast(const std::string& text, int root) const {
  std::int64_t length = static_cast<std::int64_t>(text.size());
  check_mpi(MPI_Bcast(&length, 1, MPI_INT64_T, root, comm_), "MPI_Bcast");
  std::string result = rank_ == root ? text : std::string(static_cast<std::size_t>(length), '\0');
  check_mpi(MPI_Bcast(result.data(), static_cast<int>(length), MPI_CHAR, root, comm_), "MPI_Bcast");
  return result;
}

}  // namespace stiffront
