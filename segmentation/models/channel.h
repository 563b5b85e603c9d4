#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/models/tensor.h"

namespace pliant {

/// What the program asks of the process that runs a network, and what that answers.
struct Message {
  enum class Kind : uint32_t { kLoad, kRun, kDone, kFailed, kNoMemory };

  Kind kind = Kind::kDone;
  std::string text;                ///< file to load, method to run, or what went wrong
  std::vector<std::string> names;  ///< of the tensors asked for
  std::vector<Tensor> tensors;
  uint64_t threads = 0, memory = 0;  ///< of kLoad
};

/// One end of a socket over which whole messages go.
class Channel {
 public:
  enum class Received { kMessage, kClosed, kTooLate, kTooBig };

  explicit Channel(int descriptor) : descriptor_(descriptor) {}
  ~Channel();
  Channel(const Channel&) = delete;

  /// False when the other end is gone or takes longer than `seconds`.
  bool send(const Message& message, double seconds);
  /// Waits at most `seconds`; a message of more than `most` bytes is not taken.
  Received receive(Message& message, double seconds, uint64_t most);

 private:
  int descriptor_;
};

}  // namespace pliant
