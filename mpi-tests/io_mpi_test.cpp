// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <optional>

#include "stiffront/core/error.hpp"
#include "stiffront/io/checksum.hpp"
#include "stiffront/io/history.hpp"
#include "stiffront/io/output.hpp"
#include "stiffront/io/output_directory.hpp"
#include "stiffront/io/probes.hpp"
#include "stiffront/io/result_file.hpp"
#include "stiffront/solvers/model_registry.hpp"
#include "support/diffusion_problem.hpp"
#include "support/mutation.hpp"
#include "support/temporary_folder.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::content_of;
using testing::DiffusionProblem;
using testing::scatter;
using testing::TemporaryFolder;
using testing::unit_grid;

const std::vector<std::string> names{"u", "v"};

std::array<std::array<BoundarySide, 2>, 2> natural(const Grid& grid) {
  const auto kind = [&](std::size_t d) { return grid.periodic[d] ? BoundaryKind::periodic : BoundaryKind::neumann; };
  return {both_sides(kind(0), 2), both_sides(kind(1), 2)};
}

/// Two species on a grid over the ranks of a communicator.
struct Problem : DiffusionProblem {
  Problem(const Communicator& comm, const Grid& grid_, std::array<int, 2> processes = {0, 0})
      : DiffusionProblem(comm, grid_, natural(grid_), {0.01, 0.0}, 2, processes) {}

  Field rough() const {
    Field u = field();
    for (int s = 0; s < 2; ++s) {
      for (int j = 0; j < u.n_y(); ++j) {
        for (int i = 0; i < u.n_x(); ++i) u.at(s, i, j) = scatter(decomposition.offset_x() + i, decomposition.offset_y() + j, s) - 0.5;
      }
    }
    return u;
  }
};

bool same_bits(const Field& a, const Field& b) {
  for (int s = 0; s < a.n_species(); ++s) {
    for (int j = 0; j < a.n_y(); ++j) {
      for (int i = 0; i < a.n_x(); ++i) {
        if (std::bit_cast<std::uint64_t>(a.at(s, i, j)) != std::bit_cast<std::uint64_t>(b.at(s, i, j))) return false;
      }
    }
  }
  return true;
}

/// Whether the whole field equals this rank's part of another.
bool is_part_of(const Field& part, const Field& whole) {
  const Decomposition& d = part.decomposition();
  for (int s = 0; s < part.n_species(); ++s) {
    for (int j = 0; j < part.n_y(); ++j) {
      for (int i = 0; i < part.n_x(); ++i) {
        const double other = whole.at(s, static_cast<int>(d.offset_x()) + i, static_cast<int>(d.offset_y()) + j);
        if (std::bit_cast<std::uint64_t>(part.at(s, i, j)) != std::bit_cast<std::uint64_t>(other)) return false;
      }
    }
  }
  return true;
}

/// The error of a call that must fail on every rank; a call that does not gives none.
template <class F>
std::optional<Error> error_of(F&& f) {
  try {
    f();
  } catch (const Error& e) {
    return e;
  }
  return std::nullopt;
}

std::vector<std::array<int, 2>> layouts(int ranks, const Grid& grid) {
  std::vector<std::array<int, 2>> all;
  for (int p = 1; p <= ranks; ++p) {
    if (ranks % p == 0 && (grid.dimension == 2 || p == ranks)) all.push_back({p, ranks / p});
  }
  return all;
}

class IoTest : public ::testing::Test {
 protected:
  Communicator comm_{MPI_COMM_WORLD};
  Communicator self_{MPI_COMM_SELF};
  TemporaryFolder folder_{comm_};
};

// ---------------------------------------------------------------- result files

