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
void check_width(const Decomposition& d, const Boundary& boundary, int width) {
  for (int direction = 0; direction < d.grid().dimension; ++direction) {
    const auto k = static_cast<std::size_t>(direction);
    const std::int64_t points = d.grid().points[k];
    const int processes = d.processes()[k];
    std::int64_t least = width;
    for (int which = 0; which < 2 && processes == 1; ++which) {
      const BoundaryKind kind = boundary.side(direction, which).kind;
      if (kind == BoundaryKind::neumann) least = std::max<std::int64_t>(least, width + 1);
      if (kind == BoundaryKind::dirichlet && width > 1) least = std::max<std::int64_t>(least, 4);
    }
    if (points / processes >= least) continue;
    throw Error(ErrorKind::input,
                fmt::format("grid.points: {} points along {} on {} {} are too few, at least {} each are needed", points,
                            direction == 0 ? "x" : "y", processes, processes == 1 ? "rank" : "ranks", least));
  }
}

}  // namespace

HaloExchange::HaloExchange(const Decomposition& decomposition, const Boundary& boundary, int n_species, int n_fields, int width,
                           std::vector<int> species, bool corners)
    : decomposition_(&decomposition),
      boundary_(&boundary),
      width_(width),
      species_(std::move(species)),
      n_fields_(static_cast<std::size_t>(n_fields)) {
  if (species_.empty()) {
    species_.resize(static_cast<std::size_t>(n_species));
    std::iota(species_.begin(), species_.end(), 0);
  }
  const Decomposition& d = decomposition;
  check_width(d, boundary, width);
  // First send, first receive and length of a strip along one direction for an offset of -1, 0 or 1.
  const auto strip = [width](int offset, int n, int& send, int& recv, int& length) {
    send = offset > 0 ? n - width : 0;
    recv = offset < 0 ? -width : (offset > 0 ? n : 0);
    length = offset == 0 ? n : width;
  };
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (dx == 0 && dy == 0) continue;
      if (d.grid().dimension == 1 && dy != 0) continue;
      if (dx != 0 && dy != 0 && !corners) continue;
      const int rank = d.neighbour(dx, dy);
      if (rank == MPI_PROC_NULL) continue;
      Link link{};
      link.dx = dx;
      link.dy = dy;
      link.rank = rank;
      strip(dx, d.n_x(), link.send_i, link.recv_i, link.n_i);
      strip(dy, d.n_y(), link.send_j, link.recv_j, link.n_j);
      const auto size = static_cast<std::size_t>(link.n_i) * static_cast<std::size_t>(link.n_j) * species_.size() * n_fields_;
      link.send.resize(size);
      if (rank != d.comm().rank()) link.recv.resize(size);
      links_.push_back(std::move(link));
    }
  }
  // A message is tagged by the direction it travels in, so that two neighbours that are one rank stay apart.
  const auto tag = [](int dx, int dy) { return 3 * (dy + 1) + dx + 1; };
  for (Link& link : links_) {
    if (link.rank == d.comm().rank()) continue;
    MPI_Request request = MPI_REQUEST_NULL;
    check_mpi(MPI_Recv_init(link.recv.data(), static_cast<int>(link.recv.size()), MPI_DOUBLE, link.rank, tag(-link.dx, -link.dy),
                            d.comm().get(), &request),
              "MPI_Recv_init");
    requests_.push_back(request);
    check_mpi(MPI_Send_init(link.send.data(), static_cast<int>(link.send.size()), MPI_DOUBLE, link.rank, tag(link.dx, link.dy),
                            d.comm().get(), &request),
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

void HaloExchange::pack(Link& link) const {
  double* out = link.send.data();
  for (const Field* field : open_) {
    for (int s : species_) {
      for (int j = 0; j < link.n_j; ++j) {
        std::memcpy(out, field->row(s, link.send_j + j) + link.send_i, static_cast<std::size_t>(link.n_i) * sizeof(double));
        out += link.n_i;
      }
    }
  }
}

void HaloExchange::unpack(const std::vector<double>& buffer, const Link& link) const {
  const double* in = buffer.data();
  for (Field* field : open_) {
    for (int s : species_) {
      for (int j = 0; j < link.n_j; ++j) {
        std::memcpy(field->row(s, link.recv_j + j) + link.recv_i, in, static_cast<std::size_t>(link.n_i) * sizeof(double));
        in += link.n_i;
      }
    }
  }
}

void HaloExchange::begin(std::span<Field* const> fields) {
  if (!open_.empty()) throw Error(ErrorKind::bug, "halo exchange begun while the previous one is open");
  if (fields.size() != n_fields_) throw Error(ErrorKind::bug, "halo exchange of another number of fields than it was made for");
  for (const Field* field : fields) {
    if (field->halo() < width_) throw Error(ErrorKind::bug, "halo exchange wider than a field's halo");
  }
  open_.assign(fields.begin(), fields.end());
  for (Link& link : links_) {
    pack(link);
    if (link.rank != decomposition_->comm().rank()) bytes_sent_ += static_cast<std::int64_t>(link.send.size() * sizeof(double));
  }
  if (!requests_.empty()) check_mpi(MPI_Startall(static_cast<int>(requests_.size()), requests_.data()), "MPI_Startall");
  ++count_;
}

void HaloExchange::finish() {
  if (!requests_.empty()) {
    const ScopedTimer waiting(seconds_waited_);
    check_mpi(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
  }
  for (const Link& link : links_) {
    if (link.rank != decomposition_->comm().rank()) {
      unpack(link.recv, link);
      continue;
    }
    // Both sides of a periodic direction are this box: what leaves through the opposite side comes in here.
    for (const Link& opposite : links_) {
      if (opposite.dx == -link.dx && opposite.dy == -link.dy) unpack(opposite.send, link);
    }
  }
  for (Field* field : open_) boundary_->fill_halo(*field, width_, species_);
  open_.clear();
}

}  // namespace stiffront
