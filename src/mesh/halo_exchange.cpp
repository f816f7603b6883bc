// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/mesh/halo_exchange.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "stiffront/core/error.hpp"
#include "stiffront/core/timer.hpp"

namespace stiffront {
namespace {

/// What is copied into a halo must lie in the box next to it, and what is mirrored or extrapolated beyond a side within reach of it.
void check_width(const Decomposition& d, const Boundary& boundary, int width, int stencil) {
  for (int direction = 0; direction < d.grid().dimension; ++direction) {
    const auto k = static_cast<std::size_t>(direction);
    const std::int64_t points = d.grid().points[k];
    const int processes = d.processes()[k];
    std::int64_t least = processes > 1 || d.grid().periodic[k] ? width : stencil;
    for (int which = 0; which < 2 && processes == 1; ++which) {
      const BoundaryKind kind = boundary.side(direction, which).kind;
      if (kind == BoundaryKind::neumann) least = std::max<std::int64_t>(least, stencil + 1);
      if (kind == BoundaryKind::dirichlet && stencil > 1) least = std::max<std::int64_t>(least, 4);
    }
    if (points / processes >= least) continue;
    throw Error(ErrorKind::input, fmt::format("grid.points: {} points along {} on {} {} are too few, at least {} each are needed", points,
                                              direction == 0 ? "x" : "y", processes, processes == 1 ? "rank" : "ranks", least));
  }
}

}  // namespace

HaloExchange::HaloExchange(const Decomposition& decomposition, const Boundary& boundary, int n_species, int n_fields, int width,
                           std::vector<int> species, bool corners)
    : decomposition_(&decomposition),
      boundary_(&boundary),
      widths_(static_cast<std::size_t>(n_fields), width),
      stencil_(width),
      species_(std::move(species)) {
  make_links(n_species, corners);
}

HaloExchange::HaloExchange(const Decomposition& decomposition, const Boundary& boundary, int n_species, std::vector<int> widths,
                           int stencil, std::vector<int> species)
    : decomposition_(&decomposition), boundary_(&boundary), widths_(std::move(widths)), stencil_(stencil), species_(std::move(species)) {
  make_links(n_species, true);
}

HaloExchange::Strip HaloExchange::strip(const Link& link, int width) const {
  Strip s{};
  const auto along = [width](int offset, int n, int& send, int& recv, int& length) {
    send = offset > 0 ? n - width : 0;
    recv = offset < 0 ? -width : (offset > 0 ? n : 0);
    length = offset == 0 ? n : width;
  };
  along(link.dx, decomposition_->n_x(), s.send_i, s.recv_i, s.n_i);
  along(link.dy, decomposition_->n_y(), s.send_j, s.recv_j, s.n_j);
  return s;
}

namespace {

/// Names the direction a message travels in, so that two neighbours that are one rank stay apart.
int direction(int dx, int dy) { return 3 * (dy + 1) + dx + 1; }

}  // namespace

void HaloExchange::make_links(int n_species, bool corners) {
  if (species_.empty()) {
    species_.resize(static_cast<std::size_t>(n_species));
    std::iota(species_.begin(), species_.end(), 0);
  }
  const Decomposition& d = *decomposition_;
  check_width(d, *boundary_, *std::max_element(widths_.begin(), widths_.end()), stencil_);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (dx == 0 && dy == 0) continue;
      if (d.grid().dimension == 1 && dy != 0) continue;
      if (dx != 0 && dy != 0 && !corners) continue;
      const int rank = d.neighbour(dx, dy);
      if (rank == MPI_PROC_NULL) continue;
      Link link{.dx = dx, .dy = dy, .rank = rank, .size = 0};
      for (int width : widths_) {
        const Strip s = strip(link, width);
        link.size += static_cast<std::size_t>(s.n_i) * static_cast<std::size_t>(s.n_j) * species_.size();
      }
      if (rank != d.comm().rank()) {
        ++sent_per_exchange_;
        bytes_per_exchange_ += static_cast<std::int64_t>(link.size * sizeof(double));
      }
      links_.push_back(std::move(link));
    }
  }
  share_memory();
  open_requests();
}

/// A piece begins with where the parts for each direction are; such a part is a turn and two buffers.
void HaloExchange::share_memory() {
  const Communicator& comm = decomposition_->comm();
  const auto is_shared = [&](const Link& link) { return link.rank != comm.rank() && comm.node_rank(link.rank) >= 0; };
  struct Directory {
    std::array<std::uint64_t, 9> of_direction;
  };
  constexpr std::size_t line = alignof(Turn);
  const auto whole_lines = [](std::size_t bytes) { return (bytes + line - 1) / line * line; };
  const auto buffer_bytes = [&](const Link& link) { return whole_lines(link.size * sizeof(double)); };
  std::size_t end = whole_lines(sizeof(Directory));
  std::vector<std::size_t> places;
  for (const Link& link : links_) {
    places.push_back(end);
    if (is_shared(link)) end += sizeof(Turn) + 2 * buffer_bytes(link);
  }
  memory_ = comm.share(end);
  if (!memory_) return;
  std::byte* const mine = memory_.of(comm.node_rank(comm.rank()));
  for (std::size_t k = 0; k < links_.size(); ++k) {
    Link& link = links_[k];
    if (!is_shared(link)) continue;
    reinterpret_cast<Directory*>(mine)->of_direction[static_cast<std::size_t>(direction(link.dx, link.dy))] = places[k];
    std::byte* const at = mine + places[k];
    link.sent = reinterpret_cast<Turn*>(at);
    for (std::size_t b = 0; b < 2; ++b) link.out[b] = reinterpret_cast<double*>(at + sizeof(Turn) + b * buffer_bytes(link));
  }
  comm.barrier();  // directories are written
  for (Link& link : links_) {
    if (!is_shared(link)) continue;
    const std::byte* const theirs = memory_.of(comm.node_rank(link.rank));
    const std::byte* const at =
        theirs + reinterpret_cast<const Directory*>(theirs)->of_direction[static_cast<std::size_t>(direction(-link.dx, -link.dy))];
    link.received = reinterpret_cast<const Turn*>(at);
    for (std::size_t b = 0; b < 2; ++b) link.in[b] = reinterpret_cast<const double*>(at + sizeof(Turn) + b * buffer_bytes(link));
  }
}