TEST_F(IoTest, AStateComesBackBitForBitOnEveryLayout) {
  for (const Grid& grid : {unit_grid(53, 1), unit_grid(53, 1, true), unit_grid(37, 29), unit_grid(24, 31, true, false)}) {
    for (const auto& layout : layouts(comm_.size(), grid)) {
      const Problem problem(comm_, grid, layout);
      Field u = problem.rough();
      if (problem.decomposition.offset_x() == 0) u.at(0, 0) = -0.0;
      write_state(folder_.file("state.h5"), {1.25, 42, false, names, "title = \"\u00e4\"\n"}, problem.boundary, u);
      Field read = problem.field();
      const StateSource source = read_state(folder_.file("state.h5"), names, read);
      EXPECT_TRUE(same_bits(u, read));
      EXPECT_EQ(source.time, 1.25);
      EXPECT_EQ(source.step, 42);
      EXPECT_FALSE(source.interpolated);
      // One process alone sees the same.
      const Problem whole(self_, grid);
      Field all = whole.field();
      read_state(folder_.file("state.h5"), names, all);
      EXPECT_TRUE(is_part_of(u, all));
    }
  }
  const StateHeader header = read_header(folder_.file("state.h5"));
  EXPECT_EQ(header.species, names);
  EXPECT_EQ(header.case_text, "title = \"\u00e4\"\n");
  EXPECT_FALSE(std::filesystem::exists(folder_.file("state.h5.tmp")));
}

TEST_F(IoTest, SpeciesAreFoundByNameInAnyOrder) {
  const Problem problem(comm_, unit_grid(40, 1));
  const Field u = problem.rough();
  write_state(folder_.file("state.h5"), {0.0, 0, false, names, ""}, problem.boundary, u);
  Field swapped = problem.field();
  read_state(folder_.file("state.h5"), {"v", "u"}, swapped);
  for (int i = 0; i < u.n_x(); ++i) {
    EXPECT_EQ(swapped.at(0, i), u.at(1, i));
    EXPECT_EQ(swapped.at(1, i), u.at(0, i));
  }
}

TEST_F(IoTest, ACaseTextBeyondTheClassicalLimitOfAnAttributeIsKept) {
  const Problem problem(comm_, unit_grid(40, 1));
  std::string text;
  while (text.size() < 200000) text += "# a long comment\n";
  write_state(folder_.file("state.h5"), {0.0, 0, false, names, text}, problem.boundary, problem.rough());
  EXPECT_EQ(read_header(folder_.file("state.h5")).case_text, text);
}

// HDF5 1.10 crashes on some of these.
TEST_F(IoTest, AStateChangedAnywhereButInItsValuesIsRefused) {
  const Problem problem(comm_, unit_grid(20, 7));
  const std::string path = folder_.file("state.h5");
  write_state(path, {0.5, 3, false, names, "title = \"t\"\n"}, problem.boundary, problem.rough());
  if (!comm_.is_root()) return;
  std::ifstream in(path, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const auto refused = [&](const std::string& content) {
    std::ofstream(folder_.file("changed.h5"), std::ios::binary) << content;
    try {
      const Problem alone(self_, unit_grid(20, 7));
      Field u = alone.field();
      read_state(folder_.file("changed.h5"), names, u);
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::io) << e.what();
      return true;
    }
    return false;
  };
  ASSERT_FALSE(refused(whole));
  std::size_t missed = 0;
  for (std::size_t at = 0; at < whole.size(); at += 7) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ (1 << (at % 8)));
    missed += refused(changed) ? 0 : 1;
  }
  EXPECT_LE(missed, (27 + 2 * 140) * sizeof(double) / 7 + 4) << "no more than the values of x, y and two species";
  for (std::uint64_t seed = 0; seed < testing::mutation_rounds(300); ++seed) {
    testing::Mutation mutation(seed);
    refused(mutation.of(whole, {std::string("\x89HDF\r\n\x1a\n"), std::string(8, '\xff'), std::string(64, '\0')}));
  }
}

/// Largest error of a smooth state read on `to` after it was written on `from`.
double interpolation_error(const Communicator& comm, const Communicator& self, const std::string& path, const Grid& from, const Grid& to) {
  const double pi = std::numbers::pi;
  const auto smooth = [&](int s, double x, double y) { return 1.5 + std::sin(2.0 * pi * x + s) * std::cos(2.0 * pi * y); };
  const Problem source(comm, from);
  write_state(path, {0.0, 0, false, names, ""}, source.boundary, source.field(smooth));
  const Problem target(comm, to);
  Field u = target.field();
  const StateSource read = read_state(path, names, u);
  EXPECT_TRUE(read.interpolated);
  EXPECT_NE(read.note.find("interpolated"), std::string::npos);
  const Problem whole(self, to);
  Field all = whole.field();
  read_state(path, names, all);
  EXPECT_TRUE(is_part_of(u, all));
  const Field exact = target.field(smooth);
  double worst = 0.0;
  for (int s = 0; s < 2; ++s) {
    for (int j = 0; j < u.n_y(); ++j) {
      for (int i = 0; i < u.n_x(); ++i) worst = std::max(worst, std::abs(u.at(s, i, j) - exact.at(s, i, j)));
    }
  }
  return comm.max(worst);
}

