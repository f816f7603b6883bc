// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/mpi.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
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

void combine_units(const Unit* a, Unit* b, int count) {
  for (int n = 0; n < count; ++n) {
    if (a[n].kind == Unit::sum) {
      ReproducibleSum::merge(b[n].sum_, a[n].sum_);
    } else {
      for (int i = 0; i < Unit::maxima_per_unit; ++i) {
        if (a[n].maxima_[i] > b[n].maxima_[i]) b[n].maxima_[i] = a[n].maxima_[i];
      }
    }
    b[n].flags |= a[n].flags;
  }
}

void combine(void* in, void* inout, int* count, MPI_Datatype*) {
  combine_units(static_cast<const Unit*>(in), static_cast<Unit*>(inout), *count);
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
    check_mpi(MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, &AgreementOperation::free, &key, nullptr), "MPI_Comm_create_keyval");
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

/// Every rank writes its part where all can read it, and reads those of the others: one look at each instead of the rounds of a tree.
///
/// There are two places for the parts of a rank, used in turn: who writes to one again has seen all others in the agreement
/// between, for which they had to be done with this one.
class SharedAgreement {
 public:
  static constexpr std::size_t capacity = 16;

  /// @mpi collective
  explicit SharedAgreement(const Communicator& comm) : comm_(&comm), memory_(comm.share(sizeof(Part))) {}

  /// Whether agreements of so many units go this way; the same on all ranks.
  bool takes(std::size_t units) const { return memory_ && units <= capacity; }

  /// @return seconds waited
  double agree(const std::vector<Unit>& mine, std::vector<Unit>& agreed) {
    const std::uint64_t turn = ++turn_;
    const auto count = static_cast<int>(mine.size());
    Part& own = part(comm_->rank());
    std::copy(mine.begin(), mine.end(), own.units[turn % 2]);
    own.turn.announce(turn);
    agreed = mine;
    double waited = 0.0;
    for (int rank = 0; rank < comm_->size(); ++rank) {
      if (rank == comm_->rank()) continue;
      const Part& other = part(rank);
      waited += memory_.wait_for(other.turn, turn, comm_->get());
      combine_units(other.units[turn % 2], agreed.data(), count);
    }
    return waited;
  }

  void belongs_to(const Communicator& comm) { comm_ = &comm; }

 private:
  struct Part {
    Turn turn;
    Unit units[2][capacity];
  };
  Part& part(int rank) { return *reinterpret_cast<Part*>(memory_.of(comm_->node_rank(rank))); }

  const Communicator* comm_;
  NodeMemory memory_;
  std::uint64_t turn_ = 0;
};

Communicator::Communicator(int most_sharing) : most_sharing_(most_sharing) {}

Communicator::Communicator(MPI_Comm comm, int most_sharing) : most_sharing_(most_sharing) {
  check_mpi(MPI_Comm_dup(comm, &comm_), "MPI_Comm_dup");
  measure();
}

Communicator Communicator::split(int colour) const {
  Communicator part(most_sharing_);
  check_mpi(MPI_Comm_split(comm_, colour, rank_, &part.comm_), "MPI_Comm_split");
  part.measure();
  return part;
}

void Communicator::measure() {
  MPI_Comm_set_errhandler(comm_, MPI_ERRORS_RETURN);
  check_mpi(MPI_Comm_rank(comm_, &rank_), "MPI_Comm_rank");
  check_mpi(MPI_Comm_size(comm_, &size_), "MPI_Comm_size");
  node_ranks_.assign(static_cast<std::size_t>(size_), -1);
  if (size_ > 1) find_neighbours_in_node();
}

void Communicator::find_neighbours_in_node() {
  check_mpi(MPI_Comm_split_type(comm_, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &node_), "MPI_Comm_split_type");
  MPI_Comm_set_errhandler(node_, MPI_ERRORS_RETURN);
  int size = 0;
  check_mpi(MPI_Comm_size(node_, &size), "MPI_Comm_size");
  // Ranks that wait in turn for a processor do so without burning it; with many of them the waiting of MPI is as good.
  constexpr std::int64_t always = 8;
  const std::int64_t most = most_sharing_ >= 0 ? most_sharing_ : std::max<std::int64_t>(always, sysconf(_SC_NPROCESSORS_ONLN));
  if (size == 1 || size > most) {
    MPI_Comm_free(&node_);
    return;
  }
  MPI_Group all = MPI_GROUP_NULL;
  MPI_Group here = MPI_GROUP_NULL;
  check_mpi(MPI_Comm_group(comm_, &all), "MPI_Comm_group");
  check_mpi(MPI_Comm_group(node_, &here), "MPI_Comm_group");
  std::vector<int> numbers(static_cast<std::size_t>(size));
  std::iota(numbers.begin(), numbers.end(), 0);
  std::vector<int> ranks(numbers.size());
  check_mpi(MPI_Group_translate_ranks(here, size, numbers.data(), all, ranks.data()), "MPI_Group_translate_ranks");
  for (int k = 0; k < size; ++k) node_ranks_[static_cast<std::size_t>(ranks[static_cast<std::size_t>(k)])] = k;
  all_share_ = size == size_;
  MPI_Group_free(&all);
  MPI_Group_free(&here);
}

NodeMemory Communicator::share(std::size_t bytes) const { return node_ == MPI_COMM_NULL ? NodeMemory() : NodeMemory(node_, bytes); }

Communicator::Communicator(Communicator&& other) noexcept : most_sharing_(other.most_sharing_) { *this = std::move(other); }

Communicator& Communicator::operator=(Communicator&& other) noexcept {
  std::swap(comm_, other.comm_);
  std::swap(node_, other.node_);
  std::swap(node_ranks_, other.node_ranks_);
  std::swap(shared_agreement_, other.shared_agreement_);
  if (shared_agreement_) shared_agreement_->belongs_to(*this);
  if (other.shared_agreement_) other.shared_agreement_->belongs_to(other);
  rank_ = other.rank_;
  size_ = other.size_;
  most_sharing_ = other.most_sharing_;
  all_share_ = other.all_share_;
  traffic_ = other.traffic_;
  return *this;
}

Communicator::~Communicator() {
  if (comm_ == MPI_COMM_NULL) return;
  // A run that ends by an exception may outlive MPI_Finalize.
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (finalized) return;
  if (node_ != MPI_COMM_NULL) MPI_Comm_free(&node_);
  MPI_Comm_free(&comm_);
}

void Communicator::agree(Agreement& a) const {
  ++traffic_.reductions;
  if (size_ == 1) {
    for (double& m : a.maxima) m = std::isnan(m) ? std::numeric_limits<double>::infinity() : m;
    return;
  }
  // Kept from one agreement to the next: every step has one, and takes no memory for it.
  static std::vector<Unit> mine;
  static std::vector<Unit> agreed;
  to_units(a, mine);
  if (all_share_ && !shared_agreement_) shared_agreement_ = std::make_unique<SharedAgreement>(*this);
  if (shared_agreement_ && shared_agreement_->takes(mine.size())) {
    traffic_.seconds_waiting += shared_agreement_->agree(mine, agreed);
    from_units(agreed, a);
    return;
  }
  const ScopedTimer reducing(traffic_.seconds_waiting);
  AgreementOperation& operation = AgreementOperation::instance();
  operation.ensure();
  agreed.resize(mine.size());
  check_mpi(MPI_Allreduce(mine.data(), agreed.data(), static_cast<int>(mine.size()), operation.type, operation.op, comm_), "MPI_Allreduce");
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
