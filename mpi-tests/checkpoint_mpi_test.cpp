// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <limits>
#include <optional>

#include "stiffront/core/error.hpp"
#include "stiffront/io/checkpoint.hpp"
#include "support/diffusion_problem.hpp"
#include "support/temporary_folder.hpp"

namespace stiffront {
namespace {

namespace fs = std::filesystem;
using testing::content_of;
using testing::scatter;
using testing::TemporaryFolder;
using testing::unit_grid;
using testing::write_content;

std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

/// What a run might remember: two fields of different shape, a number per cell, numbers that decimal digits would spoil.
struct Memory {
  Memory(const Communicator& comm, const Grid& grid, std::array<int, 2> processes = {0, 0})
      : decomposition(comm, grid, processes, 2), u(decomposition, 3, 2), history(decomposition, 1, 1) {}

  void fill(int seed) {
    for_each([&](double* at, int s, std::int64_t i, std::int64_t j) { *at = scatter(i, j, s + 10 * seed) - 0.5; });
    if (decomposition.offset_x() == 0 && decomposition.offset_y() == 0) {
      u.at(0, 0) = -0.0;
      u.at(1, 0) = std::numeric_limits<double>::denorm_min();
    }
    numbers = {0.1 + seed,
               -0.0,
               std::nextafter(1.0, 2.0),
               std::numeric_limits<double>::infinity(),
               1e-310,
               std::numeric_limits<double>::quiet_NaN()};
    count = (std::int64_t{1} << 52) + seed;
    progress = {17 + seed, 3, 0.1 * seed, 1e-3, 0.0};
  }
  void visit(StateVisitor& visitor) {
    visitor.field("u", u);
    visit_progress(visitor, progress);
    visitor.numbers("controller", numbers);
    visitor.numbers("nothing", empty);
    visitor.integer("count", count);
    visitor.field("history", history);
    visitor.cells("inner_steps", cells);
  }
  VisitState visits() {
    return [this](StateVisitor& visitor) { visit(visitor); };
  }
  /// Whether everything is what fill(seed) makes.
  bool holds(int seed) {
    Memory expected(decomposition.comm(), decomposition.grid(), decomposition.processes());
    expected.fill(seed);
    bool same =
        count == expected.count && numbers.size() == expected.numbers.size() && empty.empty() && cells.size() == expected.cells.size();
    for (std::size_t n = 0; same && n < numbers.size(); ++n) same = bits(numbers[n]) == bits(expected.numbers[n]);
    for (std::size_t n = 0; same && n < cells.size(); ++n) same = bits(cells[n]) == bits(expected.cells[n]);
    for (const auto& [mine, other] : {std::pair<Field*, Field*>{&u, &expected.u}, {&history, &expected.history}}) {
      for (int s = 0; s < mine->n_species(); ++s) {
        for (int j = 0; j < mine->n_y(); ++j) {
          for (int i = 0; i < mine->n_x(); ++i) same = same && bits(mine->at(s, i, j)) == bits(other->at(s, i, j));
        }
      }
    }
    const Progress& p = progress;
    const Progress& q = expected.progress;
    return same && p.accepted == q.accepted && p.rejected == q.rejected && p.t == q.t && p.dt == q.dt && p.resume_dt == q.resume_dt;
  }

  Decomposition decomposition;
  Field u, history;
  std::vector<double> cells;
  std::vector<double> numbers;
  std::vector<double> empty;
  std::int64_t count = 0;
  Progress progress;