TEST_F(IoTest, InterpolationBetweenGridsIsOfFourthOrderAndTheSameOnAnyRanks) {
  const auto error = [&](const Grid& from, const Grid& to) {
    return interpolation_error(comm_, self_, folder_.file("state.h5"), from, to);
  };
  for (const bool periodic : {false, true}) {
    EXPECT_GT(error(unit_grid(21, 1, periodic), unit_grid(57, 1)) / error(unit_grid(41, 1, periodic), unit_grid(57, 1)), 12.0);
    EXPECT_GT(
        error(unit_grid(21, 25, periodic), unit_grid(34, 57, periodic)) / error(unit_grid(42, 50, periodic), unit_grid(34, 57, periodic)),
        12.0);
  }
  EXPECT_LT(error(unit_grid(65, 1), unit_grid(33, 1)), 1e-15);        // every other point
  EXPECT_LT(error(unit_grid(64, 1, true), unit_grid(33, 1)), 1e-15);  // the end point comes from the other end
}

TEST_F(IoTest, InterpolationMakesNoNegativeValuesAheadOfAFront) {
  const Problem source(comm_, unit_grid(41, 1));
  const Field step = source.field([](int s, double x, double) { return (x < 0.5 ? 1.0 : 0.0) - (s == 1 && x > 0.9 ? 1e-3 : 0.0); });
  write_state(folder_.file("state.h5"), {0.0, 0, false, names, ""}, source.boundary, step);
  const Problem target(comm_, unit_grid(101, 1));
  Field u = target.field();
  read_state(folder_.file("state.h5"), names, u);
  double lowest[2] = {0.0, 0.0};
  for (int s = 0; s < 2; ++s) {
    for (int i = 0; i < u.n_x(); ++i) lowest[s] = std::min(lowest[s], u.at(s, i));
  }
  EXPECT_EQ(comm_.max(-lowest[0]), 0.0);
  EXPECT_GE(comm_.max(-lowest[1]), 1e-3);  // but what is negative stays so
}

TEST_F(IoTest, AFileThatDoesNotFitIsExplainedOnEveryRank) {
  const Problem line(comm_, unit_grid(40, 1));
  write_state(folder_.file("line.h5"), {0.0, 0, false, names, ""}, line.boundary, line.rough());
  if (comm_.is_root()) testing::write_content(folder_.file("text.h5"), "no HDF5");
  comm_.barrier();
  Field u = line.field();
  const auto check = [&](const std::string& file, const std::vector<std::string>& species, Field& field, ErrorKind kind, const char* text) {
    const auto error = error_of([&] { read_state(folder_.file(file), species, field); });
    ASSERT_TRUE(error) << file;
    EXPECT_EQ(error->kind(), kind);
    EXPECT_NE(std::string(error->what()).find(text), std::string::npos) << error->what();
    EXPECT_NE(std::string(error->what()).find(file), std::string::npos) << error->what();
  };
  check("line.h5", {"u", "w"}, u, ErrorKind::input, "has no species 'w'; it holds u, v");
  check("none.h5", names, u, ErrorKind::io, "no such file");
  check("text.h5", names, u, ErrorKind::io, "cannot be opened as an HDF5 file");
  const Problem plane(comm_, unit_grid(40, 20));
  Field u2 = plane.field();
  check("line.h5", names, u2, ErrorKind::input, "holds a state in 1 dimension, not 2");
  Grid longer = unit_grid(40, 1);
  longer.upper[0] = 2.0;
  const Problem other(comm_, longer);
  Field u3 = other.field();
  check("line.h5", names, u3, ErrorKind::input, "holds a state on [0, 1] in x, not on [0, 2]");
}

