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

/// What a sensor model says about one state: residual z ⊟ h(x), its noise R, and the Jacobians H = ∂h/∂(error state),
/// by block. A block that is never asked for counts as zero, so no plugin knows the layout of the filter.
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

  /// The block's uncertainty counts in S, and its covariances with the other states are kept up, but this update does
  /// not estimate it: other sensors do, through those covariances (S. F. Schmidt, 1966, "consider states"). For states
  /// that correct the very reading they would be estimated from: the reading's noise would be taken for information.
  void consider_block() { block_estimated_ = false; }

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

/// A state as a sensor model sees it: the navigation state and the sensor's own block.
struct StateView {
  const NavState& nav;
  const double* block;  ///< the sensor's own states, in the order it declared them
};

/// What an update observes, for monitors: innovations of a position are in metres.
enum class Quantity { other, position, attitude, velocity };

/// One measurement model bound to one measurement: immutable, evaluated for every particle, from many threads at once.
class WAYMARK_TYPE Update {
 public:
  virtual ~Update() = default;
  /// Fills `out`, which the host has not reset: call `out.reset(rows, block_size)` first. Pure: no side effects.
  virtual void linearize(const StateView& state, Linearization& out) const = 0;
  virtual Quantity observes() const { return Quantity::other; }
};

/// The updates out of one measurement, built in place: no heap.
class UpdateList {
 public:
  static constexpr std::size_t kSlots = 4;
  static constexpr std::size_t kSlotBytes = 512;

  UpdateList() = default;
  UpdateList(const UpdateList&) = delete;
  UpdateList& operator=(const UpdateList&) = delete;
  ~UpdateList() { clear(); }

  /// Constructs a model of type U; at most four in one measurement.
  template <class U, class... Args>
  void emplace(Args&&... args) {
    static_assert(std::is_base_of_v<Update, U> && sizeof(U) <= kSlotBytes && alignof(U) <= 64);
    assert(size_ < kSlots);
    updates_[size_] = ::new (static_cast<void*>(&storage_[size_ * kSlotBytes])) U(std::forward<Args>(args)...);
    ++size_;
  }

  /// A motion sensor says with every measurement whether it sees motion; the host's standstill logic needs it.
  void report_motion(bool moving) { motion_ = moving ? Motion::moving : Motion::still; }
  enum class Motion { not_said, still, moving };
  Motion motion() const { return motion_; }

  /// σ of a velocity [m/s] and of a rate [rad/s] of which nothing is known.
  struct UnknownTwist {
    double velocity_sigma;
    double rate_sigma;
  };
  /// The measurement tells the twist that the base has from its stamp on until the sensor's next one, and the twist
  /// before it says nothing about that: velocity and rate get these σ before the updates are applied. They must be far
  /// above the updates' own, so that the gain is 1, but not beyond all digits of P − W Wᵀ.
  void forget_twist(UnknownTwist unknown) { forgotten_ = unknown; }
  const std::optional<UnknownTwist>& forgotten_twist() const { return forgotten_; }

  /// The sensor doubts its own measurement (a frozen position, a disturbed field), whether it gives updates out of it
  /// or not: the host shows the sensor as degraded for this reason. `reason`: a literal, "position frozen while
  /// moving".
  void report_doubt(std::string_view reason) { doubt_ = reason; }
  std::string_view doubt() const { return doubt_; }  ///< empty: none

  std::size_t size() const { return size_; }
  const Update& operator[](std::size_t i) const { return *updates_[i]; }
  void clear() {
    for (std::size_t i = 0; i < size_; ++i) updates_[i]->~Update();
    size_ = 0;
    motion_ = Motion::not_said;
    forgotten_.reset();
    doubt_ = {};
  }

 private:
  alignas(64) std::array<std::byte, kSlots * kSlotBytes> storage_;
  std::array<Update*, kSlots> updates_{};
  std::size_t size_ = 0;
  Motion motion_ = Motion::not_said;
  std::optional<UnknownTwist> forgotten_;
  std::string_view doubt_;
};

}  // namespace waymark
