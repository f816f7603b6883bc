// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// Brings the halos of one or several fields up to date: one message per neighbour carries all species of all fields.
///
/// Persistent requests are made once; begin() packs and starts them, work that needs no halo may follow, finish() waits, unpacks
/// and applies the physical boundaries. Every exchange object serves any fields of the shape it was made for. What goes to a rank whose
/// memory is shared is packed there and read by it: a message all the same, without its detour.
class HaloExchange {
 public:
  /// @param width points exchanged per side; at most the fields' halo and the size of the smallest box, and less than the size of a
  ///        box with a Neumann side if that is the whole direction.
  /// @param species which species take part (all the others' halos stay as they are); empty: all.
  /// @param corners whether diagonal neighbours are served too (needed when several stencils are applied per exchange).
  /// @throws Error(input) on every rank if a box is too small. @mpi collective
  HaloExchange(const Decomposition& decomposition, const Boundary& boundary, int n_species, int n_fields, int width,
               std::vector<int> species = {}, bool corners = false);
  /// For stencils of width `stencil` applied several times per exchange: each field has a width of its own, corners are included in two
  /// dimensions, and only `stencil` points are filled beyond physical sides, along the halos of neighbours too.
  HaloExchange(const Decomposition& decomposition, const Boundary& boundary, int n_species, std::vector<int> widths, int stencil,
               std::vector<int> species);
  HaloExchange(const HaloExchange&) = delete;
  HaloExchange& operator=(const HaloExchange&) = delete;
  ~HaloExchange();

  /// @pre exactly n_fields fields; no exchange of this object is open. @mpi collective on the neighbours.
  void begin(std::span<Field* const> fields);
  /// Completes what begin() started.
  void finish();
  void exchange(std::span<Field* const> fields) {
    begin(fields);
    finish();
  }
  void exchange(Field& field) {
    Field* f = &field;
    exchange(std::span<Field* const>(&f, 1));
  }

  int width() const { return widths_.front(); }
  /// Exchanges done so far, and the bytes this rank sent in them.
  std::int64_t count() const { return count_; }
  std::int64_t bytes_sent() const { return bytes_sent_; }

 private:
  struct Link {
    int dx, dy;
    int rank;
    std::size_t size;                    ///< in doubles
    std::vector<double> send{}, recv{};  ///< of messages
    std::array<double*, 2> out{};        ///< in shared memory, used in turn
    std::array<const double*, 2> in{};
    Turn* sent = nullptr;  ///< nullptr: messages
    const Turn* received = nullptr;
  };
  /// Part of a field that travels through a link.
  struct Strip {
    int send_i, send_j, recv_i, recv_j;  // first points
    int n_i, n_j;
  };
  void make_links(int n_species, bool corners);
  Strip strip(const Link& link, int width) const;
  void share_memory();
  void open_requests();
  void pack(const Link& link, double* out) const;
  void unpack(const double* in, const Link& link) const;

  const Decomposition* decomposition_;
  const Boundary* boundary_;
  std::vector<int> widths_;  ///< of each field
  int stencil_;
  std::vector<int> species_;
  std::vector<Link> links_;
  NodeMemory memory_;
  int sent_per_exchange_ = 0;
  std::int64_t bytes_per_exchange_ = 0;
  std::vector<MPI_Request> requests_;
  std::vector<Field*> open_;
  std::int64_t count_ = 0;
  std::int64_t bytes_sent_ = 0;
};

}  // namespace stiffront