TEST_F(IoTest, AWriteThatFailsLeavesTheOldFileAndNoPart) {
  const Problem problem(comm_, unit_grid(100, 100));
  const Field u = problem.rough();
  const std::string path = folder_.file("state.h5");
  write_state(path, {0.0, 0, false, names, ""}, problem.boundary, u);

  // A file-size limit on root alone stands for a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small{100000, limit.rlim_max};
  if (comm_.is_root()) setrlimit(RLIMIT_FSIZE, &small);
  const auto error = error_of([&] { write_state(path, {1.0, 1, false, names, ""}, problem.boundary, u); });
  if (comm_.is_root()) setrlimit(RLIMIT_FSIZE, &limit);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), ErrorKind::io);
  EXPECT_NE(std::string(error->what()).find("no room for 0.2 MiB"), std::string::npos) << error->what();
  EXPECT_FALSE(must_end_by_abort());
  EXPECT_EQ(read_header(path).time, 0.0);
  EXPECT_FALSE(std::filesystem::exists(path + ".tmp"));

  const auto missing = error_of([&] { write_state(folder_.file("none/state.h5"), {1.0, 1, false, names, ""}, problem.boundary, u); });
  ASSERT_TRUE(missing);
  EXPECT_EQ(missing->kind(), ErrorKind::io);
}

TEST_F(IoTest, ASpeciesMayNotBeCalledLikeACoordinate) {
  const Problem problem(comm_, unit_grid(40, 1));
  const auto error = error_of([&] {
    write_state(folder_.file("s.h5"), {0.0, 0, false, {"x", "v"}, ""}, problem.boundary, problem.rough());
  });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), ErrorKind::input);
}

// ---------------------------------------------------------------- checksum

TEST_F(IoTest, TheChecksumDependsOnEveryBitAndNotOnTheRanks) {
  for (const Grid& grid : {unit_grid(53, 1), unit_grid(37, 29)}) {
    const Problem whole(self_, grid);
    const std::string expected = checksum(whole.rough());
    EXPECT_EQ(expected.size(), 16U);
    for (const auto& layout : layouts(comm_.size(), grid)) {
      const Problem problem(comm_, grid, layout);
      Field u = problem.rough();
      EXPECT_EQ(checksum(u), expected);
      const bool last = comm_.rank() == comm_.size() - 1;
      double& value = u.at(1, u.n_x() - 1, u.n_y() - 1);
      const double kept = value;
      if (last) value = std::nextafter(value, 2.0);
      EXPECT_NE(checksum(u), expected);
      value = kept;
      if (last) std::swap(u.at(0, 0), u.at(0, 1));
      EXPECT_NE(checksum(u), expected);
      if (last) std::swap(u.at(0, 0), u.at(0, 1));
      if (last) std::swap(u.at(0, 0), u.at(1, 0));
      EXPECT_NE(checksum(u), expected);
    }
  }
  const Problem problem(comm_, unit_grid(40, 1));
  Field zero = problem.field();
  const std::string expected = checksum(zero);
  zero.at(0, 3) = -0.0;
  EXPECT_EQ(checksum(zero), expected);
}

// ---------------------------------------------------------------- history and probes

TEST_F(IoTest, HistorySumsTheReactionStepsOfAllRanks) {
  History history(comm_, folder_.file("history.csv"));
  history.begin();
  std::string expected;
  for (int n = 0; n < 70; ++n) {
    StepRecord r;
    r.step = n;
    r.attempt.accepted = true;
    r.attempt.work.reaction_steps = 10 * n + comm_.rank();
    history.add(r, 0.0);
    expected += fmt::format("{},0,0,0,1,0,0,0,0,{},0\n", n, 10 * n * comm_.size() + comm_.size() * (comm_.size() - 1) / 2);
  }
  history.flush();
  const std::string text = content_of(folder_.file("history.csv"));
  if (comm_.is_root()) {
    EXPECT_EQ(text.substr(text.find('\n') + 1), expected);
  }
}

