// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/block_tridiagonal.hpp"

#include <algorithm>
#include <cstdint>

namespace stiffront::block_tridiagonal {
namespace {

int ceil_half(int x) { return (x + 1) / 2; }

int owner_of(const std::vector<std::array<std::int64_t, 2>>& boxes, std::int64_t point) {
  for (std::size_t r = 0; r < boxes.size(); ++r) {
    if (point >= boxes[r][0] && point < boxes[r][0] + boxes[r][1]) return static_cast<int>(r);
  }
  return -1;
}

}  // namespace

Levels::Levels(const Decomposition& d, bool periodic, int gather_at_most) {
  const Communicator& comm = d.comm();
  std::vector<std::array<std::int64_t, 2>> boxes;
  std::vector<std::array<int, 2>> owned;  // first row and end
  for (int r = 0; r < comm.size(); ++r) {
    const auto box = d.box_of(r);
    boxes.push_back({box[0], box[2]});
    owned.push_back({static_cast<int>(box[0]), static_cast<int>(box[0] + box[2])});
  }
  const auto rank = static_cast<std::size_t>(comm.rank());
  int n = static_cast<int>(d.grid().points[0]);
  bool alone = comm.size() == 1;
  for (int l = 0;; ++l) {
    // The first level is always a shared one: only there the off-diagonal blocks are diagonal.
    if (!alone && l > 0 && n <= std::max(gather_at_most, 1)) {
      gathered = levels.size();
      for (const auto& [begin, end] : owned) owned_at_gathering.push_back({begin, end - begin});
      alone = true;
    }
    Level level;
    level.n_global = n;
    level.begin = alone ? 0 : owned[rank][0];
    level.end = alone ? n : owned[rank][1];
    level.n_odd = level.end / 2 - level.begin / 2;
    const bool ring = periodic && n % 2 == 0;  // on a ring of odd length the two end rows are both even and stay
    const auto connect = [&](std::size_t side, int row, int other) {
      if (other < 0 || other >= n) {
        if (!ring) return;
        other = other < 0 ? n - 1 : 0;
      }
      const int partner = alone ? comm.rank() : owner_of(boxes, static_cast<std::int64_t>(other) << l);
      level.edges[side] = {partner, row % 2 != 0};
    };
    if (level.n() > 0) {
      connect(0, level.begin, level.begin - 1);
      connect(1, level.end - 1, level.end);
    }
    levels.push_back(level);
    if (n == 1) break;
    n = ceil_half(n);
    for (auto& [begin, end] : owned) begin = ceil_half(begin), end = ceil_half(end);
  }
}

EdgeMessages::EdgeMessages(const Communicator& comm, int largest_width) : comm_(&comm) {
  for (auto* buffers : {&out_, &in_}) {
    for (auto& b : *buffers) b.resize(static_cast<std::size_t>(largest_width));
  }
}

void EdgeMessages::exchange(const Level& level, bool odd_sends, int width) {
  std::array<MPI_Request, 4> requests;
  int n = 0;
  for (std::size_t side = 0; side < 2; ++side) {
    const Edge& edge = level.edges[side];
    if (edge.partner < 0) continue;
    const bool sends = edge.mine_is_odd == odd_sends;
    if (edge.partner == comm_->rank()) {
      if (sends) std::copy_n(out_[side].begin(), width, in_[1 - side].begin());
      continue;
    }
    // Two ranks in a ring share two edges: a message is tagged by the direction it travels in.
    const auto leftwards = static_cast<int>(sends == (side == 0));
    const auto request = static_cast<std::size_t>(n++);
    if (sends) {
      check_mpi(MPI_Isend(out_[side].data(), width, MPI_DOUBLE, edge.partner, leftwards, comm_->get(), &requests[request]), "MPI_Isend");
    } else {
      check_mpi(MPI_Irecv(in_[side].data(), width, MPI_DOUBLE, edge.partner, leftwards, comm_->get(), &requests[request]), "MPI_Irecv");
    }
  }
  if (n > 0) check_mpi(MPI_Waitall(n, requests.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
}

}  // namespace stiffront::block_tridiagonal

namespace stiffront {

template class BlockTridiagonal<1>;
template class BlockTridiagonal<2>;
template class BlockTridiagonal<3>;
template class BlockTridiagonal<4>;
template class BlockTridiagonal<5>;
template class BlockTridiagonal<6>;
template class BlockTridiagonal<7>;
template class BlockTridiagonal<8>;

}  // namespace stiffront
