// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cassert>
#include <cstddef>
#include <new>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "waymark/interface/nav_state.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark {

/// A sensor model linearised at one state: residual z ⊟ h(x), its noise R, and the Jacobians H = ∂h/∂(error state), by
/// block. A block that is not requested is zero, so plugins do not depend on the layout of the filter.
class Linearization {
 public:
  using Jacobian3 = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxUpdateRows, 3>;
  using JacobianBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUpdateRows, kMaxBlockStates>;
  enum Part { kPosition, kAttitude, kVelocity, kAngularRate };

  gaussian::Vector residual;  ///< z ⊟ h(x), rows
  gaussian::Matrix R;         ///< measurement noise covariance, rows × rows, positive definite

  /// Starts a model of `rows` rows (1..6) whose block has `block_size` states; everything is zero.
  void reset(int rows, int block_size) {
    assert(rows >= 1 && rows <= kMaxUpdateRows);
    residual.setZero(rows);
    R.setZero(rows, rows);
    used_ = 0;
    block_used_ = false;
    block_estimated_ = true;
    block_size_ = block_size;
  }

  int rows() const { return static_cast<int>(residual.size()); }

  Jacobian3& position() { return part(kPosition); }         ///< rows × 3, map frame [1/m]
  Jacobian3& attitude() { return part(kAttitude); }         ///< rows × 3, left perturbation in the map frame [1/rad]
  Jacobian3& velocity() { return part(kVelocity); }         ///< rows × 3, base frame
  Jacobian3& angular_rate() { return part(kAngularRate); }  ///< rows × 3, base frame
  JacobianBlock& block() {                                  ///< rows × the sensor's own block size
    if (!block_used_) {
      block_.setZero(rows(), block_size_);
      block_used_ = true;
    }
    return block_;
  }

  /// Makes the block consider states (S. F. Schmidt, 1966): their uncertainty is part of S, and their covariances with
  /// the other states are updated, but this update does not estimate them. Other sensors do, through those covariances.
  /// For states that correct the reading itself: its noise would be taken for information about them.
  void mark_block_considered() { block_estimated_ = false; }

  bool uses(Part p) const { return (used_ & (1u << p)) != 0; }
  bool uses_block() const { return block_used_; }
  const Jacobian3& get(Part p) const { return parts_[p]; }
  const JacobianBlock& get_block() const { return block_; }
  bool estimates_block() const { return block_estimated_; }

 private:
  Jacobian3& part(Part p) {
    if (!uses(p)) {
      parts_[p].setZero(rows(), 3);
      used_ |= 1u << p;
    }
    return parts_[p];
  }

  std::array<Jacobian3, 4> parts_;
  JacobianBlock block_;
  int block_size_ = 0;
  unsigned used_ = 0;
  bool block_used_ = false;
  bool block_estimated_ = true;
};

/// The state at which a sensor model is linearised: the navigation state and the sensor's own block.
struct StateView {
  const NavState& nav;
  const double* block;  ///< the sensor's own states, in the order it declared them
};

/// The quantity that an update observes, for monitoring and re-acquisition.
enum class Quantity {
  other,
  position,  ///< [m]; with two or more rows the first two are east and north, one row may be a distance
  attitude,  ///< [rad]: roll, pitch, heading, or some of them
  velocity,  ///< [m/s]
  height     ///< [m]
};

/// One measurement model bound to one measurement: immutable, evaluated for every particle, from many threads at once.
class WAYMARK_TYPE Update {
 public:
  virtual ~Update() = default;
  /// Fills `out`, which the host has not reset: call `out.reset(rows, block_size)` first. Pure: no side effects.
  virtual void linearize(const StateView& state, Linearization& out) const = 0;
  /// The observed quantity. The innovations of a position with two or more rows are monitored for a bias. A
  /// sensor that is rejected many times in a row is re-acquired by inflating the covariance of this quantity.
  virtual Quantity observes() const { return Quantity::other; }
};

/// The updates of one measurement, constructed in place: no heap.
class UpdateList {
 public:
  static constexpr std::size_t kSlots = 4;
  static constexpr std::size_t kSlotBytes = 512;

  UpdateList() = default;
  UpdateList(const UpdateList&) = delete;
  UpdateList& operator=(const UpdateList&) = delete;
  ~UpdateList() { clear(); }

  /// Constructs an update of type U; at most four in one measurement.
  template <class U, class... Args>
  void emplace(Args&&... args) {
    static_assert(std::is_base_of_v<Update, U> && sizeof(U) <= kSlotBytes && alignof(U) <= 64);
    assert(size_ < kSlots);
    updates_[size_] = ::new (static_cast<void*>(&storage_[size_ * kSlotBytes])) U(std::forward<Args>(args)...);
    ++size_;
  }

  /// A motion sensor reports with every measurement whether it detects motion, for the detection of standstill.
  void report_motion(bool moving) { motion_ = moving ? Motion::moving : Motion::still; }
  enum class Motion { not_reported, still, moving };
  Motion motion() const { return motion_; }

  /// σ of an unknown velocity [m/s] and of an unknown rate [rad/s].
  struct UnknownTwist {
    double velocity_sigma;
    double rate_sigma;
  };
  /// The measurement determines the twist from its stamp on until the sensor's next measurement, independently of the
  /// twist before. Velocity and rate get these σ before the updates are applied. The σ must be far above the updates'
  /// own, so that the gain is 1, but within the precision of P − W Wᵀ.
  void reset_twist(UnknownTwist unknown) { twist_reset_ = unknown; }
  const std::optional<UnknownTwist>& twist_reset() const { return twist_reset_; }

  /// The sensor reports its measurement as degraded (a frozen position, a disturbed field), with or without updates.
  /// The sensor's health is then degraded for this reason. `reason`: a literal, "position frozen while moving".
  void report_degraded(std::string_view reason) { degraded_reason_ = reason; }
  std::string_view degraded_reason() const { return degraded_reason_; }  ///< empty: none

  /// The sensor states that its measurement follows the last accepted ones without a jump, as far as the robot can have
  /// moved. If the gate rejects it nevertheless, the belief is wrong, not the sensor: the host re-acquires it at once,
  /// unless maps localise the robot.
  void report_continuous() { is_continuous_ = true; }
  bool is_continuous() const { return is_continuous_; }

  std::size_t size() const { return size_; }
  const Update& operator[](std::size_t i) const { return *updates_[i]; }
  void clear() {
    for (std::size_t i = 0; i < size_; ++i) updates_[i]->~Update();
    size_ = 0;
    motion_ = Motion::not_reported;
    twist_reset_.reset();
    degraded_reason_ = {};
    is_continuous_ = false;
  }

 private:
  alignas(64) std::array<std::byte, kSlots * kSlotBytes> storage_;
  std::array<Update*, kSlots> updates_{};
  std::size_t size_ = 0;
  Motion motion_ = Motion::not_reported;
  std::optional<UnknownTwist> twist_reset_;
  std::string_view degraded_reason_;
  bool is_continuous_ = false;
};

}  // namespace waymark