TEST_F(IoTest, ProbesInterpolateLinearlyAndDoNotDependOnTheRanks) {
  const auto linear = [](int s, double x, double y) { return 1.0 + (s + 1) * x - 2.0 * y + 3.0 * x * y; };
  for (const int n_y : {1, 23}) {
    const Grid grid = unit_grid(31, n_y);
    const std::vector<std::array<double, 2>> points{{0.0, 0.0}, {1.0, 1.0}, {0.1, 0.5}, {0.3141, 0.271828}, {0.5, 0.97}};
    const auto write = [&](const Communicator& comm, const std::string& path) {
      const Problem problem(comm, grid);
      Probes probes(problem.decomposition, path, points, names);
      probes.begin();
      const Field u = problem.field(linear);
      const Field rough = problem.rough();
      for (int n = 1; n <= 70; ++n) probes.add(n, 0.1 * n, n == 70 ? rough : u);
      probes.flush();
    };
    write(comm_, folder_.file("probes.csv"));
    if (!comm_.is_root()) continue;
    write(self_, folder_.file("alone.csv"));
    const std::string text = content_of(folder_.file("probes.csv"));
    EXPECT_EQ(text, content_of(folder_.file("alone.csv")));
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 71);
    std::istringstream lines(text);
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line.substr(0, 31), n_y == 1 ? "step,time,u@0,v@0,u@1,v@1,u@0.1" : "step,time,u@0:0,v@0:0,u@1:1,v@1");
    std::getline(lines, line);
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    double step = 0.0, time = 0.0;
    numbers >> step >> time;
    EXPECT_EQ(step, 1.0);
    for (const auto& [x, y] : points) {
      for (int s = 0; s < 2; ++s) {
        double value = 0.0;
        ASSERT_TRUE(numbers >> value);
        EXPECT_NEAR(value, linear(s, x, n_y == 1 ? 0.0 : y), 1e-14);
      }
    }
  }
}

TEST_F(IoTest, AProbeOutsideTheGridIsAnInputError) {
  const Problem problem(comm_, unit_grid(31, 1));
  const auto error = error_of([&] { Probes(problem.decomposition, "probes.csv", {{1.5, 0.0}}, names); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), ErrorKind::input);
  EXPECT_STREQ(error->what(), "output.probes: the point 1.5 is outside of [0, 1]");
}

// ---------------------------------------------------------------- the whole of a run's output

TEST_F(IoTest, AnOutputFolderWithResultsIsRefusedOnEveryRank) {
  if (comm_.is_root()) testing::write_content(folder_.file("summary.json"), "{}");
  const auto error = error_of([&] { OutputDirectory(comm_, folder_.path(), ExistingResults::refuse); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), ErrorKind::io);
  EXPECT_NE(std::string(error->what()).find("--force"), std::string::npos);
}

/// Steps of a made-up run whose states are smooth in time: step k goes from k/4 to (k+1)/4.
struct MadeUpRun {
  MadeUpRun(const Communicator& comm, const std::string& path, Output::Options options, ExistingResults existing)
      : problem(comm, grid()), directory(comm, path, existing) {
    register_builtin_models(registry);
    model = registry.make("brusselator", {});
    rhs.emplace(problem.decomposition, problem.diffusion, *model);
    options.times.end = 1.0;
    options.species = names;
    output.emplace(directory, problem.decomposition, problem.boundary, *rhs, std::move(options));
  }
  static Grid grid() { return unit_grid(33, 21); }
  Field state(double t) const {
    return problem.field([t](int s, double x, double y) { return 2.0 + s + std::sin(3.0 * x + t) * std::cos(2.0 * y - t); });
  }
  void steps(int from, int to) {
    for (int k = from; k < to; ++k) {
      StepRecord r;
      r.step = k;
      r.t = 0.25 * k;
      r.dt = 0.25;
      r.begin = r.t;
      r.end = r.t + r.dt;
      r.attempt.accepted = true;
      Field u = state(r.t);
      Field u_new = state(r.t + r.dt);
      output->attempted(r, 0.0);
      output->stepped(r, r.t + r.dt, u, u_new);
    }
  }

  Problem problem;
  OutputDirectory directory;
  ModelRegistry registry;
  std::unique_ptr<ModelKernels> model;
  std::optional<CoupledRhs> rhs;
  std::optional<Output> output;
};

Output::Options some_options() {
  Output::Options options;
  options.times.times = {0.1, 0.2, 0.3, 0.5, 0.6};
  options.probes = {{0.5, 0.5}};
  return options;
}

const std::vector<std::string> expected_names{"fields-000000.h5", "fields-000001-1.h5", "fields-000001.h5", "fields-000002-1.h5",
                                              "fields-000002.h5", "fields-000003.h5",   "fields-000004.h5"};
const std::vector<double> expected_times{0.0, 0.1, 0.2, 0.3, 0.5, 0.6, 1.0};