 private:
  template <class F>
  void for_each(F&& f) {
    const std::int64_t x = decomposition.offset_x(), y = decomposition.offset_y();
    cells.resize(static_cast<std::size_t>(u.n_x() * u.n_y()));
    for (int j = 0; j < u.n_y(); ++j) {
      for (int i = 0; i < u.n_x(); ++i) {
        for (int s = 0; s < 3; ++s) f(&u.at(s, i, j), s, x + i, y + j);
        f(&history.at(0, i, j), 3, x + i, y + j);
        f(&cells[static_cast<std::size_t>(j * u.n_x() + i)], 4, x + i, y + j);
      }
    }
  }
};

CheckpointHeader header(std::int64_t step, const Grid& grid) {
  return {step, 0.01 * static_cast<double>(step), "bz", {"a", "b", "c"}, grid, "title = \"t\"\n"};
}

template <class F>
std::optional<Error> error_of(F&& f) {
  try {
    f();
  } catch (const Error& e) {
    return e;
  }
  return std::nullopt;
}

class CheckpointTest : public ::testing::Test {
 protected:
  void write(std::int64_t step, int seed, int keep = 2) {
    Memory memory(comm_, grid_);
    memory.fill(seed);
    write_checkpoint(folder_.path(), header(step, grid_), memory.decomposition, keep, memory.visits());
    comm_.barrier();
  }
  /// What find-and-load gives: the step, or the error; and the warnings.
  void expect_step(std::int64_t step, int seed, const std::string& named = "") {
    std::optional<Checkpoint> checkpoint;
    const auto error = error_of([&] { checkpoint.emplace(comm_, folder_.path()); });
    ASSERT_FALSE(error) << error->what();
    EXPECT_EQ(checkpoint->header().step, step);
    EXPECT_EQ(checkpoint->warnings().size(), named.empty() ? 0U : 1U);
    if (!named.empty()) {
      EXPECT_NE(checkpoint->warnings().at(0).find(named), std::string::npos) << checkpoint->warnings()[0];
    }
    Memory memory(comm_, grid_);
    checkpoint->load(memory.decomposition, memory.visits());
    EXPECT_TRUE(memory.holds(seed));
  }
  std::string file(std::int64_t step, const std::string& name) const { return folder_.file(fmt::format("{:06}/{}", step, name)); }
  /// Names in the folder. @mpi collective, so that no rank changes the folder while another looks.
  std::vector<std::string> entries() const {
    comm_.barrier();
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path())) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    comm_.barrier();
    return names;
  }

  Communicator comm_{MPI_COMM_WORLD};
  TemporaryFolder folder_{comm_};
  Grid grid_ = unit_grid(13, 8);
};

TEST_F(CheckpointTest, EveryBitComesBackOnEveryNumberOfRanksFromEveryNumberOfRanks) {
  for (const Grid& grid : {unit_grid(53, 1), unit_grid(19, 17), unit_grid(16, 24, true, true)}) {
    std::int64_t step = 0;
    for (int writers = 1; writers <= comm_.size(); ++writers) {
      ++step;
      for (int readers = 0; readers <= comm_.size(); ++readers) {
        const int wanted = readers == 0 ? writers : readers;
        MPI_Comm some = MPI_COMM_NULL;
        MPI_Comm_split(comm_.get(), comm_.rank() < wanted ? 0 : MPI_UNDEFINED, comm_.rank(), &some);
        if (some != MPI_COMM_NULL) {
          const Communicator comm(some);
          MPI_Comm_free(&some);
          if (readers == 0) {
            Memory memory(comm, grid, grid.dimension == 2 ? std::array{1, writers} : std::array{0, 0});
            memory.fill(writers);
            write_checkpoint(folder_.path(), header(step, grid), memory.decomposition, 2, memory.visits());
          } else {
            const Checkpoint checkpoint(comm, folder_.path());
            EXPECT_TRUE(checkpoint.warnings().empty());
            EXPECT_EQ(checkpoint.header().step, step);
            EXPECT_EQ(checkpoint.header().time, 0.01 * static_cast<double>(step));
            EXPECT_EQ(checkpoint.header().case_text, "title = \"t\"\n");
            EXPECT_NO_THROW(checkpoint.require("bz", {"a", "b", "c"}, grid));
            for (const auto& layout : {std::array{0, 0}, grid.dimension == 2 ? std::array{readers, 1} : std::array{0, 0}}) {
              Memory memory(comm, grid, layout);
              checkpoint.load(memory.decomposition, memory.visits());
              EXPECT_TRUE(memory.holds(writers)) << writers << " -> " << readers;
            }
          }
        }
        comm_.barrier();
      }
    }
    for (const std::string& name : entries()) {
      std::error_code ignored;
      if (comm_.is_root()) fs::remove_all(folder_.file(name), ignored);
    }
    comm_.barrier();
  }
}

