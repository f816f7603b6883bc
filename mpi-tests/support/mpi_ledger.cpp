// SPDX-License-Identifier: BSD-3-Clause
// Stands between the program and the MPI library (MPI 3.1, section 14.2: every MPI_X may be replaced and calls PMPI_X).
#include "support/mpi_ledger.hpp"

#include <mpi.h>

#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <map>
#include <random>
#include <set>

namespace {

struct Ledger {
  std::set<MPI_Request> requests;
  std::set<MPI_Request> open;
  std::map<MPI_Comm, std::uint64_t> communicators;  ///< with a digest of the collective calls made on each
  std::set<MPI_Datatype> types;
  std::set<MPI_Op> operations;
  int stray_messages = 0;
  int unequal_collectives = 0;
};

/// Lives until the process ends: MPI_Finalize still frees through it.
Ledger& ledger() {
  static auto* it = new Ledger;
  return *it;
}

enum Call : std::uint64_t {
  allreduce = 1,
  bcast,
  barrier,
  reduce,
  gather,
  gatherv,
  allgather,
  allgatherv,
  scan,
  exscan,
  dup,
  split,
  iallgather
};

/// With STIFFRONT_DELAY_SEED set, up to two milliseconds before a call, different on every rank: what only works if ranks arrive together
/// shows.
void delay() {
  static const char* seed = std::getenv("STIFFRONT_DELAY_SEED");
  if (seed == nullptr) return;
  static std::mt19937_64 random = [] {
    int rank = 0;
    PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return std::mt19937_64(std::strtoull(seed, nullptr, 10) * 1000 + static_cast<unsigned>(rank));
  }();
  if (random() % 4 != 0) return;
  const std::timespec moment{0, static_cast<long>(random() % 2000000)};
  nanosleep(&moment, nullptr);
}

void note(MPI_Comm comm, Call call, int count = 0, MPI_Datatype type = MPI_DATATYPE_NULL, int root = 0) {
  delay();
  const auto it = ledger().communicators.find(comm);
  if (it == ledger().communicators.end()) return;
  int size = 0;
  if (type != MPI_DATATYPE_NULL) PMPI_Type_size(type, &size);
  for (const std::uint64_t x : {static_cast<std::uint64_t>(call), static_cast<std::uint64_t>(count), static_cast<std::uint64_t>(size),
                                static_cast<std::uint64_t>(root)}) {
    it->second = (it->second ^ x) * 0x100000001b3U;  // FNV-1a over words
  }
}

void open(int status, MPI_Comm comm) {
  if (status == MPI_SUCCESS && comm != MPI_COMM_NULL) ledger().communicators[comm] = 0xcbf29ce484222325U;
}

}  // namespace

namespace stiffront::testing {

MpiFindings mpi_findings() {
  const Ledger& l = ledger();
  return {static_cast<int>(l.requests.size()),
          static_cast<int>(l.open.size()),
          static_cast<int>(l.communicators.size()),
          static_cast<int>(l.types.size()),
          static_cast<int>(l.operations.size()),
          l.stray_messages,
          l.unequal_collectives};
}

}  // namespace stiffront::testing

extern "C" {

int MPI_Send_init(const void* buffer, int count, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  const int status = PMPI_Send_init(buffer, count, type, to, tag, comm, request);
  if (status == MPI_SUCCESS) ledger().requests.insert(*request);
  return status;
}

int MPI_Recv_init(void* buffer, int count, MPI_Datatype type, int from, int tag, MPI_Comm comm, MPI_Request* request) {
  const int status = PMPI_Recv_init(buffer, count, type, from, tag, comm, request);
  if (status == MPI_SUCCESS) ledger().requests.insert(*request);
  return status;
}

int MPI_Isend(const void* buffer, int count, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  delay();
  const int status = PMPI_Isend(buffer, count, type, to, tag, comm, request);
  if (status == MPI_SUCCESS && to != MPI_PROC_NULL) ledger().open.insert(*request);
  return status;
}

int MPI_Irecv(void* buffer, int count, MPI_Datatype type, int from, int tag, MPI_Comm comm, MPI_Request* request) {
  const int status = PMPI_Irecv(buffer, count, type, from, tag, comm, request);
  if (status == MPI_SUCCESS && from != MPI_PROC_NULL) ledger().open.insert(*request);
  return status;
}

int MPI_Iallgather(const void* in, int n_in, MPI_Datatype t_in, void* out, int n_out, MPI_Datatype t_out, MPI_Comm comm,
                   MPI_Request* request) {
  note(comm, iallgather, n_in, t_in);
  const int status = PMPI_Iallgather(in, n_in, t_in, out, n_out, t_out, comm, request);
  if (status == MPI_SUCCESS) ledger().open.insert(*request);
  return status;
}

int MPI_Wait(MPI_Request* request, MPI_Status* result) {
  delay();
  ledger().open.erase(*request);
  return PMPI_Wait(request, result);
}

int MPI_Waitall(int count, MPI_Request* requests, MPI_Status* results) {
  delay();
  for (int n = 0; n < count; ++n) ledger().open.erase(requests[n]);
  return PMPI_Waitall(count, requests, results);
}

int MPI_Startall(int count, MPI_Request* requests) {
  delay();
  return PMPI_Startall(count, requests);
}

int MPI_Request_free(MPI_Request* request) {
  ledger().requests.erase(*request);
  return PMPI_Request_free(request);
}

int MPI_Comm_dup(MPI_Comm comm, MPI_Comm* copy) {
  note(comm, dup);
  const int status = PMPI_Comm_dup(comm, copy);
  open(status, *copy);
  return status;
}

int MPI_Comm_split(MPI_Comm comm, int colour, int key, MPI_Comm* part) {
  note(comm, split);
  const int status = PMPI_Comm_split(comm, colour, key, part);
  open(status, *part);
  return status;
}

int MPI_Comm_split_type(MPI_Comm comm, int type, int key, MPI_Info info, MPI_Comm* part) {
  note(comm, split);
  const int status = PMPI_Comm_split_type(comm, type, key, info, part);
  open(status, *part);
  return status;
}

int MPI_Comm_free(MPI_Comm* comm) {
  const auto it = ledger().communicators.find(*comm);
  if (it != ledger().communicators.end()) {
    std::uint64_t range[2] = {it->second, ~it->second};
    PMPI_Allreduce(MPI_IN_PLACE, range, 2, MPI_UINT64_T, MPI_MIN, *comm);
    if (range[0] != ~range[1]) ++ledger().unequal_collectives;
    int pending = 0;
    PMPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, *comm, &pending, MPI_STATUS_IGNORE);
    ledger().stray_messages += pending;
    ledger().communicators.erase(it);
  }
  return PMPI_Comm_free(comm);
}

