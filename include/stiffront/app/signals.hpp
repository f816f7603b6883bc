// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>

#include "stiffront/control/method.hpp"

namespace stiffront::app {

/// What a run may be asked to do from outside, as flags of the step agreement.
namespace requests {
inline constexpr std::uint64_t checkpoint = step_flags::first_of_driver;
inline constexpr std::uint64_t stop = step_flags::first_of_driver << 1;
}  // namespace requests

/// Signals to this process while the object lives: USR1 asks for a checkpoint, USR2, TERM and INT for a checkpoint and the end. A second
/// TERM or INT ends the process at once.
class SignalRequests {
 public:
  SignalRequests();
  SignalRequests(const SignalRequests&) = delete;
  SignalRequests& operator=(const SignalRequests&) = delete;
  ~SignalRequests();

  /// What was asked for since the last call.
  std::uint64_t take();
};

/// Files named CHECKPOINT and STOP in the output directory ask for the same; each is removed when it is obeyed. Looked for once a second.
class FileRequests {
 public:
  explicit FileRequests(std::string directory) : directory_(std::move(directory)) {}
  std::uint64_t take();

 private:
  std::string directory_;
  double looked_ = 0.0;
};

}  // namespace stiffront::app
