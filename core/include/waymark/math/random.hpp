// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "waymark/base/api.hpp"

namespace waymark {

/// A counter-based random stream: Philox 4x32-10 (J. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3",
/// SC 2011). The stream is a pure function of its key, so results do not depend on threads or call order.
class WAYMARK_API Random {
 public:
  /// Key of a stream. Different keys give independent streams.
  struct Key {
    std::uint64_t seed;    ///< of the run
    std::uint32_t slot;    ///< of the particle
    std::int64_t stamp;    ///< of the measurement [ns]
    std::uint32_t sensor;  ///< index of the sensor, or another purpose of the draw
  };

  explicit Random(const Key& key);

  /// Uniform in the open interval (0, 1).
  double uniform();

  /// Standard normal, by Box–Muller.
  double normal();

 private:
  std::uint32_t next();

  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;
  std::array<std::uint32_t, 4> block_{};
  int used_ = 4;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace waymark