TEST_F(CheckpointTest, AChangedByteAnywhereIsNoticedAndTheOlderCheckpointTaken) {
  write(10, 1);
  write(20, 2);
  expect_step(20, 2);
  std::vector<std::string> names{"manifest.json"};
  for (int r = 0; r < comm_.size(); ++r) names.push_back(fmt::format("rank-{:04}.h5", r));
  for (const std::string& name : names) {
    const std::string whole = content_of(file(20, name));
    ASSERT_GT(whole.size(), 100U);
    const std::size_t stride = std::max<std::size_t>(1, whole.size() / 23);
    for (std::size_t at = 0; at<whole.size(); at += at + 40> whole.size() ? 1 : stride) {
      comm_.barrier();
      if (comm_.is_root()) {
        std::string changed = whole;
        changed[at] = static_cast<char>(changed[at] ^ (1 << (at % 8)));
        write_content(file(20, name), changed);
      }
      comm_.barrier();
      const Checkpoint checkpoint(comm_, folder_.path());
      EXPECT_EQ(checkpoint.header().step, 10) << name << " byte " << at;
      ASSERT_EQ(checkpoint.warnings().size(), 1U) << name << " byte " << at;
      EXPECT_NE(checkpoint.warnings()[0].find("000020"), std::string::npos);
    }
    comm_.barrier();
    if (comm_.is_root()) write_content(file(20, name), whole);
    comm_.barrier();
  }
  expect_step(20, 2);
}

TEST_F(CheckpointTest, FilesThatAreCutShortOrMissingAreNamedAndTheOlderCheckpointTaken) {
  const std::string shard = fmt::format("rank-{:04}.h5", comm_.size() - 1);
  write(10, 1);
  const auto break_it = [&](const std::function<void()>& how) {
    write(20, 2);
    if (comm_.is_root()) how();
    comm_.barrier();
  };
  break_it([&] { fs::resize_file(file(20, shard), fs::file_size(file(20, shard)) - 1); });
  expect_step(10, 1, shard);
  break_it([&] { fs::remove(file(20, shard)); });
  expect_step(10, 1, shard);
  break_it([&] { fs::resize_file(file(20, "manifest.json"), 0); });
  expect_step(10, 1, "manifest is damaged");
  break_it([&] { fs::remove(file(20, "manifest.json")); });
  expect_step(10, 1, "manifest.json");
  break_it([&] { write_content(file(20, "manifest.json"), "{\"format\": \"another\"}\n"); });
  expect_step(10, 1, "000020");

  if (comm_.is_root()) fs::remove(file(10, shard));
  comm_.barrier();
  const auto error = error_of([&] { Checkpoint(comm_, folder_.path()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), ErrorKind::io);
  EXPECT_NE(std::string(error->what()).find("no valid checkpoint"), std::string::npos) << error->what();
  EXPECT_NE(std::string(error->what()).find("000010"), std::string::npos) << error->what();
  EXPECT_NE(std::string(error->what()).find("000020"), std::string::npos) << error->what();
}

TEST_F(CheckpointTest, AFolderWithoutACheckpointIsAnError) {
  for (const std::string& path : {folder_.path(), folder_.file("none")}) {
    const auto error = error_of([&] { Checkpoint(comm_, path); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->kind(), ErrorKind::io);
    EXPECT_NE(std::string(error->what()).find(path), std::string::npos) << error->what();
  }
}

TEST_F(CheckpointTest, TheNewestIsFoundFromTheOutputFolderAndAnyFromItsOwn) {
  Memory memory(comm_, grid_);
  for (int n = 1; n <= 2; ++n) {
    memory.fill(n);
    write_checkpoint(folder_.file("out/checkpoints"), header(n, grid_), memory.decomposition, 2, memory.visits());
  }
  EXPECT_EQ(Checkpoint(comm_, folder_.file("out")).header().step, 2);
  EXPECT_EQ(Checkpoint(comm_, folder_.file("out/checkpoints")).header().step, 2);
  EXPECT_EQ(Checkpoint(comm_, folder_.file("out/checkpoints/000001")).header().step, 1);
}

TEST_F(CheckpointTest, OlderOnesArePrunedAndThoseOfAnAbandonedFutureToo) {
  for (int step : {10, 20, 30}) write(step, step);
  EXPECT_EQ(entries(), (std::vector<std::string>{"000020", "000030"}));
  write(40, 4, 3);
  EXPECT_EQ(entries(), (std::vector<std::string>{"000020", "000030", "000040"}));
  write(35, 5, 3);  // a run that went on from 30
  EXPECT_EQ(entries(), (std::vector<std::string>{"000020", "000030", "000035"}));
  write(35, 6, 3);  // the same step again
  EXPECT_EQ(entries(), (std::vector<std::string>{"000020", "000030", "000035"}));
  expect_step(35, 6);
}

TEST_F(CheckpointTest, LeftoversOfAKilledRunAreIgnoredAndCleaned) {
  write(10, 1);
  if (comm_.is_root()) {
    fs::create_directory(folder_.file("000020.tmp"));
    write_content(folder_.file("000020.tmp/rank-0000.h5"), "part");
  }
  comm_.barrier();
  expect_step(10, 1);
  write(30, 3);
  EXPECT_EQ(entries(), (std::vector<std::string>{"000010", "000030"}));
}

TEST_F(CheckpointTest, AFullDiskOnOneRankIsReportedOnAllAndTheOlderCheckpointStays) {
  write(10, 1);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small{3000, limit.rlim_max};
  if (comm_.rank() == comm_.size() - 1) setrlimit(RLIMIT_FSIZE, &small);
  const auto error = error_of([&] { write(20, 2); });
  setrlimit(RLIMIT_FSIZE, &limit);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), ErrorKind::io);
  EXPECT_NE(std::string(error->what()).find(fmt::format("rank-{:04}.h5", comm_.size() - 1)), std::string::npos) << error->what();
  EXPECT_EQ(entries(), std::vector<std::string>{"000010"});
  expect_step(10, 1);
  write(20, 2);
  expect_step(20, 2);
}

