// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "comparison.hpp"
#include "dead_reckoning.hpp"

namespace waymark::host::diagnosis {

/// The positions of a receiver against dead reckoning, in blocks of tens of seconds, each of which is turned and moved
/// for itself: shapes are compared, so robots that turn often are no worse than others.
class PathFit {
 public:
  /// Whose stamps the way has.
  enum class WayOf {
    others,   ///< those of the yaw
    receiver  ///< those of the fixes: it is as late as they are
  };
  /// The receiver and the tracks must outlive the object.
  PathFit(const WatchedSensor& receiver, const Track& yaw, const Way& way, WayOf of = WayOf::others);

  using Block = std::pair<std::vector<Fix>::const_iterator, std::vector<Fix>::const_iterator>;

  /// How one block fits.
  struct OfBlock {
    std::complex<double> turn;  ///< from the frame of dead reckoning, with the scale
    double mean_square = 0.0;   ///< of what is left [m²]
    double size = 0.0;          ///< root mean square of the positions about their middle [m]
    bool is_same() const;       ///< the path, but for noise
  };
  /// A hypothesis about the positions against what the YAML says.
  struct Gain {
    double mean = 0.0;    ///< by which the logarithm of what is left is less, over the blocks
    double sigmas = 0.0;  ///< how far that is from 0
    double left = 0.0;    ///< of the size of a block, the median over the blocks
    std::size_t blocks = 0;
    bool is_clear() const;
  };

  bool is_known() const;  ///< there are blocks enough
  /// The same positions with this dead reckoning against another one, both as given.
  Gain gain_over(const PathFit& other) const;
  /// East or north with the other sign, or both swapped.
  Gain mirrored() const { return gain(0.0, true); }
  /// The delay of seconds with which the positions fit, if they do not without it.
  std::optional<Lag> late() const;
  /// True if the positions turn as the yaw does, by as much and to the same side.
  bool turns_alike() const;
  /// How far the direction in which the robot drives lies beside a heading; nothing if too few blocks fit.
  std::optional<Angle> beside(const Track& heading) const;

 private:
  DeadReckoning path_if(double late) const;
  std::optional<OfBlock> fit(const DeadReckoning& path, const Block& block, double late, bool is_mirrored) const;
  /// Of hypotheses about the blocks against as many others.
  static Gain gain_of(const std::vector<std::optional<OfBlock>>& ours,
                      const std::vector<std::optional<OfBlock>>& theirs);
  Gain gain(double late, bool is_mirrored) const;
  /// What is left of a block with the antenna wherever it fits best, within reach [m²].
  std::optional<double> left_with_antenna(const Block& block) const;
  /// The gain of an antenna that stands elsewhere, over the blocks; 0 if none fits.
  double gain_of_antenna() const;

  const Track& yaw_;
  Way way_;
  WayOf way_of_;
  DeadReckoning path_;
  std::vector<Fix> fixes_;
  std::vector<Block> blocks_;
  std::complex<double> antenna_;  ///< in the base frame [m]
  std::vector<std::optional<OfBlock>> as_given_;
};

}  // namespace waymark::host::diagnosis