void HaloExchange::open_requests() {
  const Communicator& comm = decomposition_->comm();
  for (Link& link : links_) {
    if (link.sent != nullptr) continue;
    link.send.resize(link.size);
    if (link.rank == comm.rank()) continue;
    link.recv.resize(link.size);
    const auto size = static_cast<int>(link.size);
    MPI_Request request = MPI_REQUEST_NULL;
    check_mpi(MPI_Recv_init(link.recv.data(), size, MPI_DOUBLE, link.rank, direction(-link.dx, -link.dy), comm.get(), &request),
              "MPI_Recv_init");
    requests_.push_back(request);
    check_mpi(MPI_Send_init(link.send.data(), size, MPI_DOUBLE, link.rank, direction(link.dx, link.dy), comm.get(), &request),
              "MPI_Send_init");
    requests_.push_back(request);
  }
}

HaloExchange::~HaloExchange() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (finalized) return;
  for (MPI_Request& request : requests_) MPI_Request_free(&request);
}

void HaloExchange::pack(const Link& link, double* out) const {
  for (std::size_t k = 0; k < open_.size(); ++k) {
    const Strip strip_of_field = strip(link, widths_[k]);
    const auto& [send_i, send_j, recv_i, recv_j, n_i, n_j] = strip_of_field;
    for (int s : species_) {
      for (int j = 0; j < n_j; ++j) {
        std::memcpy(out, open_[k]->row(s, send_j + j) + send_i, static_cast<std::size_t>(n_i) * sizeof(double));
        out += n_i;
      }
    }
  }
}

void HaloExchange::unpack(const double* in, const Link& link) const {
  for (std::size_t k = 0; k < open_.size(); ++k) {
    const Strip strip_of_field = strip(link, widths_[k]);
    const auto& [send_i, send_j, recv_i, recv_j, n_i, n_j] = strip_of_field;
    for (int s : species_) {
      for (int j = 0; j < n_j; ++j) {
        std::memcpy(open_[k]->row(s, recv_j + j) + recv_i, in, static_cast<std::size_t>(n_i) * sizeof(double));
        in += n_i;
      }
    }
  }
}

void HaloExchange::begin(std::span<Field* const> fields) {
  if (!open_.empty()) throw Error(ErrorKind::bug, "halo exchange begun while the previous one is open");
  if (fields.size() != widths_.size()) throw Error(ErrorKind::bug, "halo exchange of another number of fields than it was made for");
  for (std::size_t k = 0; k < fields.size(); ++k) {
    if (fields[k]->halo() < widths_[k]) throw Error(ErrorKind::bug, "halo exchange wider than a field's halo");
  }
  open_.assign(fields.begin(), fields.end());
  // There are two buffers to each neighbour, used in turn: who packs one again has the neighbour's halo of the exchange between, which
  // it sent when it was done with this one.
  const auto turn = static_cast<std::uint64_t>(++count_);
  for (Link& link : links_) {
    pack(link, link.sent != nullptr ? link.out[turn % 2] : link.send.data());
    if (link.sent != nullptr) link.sent->announce(turn);
  }
  if (!requests_.empty()) check_mpi(MPI_Startall(static_cast<int>(requests_.size()), requests_.data()), "MPI_Startall");
  bytes_sent_ += bytes_per_exchange_;
  decomposition_->comm().count_halo(sent_per_exchange_, bytes_per_exchange_);
}

void HaloExchange::finish() {
  const Communicator& comm = decomposition_->comm();
  const auto turn = static_cast<std::uint64_t>(count_);
  for (const Link& link : links_) {
    if (link.received == nullptr) continue;
    comm.count_waiting(memory_.wait_for(*link.received, turn, comm.get()));
    unpack(link.in[turn % 2], link);
  }
  if (!requests_.empty()) {
    const double began = wall_seconds();
    check_mpi(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
    comm.count_waiting(wall_seconds() - began);
  }
  for (const Link& link : links_) {
    if (link.received != nullptr) continue;
    if (link.rank != comm.rank()) {
      unpack(link.recv.data(), link);
      continue;
    }
    // Both sides of a periodic direction are this box: what leaves through the opposite side comes in here.
    for (const Link& opposite : links_) {
      if (opposite.dx == -link.dx && opposite.dy == -link.dy) unpack(opposite.send.data(), link);
    }
  }
  for (std::size_t k = 0; k < open_.size(); ++k) boundary_->fill_halo(*open_[k], stencil_, species_, widths_[k]);
  open_.clear();
}

}  // namespace stiffront