int MPI_Type_commit(MPI_Datatype* type) {
  const int status = PMPI_Type_commit(type);
  if (status == MPI_SUCCESS) ledger().types.insert(*type);
  return status;
}

int MPI_Type_free(MPI_Datatype* type) {
  ledger().types.erase(*type);
  return PMPI_Type_free(type);
}

int MPI_Op_create(MPI_User_function* function, int commutes, MPI_Op* op) {
  const int status = PMPI_Op_create(function, commutes, op);
  if (status == MPI_SUCCESS) ledger().operations.insert(*op);
  return status;
}

int MPI_Op_free(MPI_Op* op) {
  ledger().operations.erase(*op);
  return PMPI_Op_free(op);
}

int MPI_Allreduce(const void* in, void* out, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  note(comm, allreduce, count, type);
  return PMPI_Allreduce(in, out, count, type, op, comm);
}

int MPI_Bcast(void* buffer, int count, MPI_Datatype type, int root, MPI_Comm comm) {
  note(comm, bcast, count, type, root);
  return PMPI_Bcast(buffer, count, type, root, comm);
}

int MPI_Barrier(MPI_Comm comm) {
  note(comm, barrier);
  return PMPI_Barrier(comm);
}

int MPI_Reduce(const void* in, void* out, int count, MPI_Datatype type, MPI_Op op, int root, MPI_Comm comm) {
  note(comm, reduce, count, type, root);
  return PMPI_Reduce(in, out, count, type, op, root, comm);
}

int MPI_Gather(const void* in, int n_in, MPI_Datatype t_in, void* out, int n_out, MPI_Datatype t_out, int root, MPI_Comm comm) {
  note(comm, gather, n_in, t_in, root);
  return PMPI_Gather(in, n_in, t_in, out, n_out, t_out, root, comm);
}

int MPI_Gatherv(const void* in, int n_in, MPI_Datatype t_in, void* out, const int* n_out, const int* at, MPI_Datatype t_out, int root,
                MPI_Comm comm) {
  note(comm, gatherv, 0, t_in, root);
  return PMPI_Gatherv(in, n_in, t_in, out, n_out, at, t_out, root, comm);
}

int MPI_Allgather(const void* in, int n_in, MPI_Datatype t_in, void* out, int n_out, MPI_Datatype t_out, MPI_Comm comm) {
  note(comm, allgather, n_in, t_in);
  return PMPI_Allgather(in, n_in, t_in, out, n_out, t_out, comm);
}

int MPI_Allgatherv(const void* in, int n_in, MPI_Datatype t_in, void* out, const int* n_out, const int* at, MPI_Datatype t_out,
                   MPI_Comm comm) {
  note(comm, allgatherv, 0, t_in);
  return PMPI_Allgatherv(in, n_in, t_in, out, n_out, at, t_out, comm);
}

int MPI_Scan(const void* in, void* out, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  note(comm, scan, count, type);
  return PMPI_Scan(in, out, count, type, op, comm);
}

int MPI_Exscan(const void* in, void* out, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  note(comm, exscan, count, type);
  return PMPI_Exscan(in, out, count, type, op, comm);
}

}  // extern "C"