TEST_F(CheckpointTest, AnotherModelOrGridIsRefusedWithTheDifference) {
  write(10, 1);
  const Checkpoint checkpoint(comm_, folder_.path());
  const std::vector<std::string> species{"a", "b", "c"};
  const auto check = [&](const std::string& model, const std::vector<std::string>& names, const Grid& grid, const char* text) {
    const auto error = error_of([&] { checkpoint.require(model, names, grid); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->kind(), ErrorKind::input);
    EXPECT_NE(std::string(error->what()).find(text), std::string::npos) << error->what();
  };
  check("kpp", species, grid_, "it is of the model \"bz\", not \"kpp\"");
  check("bz", {"a", "b"}, grid_, "its species are a, b, c, not a, b");
  check("bz", species, unit_grid(14, 8), "its grid has 13 x 8 points, not 14 x 8");
  Grid moved = grid_;
  moved.upper[1] = 2.0;
  check("bz", species, moved, "lies elsewhere");
  EXPECT_FALSE(error_of([&] { checkpoint.require("bz", species, grid_); }));
}

TEST_F(CheckpointTest, MemoryOfAnotherMethodIsRefusedBothWays) {
  write(10, 1);
  const Checkpoint checkpoint(comm_, folder_.path());
  Memory memory(comm_, grid_);
  const auto more = error_of([&] {
    checkpoint.load(memory.decomposition, [&](StateVisitor& v) {
      memory.visit(v);
      v.numbers("backward_differences", memory.empty);
    });
  });
  ASSERT_TRUE(more);
  EXPECT_EQ(more->kind(), ErrorKind::input);
  EXPECT_NE(std::string(more->what()).find("holds no 'backward_differences'"), std::string::npos) << more->what();
  const auto fewer = error_of([&] { checkpoint.load(memory.decomposition, [&](StateVisitor& v) { v.field("u", memory.u); }); });
  ASSERT_TRUE(fewer);
  EXPECT_EQ(fewer->kind(), ErrorKind::input);
  EXPECT_NE(std::string(fewer->what()).find("has no use for"), std::string::npos) << fewer->what();
}

TEST_F(CheckpointTest, ANumberThatDiffersBetweenRanksIsABug) {
  if (comm_.size() == 1) GTEST_SKIP() << "needs two ranks";
  Memory memory(comm_, grid_);
  memory.fill(1);
  memory.progress.dt += comm_.rank() == comm_.size() - 1 ? 1e-18 : 0.0;
  const auto error = error_of([&] { write_checkpoint(folder_.path(), header(1, grid_), memory.decomposition, 2, memory.visits()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), ErrorKind::bug);
  EXPECT_TRUE(entries().empty());
}

TEST_F(CheckpointTest, AFailureOfOneRanksVisitIsEveryRanks) {
  Memory memory(comm_, grid_);
  memory.fill(1);
  if (comm_.rank() == comm_.size() - 1) memory.cells.pop_back();
  const auto error = error_of([&] { write_checkpoint(folder_.path(), header(1, grid_), memory.decomposition, 2, memory.visits()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), ErrorKind::bug);
  EXPECT_NE(std::string(error->what()).find("inner_steps"), std::string::npos) << error->what();
}

}  // namespace
}  // namespace stiffront