std::string checksum_of_file(const Communicator& self, const std::string& path) {
  const Problem whole(self, MadeUpRun::grid());
  Field u = whole.field();
  read_state(path, names, u);
  return checksum(u);
}

TEST_F(IoTest, ARunLeavesItsStatesAtTheTimesAskedForAlikeOnAnyRanks) {
  MadeUpRun run(comm_, folder_.file("out"), some_options(), ExistingResults::refuse);
  run.output->begin(0.0, run.state(0.0));
  run.steps(0, 4);
  run.output->flush();
  EXPECT_TRUE(run.output->landing_times().empty());
  EXPECT_EQ(run.output->files(), 7);
  if (!comm_.is_root()) return;
  ASSERT_EQ(run.directory.state_names(), expected_names);
  MadeUpRun alone(self_, folder_.file("alone"), some_options(), ExistingResults::refuse);
  alone.output->begin(0.0, alone.state(0.0));
  alone.steps(0, 4);
  alone.output->flush();
  for (std::size_t n = 0; n < expected_names.size(); ++n) {
    const StateHeader header = read_header(run.directory.file(expected_names[n]));
    EXPECT_EQ(header.time, expected_times[n]);
    EXPECT_EQ(header.interpolated, n == 1 || n == 2 || n == 3 || n == 5);
    EXPECT_EQ(checksum_of_file(self_, run.directory.file(expected_names[n])),
              checksum_of_file(self_, alone.directory.file(expected_names[n])));
  }
  // The states at the ends of steps are the steps' own.
  EXPECT_EQ(checksum_of_file(self_, run.directory.file("fields-000002.h5")), checksum(alone.state(0.5)));
  EXPECT_EQ(checksum_of_file(self_, run.directory.file("fields-000004.h5")), checksum(alone.state(1.0)));
  EXPECT_EQ(content_of(run.directory.file("probes.csv")), content_of(alone.directory.file("probes.csv")));
  EXPECT_EQ(content_of(run.directory.file("fields.xdmf")), content_of(alone.directory.file("fields.xdmf")));
}

TEST_F(IoTest, AContinuedRunLeavesTheSameFilesAsOneThatWasNotStopped) {
  MadeUpRun whole(comm_, folder_.file("whole"), some_options(), ExistingResults::refuse);
  whole.output->begin(0.0, whole.state(0.0));
  whole.steps(0, 4);
  whole.output->flush();

  MadeUpRun first(comm_, folder_.file("out"), some_options(), ExistingResults::refuse);
  first.output->begin(0.0, first.state(0.0));
  first.steps(0, 2);
  first.output->flush();  // a checkpoint; the run is killed one step later
  first.steps(2, 3);
  first.output->flush();
  MadeUpRun second(comm_, folder_.file("out"), some_options(), ExistingResults::keep);
  second.output->resume(2);
  if (comm_.is_root()) {
    EXPECT_EQ(second.directory.state_names().back(), "fields-000002.h5");
  }
  comm_.barrier();
  second.steps(2, 4);
  second.output->flush();
  if (!comm_.is_root()) return;
  EXPECT_EQ(second.directory.state_names(), expected_names);
  for (const std::string& name : expected_names) {
    EXPECT_EQ(checksum_of_file(self_, second.directory.file(name)), checksum_of_file(self_, whole.directory.file(name)));
  }
  for (const char* name : {"fields.xdmf", "probes.csv"}) {
    EXPECT_EQ(content_of(second.directory.file(name)), content_of(whole.directory.file(name)));
  }
  const std::string history = content_of(second.directory.file("history.csv"));
  EXPECT_EQ(std::count(history.begin(), history.end(), '\n'), 5);
}

TEST_F(IoTest, LandingWritesStatesOfStepsOnly) {
  Output::Options options = some_options();
  options.land = true;
  MadeUpRun run(comm_, folder_.file("out"), options, ExistingResults::refuse);
  EXPECT_EQ(run.output->landing_times(), (std::vector<double>{0.1, 0.2, 0.3, 0.5, 0.6}));
  run.output->begin(0.0, run.state(0.0));
  run.steps(0, 4);  // of these only 0.5 and the end are landed on
  if (comm_.is_root()) {
    EXPECT_EQ(run.directory.state_names(), (std::vector<std::string>{"fields-000000.h5", "fields-000002.h5", "fields-000004.h5"}));
  }
}

}  // namespace
}  // namespace stiffront
