// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "stiffront/core/simd.hpp"
#include "stiffront/model/expression.hpp"

namespace stiffront {

/// A straight-line program over registers that evaluates several nodes of an expression graph together, for one cell (double), a
/// pack of cells, or several packs at a time.
///
/// Common parts are computed once, what is not needed is not there, and registers are used again as soon as their value has been
/// read for the last time, so that they stay in the first-level cache. One instruction does up to three operations, e.g. k*(a - b),
/// but each with its own rounding: a value has the bits of the graph's operations, whatever else the program computes.
class ExpressionProgram {
 public:
  /// The empty program.
  ExpressionProgram() = default;
  /// Inputs are the graph's variables; outputs are numbered as given.
  /// @throws Error(input) if the program would need more than 65535 registers or constants.
  ExpressionProgram(const ExpressionGraph& graph, const std::vector<ExpressionGraph::Node>& outputs);

  int n_outputs() const { return static_cast<int>(outputs_.size()); }
  /// Whether anything depends on input k, so that it must be set.
  bool uses_input(int k) const { return uses_input_[static_cast<std::size_t>(k)]; }
  int n_registers() const { return n_registers_; }
  int n_instructions() const { return static_cast<int>(instructions_.size()); }

  template <class T, int n_together>
  class Frame;

  enum class Code : std::uint16_t;
  struct Instruction {
    Code code;
    std::uint16_t result;
    std::uint16_t a, b, c;  // registers; of a comparison with a choice, k is a register too
    std::uint16_t k, l;     // constants
  };

 private:
  /// More than any but the largest models need. Not a multiple of 4 KiB apart, the frames of several packs do not contend for the
  /// same places in the cache.
  static constexpr int few_registers = 136;

  /// An output that is a constant: nothing else is ever written to its register.
  struct ConstantOutput {
    std::uint16_t register_number;
    double value;
  };

  /// Runs n_together frames, few_registers apart if there are several.
  template <class T, int n_together>
  void run(T* registers) const;

  std::vector<Instruction> instructions_;
  std::vector<double> constants_;
  std::vector<bool> uses_input_;
  std::vector<std::uint16_t> outputs_;  ///< their registers
  std::vector<ConstantOutput> constant_outputs_;
  int n_registers_ = 0;
};

/// Evaluations of a program for n_together cells (T = double) or packs of cells (T = Pack): set the inputs, run, read the outputs; again
/// and again if need be. Inputs stay as they were set.
template <class T, int n_together>
class ExpressionProgram::Frame {
 public:
  explicit Frame(const ExpressionProgram& program) : program_(program) {
    if (program.n_registers_ > few_registers) {
      many_ = std::make_unique_for_overwrite<T[]>(static_cast<std::size_t>(program.n_registers_) * n_together);
      registers_ = many_.get();
      distance_ = program.n_registers_;
    }
    for (const ConstantOutput& output : program.constant_outputs_) {
      for (int i = 0; i < n_together; ++i) registers_[i * distance_ + output.register_number] = T(output.value);
    }
  }
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;

  T& input(int k, int i = 0) { return registers_[i * distance_ + k]; }
  void run() {
    if (distance_ == few_registers) {
      program_.run<T, n_together>(registers_);
    } else {
      for (int i = 0; i < n_together; ++i) program_.run<T, 1>(registers_ + i * distance_);
    }
  }
  T output(int k, int i = 0) const { return values(i).output(k); }

  /// Inputs and outputs of one of the cells or packs, without the way through the frame: for the innermost loops.
  class Values {
   public:
    Values(const T* registers, const std::uint16_t* outputs) : registers_(registers), outputs_(outputs) {}
    T input(int k) const { return registers_[k]; }
    T output(int k) const { return registers_[outputs_[k]]; }

   private:
    const T* registers_;
    const std::uint16_t* outputs_;
  };
  Values values(int i) const { return {registers_ + i * distance_, program_.outputs_.data()}; }

 private:
  const ExpressionProgram& program_;
  T* registers_ = few_;
  int distance_ = few_registers;
  std::unique_ptr<T[]> many_;
  T few_[few_registers * n_together];
};

}  // namespace stiffront
