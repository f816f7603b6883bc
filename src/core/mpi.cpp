// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/mpi.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "stiffront/core/error.hpp"

namespace stiffront {

void check_mpi(int status, const char* call) {
  if (status == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING];
  int length = 0;
  MPI_Error_string(status, text, &length);
  throw Error(ErrorKind::mpi, fmt::format("{}: {}", call, std::string(text, static_cast<std::size_t>(length))));
}

namespace {

/// An Agreement as it travels: trivially copyable, reduced by one commutative operation.
struct WireAgreement {
  ReproducibleSum::Wire sums[Agreement::max_sums];
  double maxima[Agreement::max_maxima];
  std::uint64_t flags;
};

void combine(void* in, void* inout, int* count, MPI_Datatype*) {
  const auto* a = static_cast<const WireAgreement*>(in);
  auto* b = static_cast<WireAgreement*>(inout);
  for (int n = 0; n < *count; ++n) {
    for (int i = 0; i < Agreement::max_sums; ++i) {
      ReproducibleSum s = ReproducibleSum::from_wire(a[n].sums[i]);
      s.merge(ReproducibleSum::from_wire(b[n].sums[i]));
      b[n].sums[i] = s.wire();
    }
    for (int i = 0; i < Agreement::max_maxima; ++i) {
      if (a[n].maxima[i] > b[n].maxima[i]) b[n].maxima[i] = a[n].maxima[i];
    }
    b[n].flags |= a[n].flags;
  }
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
    check_mpi(MPI_Type_contiguous(static_cast<int>(sizeof(WireAgreement)), MPI_BYTE, &type), "MPI_Type_contiguous");
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
  MPI_Comm_set_errhandler(comm_, MPI_ERRORS_RETURN);
  check_mpi(MPI_Comm_rank(comm_, &rank_), "MPI_Comm_rank");
  check_mpi(MPI_Comm_size(comm_, &size_), "MPI_Comm_size");
}

Communicator::Communicator(Communicator&& other) noexcept
    : comm_(std::exchange(other.comm_, MPI_COMM_NULL)), rank_(other.rank_), size_(other.size_), reductions_(other.reductions_) {}

Communicator& Communicator::operator=(Communicator&& other) noexcept {
  std::swap(comm_, other.comm_);
  rank_ = other.rank_;
  size_ = other.size_;
  reductions_ = other.reductions_;
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
  ++reductions_;
  WireAgreement mine{};
  for (int i = 0; i < Agreement::max_sums; ++i) mine.sums[i] = a.sums[i].wire();
  for (int i = 0; i < Agreement::max_maxima; ++i) {
    mine.maxima[i] = std::isnan(a.maxima[i]) ? std::numeric_limits<double>::infinity() : a.maxima[i];
  }
  mine.flags = a.flags;
  WireAgreement agreed = mine;
  if (size_ > 1) {
    AgreementOperation& operation = AgreementOperation::instance();
    operation.ensure();
    check_mpi(MPI_Allreduce(&mine, &agreed, 1, operation.type, operation.op, comm_), "MPI_Allreduce");
  }
  for (int i = 0; i < Agreement::max_sums; ++i) a.sums[i] = ReproducibleSum::from_wire(agreed.sums[i]);
  for (int i = 0; i < Agreement::max_maxima; ++i) a.maxima[i] = agreed.maxima[i];
  a.flags = agreed.flags;
}

double Communicator::max(double x) const {
  ++reductions_;
  return all_reduce(x, MPI_DOUBLE, MPI_MAX, comm_);
}

std::int64_t Communicator::max(std::int64_t x) const {
  ++reductions_;
  return all_reduce(x, MPI_INT64_T, MPI_MAX, comm_);
}

std::int64_t Communicator::sum(std::int64_t x) const {
  ++reductions_;
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
