// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <list>
#include <optional>
#include <vector>

#include "stiffront/core/mpi.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"
#include "stiffront/solvers/reaction_solver.hpp"
#include "stiffront/splitting/balance_plan.hpp"

namespace stiffront {

/// What the balancing of the reaction has done, on this rank unless said otherwise.
struct BalanceCounts {
  double work_owned = 0.0;                                     ///< counted work of this rank's own cells
  double work_done = 0.0;                                      ///< of the cells it integrated
  double largest_owned = 0.0, largest_done = 0.0, mean = 0.0;  ///< of the ranks of the group, each summed over the calls
  std::int64_t messages_sent = 0;
  std::int64_t bytes_sent = 0;
  std::int64_t cells_sent = 0;
};

/// Lets the ranks of a group share the reaction: packs of cells with much to do go to ranks with little, and come back advanced.
///
/// Which packs follows from their counted work in the last call of the same kind: over an interval of about the same length, as reactions
/// over half a step and over a twentieth of it have little in common, and at the same place of a step, as a reaction that goes on where
/// another ended is cheap next to one that diffusion has put out of balance. The ranks of a group tell each other their work by a gather that nobody waits for before
/// the next such call, and come to the same plan each on its own. Nothing of this changes a bit of the result.
///
/// Ranks that share memory tell each other their work and hand over packs there: what a line of a thousand cells has to gain in a call
/// is less than messages take.
///
/// Up to `largest_group` ranks are one group. More are divided into groups that each sample the whole domain (see balance_groups), so that no
/// table grows beyond that.
/// @cost two messages per transfer of the plan and call; 4 bytes a pack for each of a few kinds of calls
/// @see docs/scaling.md
class ReactionBalance {
 public:
  static constexpr int cells_per_pack = 8;  ///< the same on every machine, so that counts are

  /// @param box the cells of this rank that take part. @mpi collective
  ReactionBalance(const Decomposition& decomposition, const FreeBox& box, int largest_group = 1024, BalanceRule rule = {});
  ReactionBalance(const ReactionBalance&) = delete;
  ReactionBalance& operator=(const ReactionBalance&) = delete;
  ~ReactionBalance();

  /// The same as solver.advance over the box, and the same bits.
  /// @return the first failed cell, in index order, of those that this rank integrated, whoever owns them
  /// @mpi collective
  std::optional<CellFailure> advance(ReactionSolver& solver, double t, double dt, const Field& from, Field& to, std::vector<double>& hint,
                                     std::vector<float>& cost, Work& work);

  /// So far. @mpi collective
  const BalanceCounts& counts();

 private:
  /// What calls must have in common for the work of one to tell that of the next: the same on all ranks.
  struct Kind {
    double dt = 0.0;        ///< nearly
    bool in_place = false;  ///< a step's first flow reads the solution and writes elsewhere
    bool diffused = false;  ///< diffusion has been at work in this attempt at a step

    bool same_place(const Kind& other) const { return in_place == other.in_place && diffused == other.diffused; }
    double ratio(const Kind& other) const { return dt > other.dt ? dt / other.dt : other.dt / dt; }
  };
  /// Where the work was in the last call of a kind.
  struct Pattern {
    Kind kind;
    std::size_t place = 0;               ///< among the patterns
    std::int64_t used = 0;               ///< number of the call that wrote it
    std::uint64_t told = 0;              ///< times that the ranks have told each other
    bool is_known = true;                ///< what they told last
    std::vector<float> packs;            ///< work of each pack of the box
    std::int64_t mine[2] = {0, 0};       ///< owned, done
    std::vector<std::int64_t> of_ranks;  ///< the same of all ranks of the group, once gathered
    MPI_Request gather = MPI_REQUEST_NULL;
  };
  /// In shared memory: what a rank has to do, by pattern, told in two places in turn, since one who tells again knows of all others that they
  /// have read what was told before the last time.
  struct Page {
    Turn turn;
    std::int64_t work[2][2];
  };
  /// In the sender's shared memory, one for each rank it may send to: packs go there, are advanced in place and so come back.
  struct Box {
    Turn there;
    Turn back;
    std::int64_t packs;  ///< negative: too many for the box, they come by message
  };
  /// Packs that are elsewhere.
  struct Parcel {
    int rank;
    std::vector<std::int32_t> packs;
    std::vector<double> there, back;  ///< of messages
    Box* box = nullptr;
    std::uint64_t turn = 0;
  };
  /// Packs of another rank.
  struct Guest {
    int rank;
    bool is_here = false;
    std::vector<double> cells;  ///< of messages
    Box* box = nullptr;
    std::uint64_t turn = 0;
  };

  void share_memory(int n_species);
  Page& page(int rank, const Pattern& pattern) const;
  Box& box(int sender, int receiver) const;
  static double* cells_in(Box& box) { return reinterpret_cast<double*>(&box + 1); }
  Pattern* nearest(const Kind& kind);
  void learn(Pattern& pattern);
  void send(const Pattern& pattern, const Field& from, const std::vector<double>& hint);
  void fill(double* out, const Parcel& parcel, const Field& from, const std::vector<double>& hint);
  bool receive(Guest& guest, bool wait);
  void serve(Guest& guest, ReactionSolver& solver, Work& work, std::optional<CellFailure>& failure);
  void take_back(Field& to, std::vector<double>& hint, std::vector<float>& cost);
  void remember(Pattern* pattern, const Kind& kind, const std::vector<float>& cost);

  int packs_per_row() const { return (box_.i_end - box_.i_begin + cells_per_pack - 1) / cells_per_pack; }
  /// First cell and number of cells of a pack.
  struct Cells {
    int i, j, n;
  };
  Cells cells_of(std::int32_t pack) const;

  const Decomposition* decomposition_;
  FreeBox box_;
  BalanceRule rule_;
  Communicator group_;
  NodeMemory memory_;
  std::vector<std::uint64_t> turns_to_, turns_from_;  ///< of the boxes, by rank of the group
  std::list<Pattern> patterns_;
  std::int64_t calls_ = 0;
  double sent_work_ = 0.0;
  double guest_work_ = 0.0;
  std::vector<Parcel> parcels_;
  std::vector<Guest> guests_;
  std::vector<bool> is_away_;  ///< by pack
  std::vector<float> guest_costs_;
  std::vector<MPI_Request> requests_;  ///< of the call under way
  int n_species_ = 0;
  BalanceCounts counts_;
};

}  // namespace stiffront
