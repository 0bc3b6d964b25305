// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>

#include "course.hpp"
#include "waymark/archive.hpp"
#include "waymark/config.hpp"
#include "waymark/measurement.hpp"
#include "waymark/source.hpp"
#include "windows.hpp"
#include "world.hpp"

namespace waymark::simulator {

/// One degree in radians, for keys that end in `_deg`.
inline constexpr double kDegree = std::numbers::pi / 180.0;

/// What every simulated sensor looks at. Kept by the source; never null.
struct Truth {
  Trajectory trajectory;
  World world;
  std::uint64_t seed;
};

/// A sensor that samples the truth at a constant rate. Times count from the start of the run.
class SimulatedSensor {
 public:
  virtual ~SimulatedSensor() = default;
  SimulatedSensor(const SimulatedSensor&) = delete;
  SimulatedSensor& operator=(const SimulatedSensor&) = delete;

  const Channel& channel() const { return channel_; }
  Duration next_stamp() const;
  Duration next_arrival() const { return next_stamp() + delay_; }

  /// Takes the next sample; null if the sensor delivers nothing at this time.
  std::shared_ptr<const Payload> take(const Truth& truth);

  void save(OutArchive& archive) const;
  void load(InArchive& archive);

 protected:
  /// Reads `sensor`, `rate_hz` and `delay_s`. `phase` is the time of the first sample in periods, different for each
  /// kind, so that the sensors are not synchronised.
  SimulatedSensor(const Config& config, std::string_view payload_type, double default_rate_hz, double phase);
  double period_s() const { return 1.0 / rate_hz_; }

 private:
  virtual std::shared_ptr<const Payload> sample(const Truth& truth, Duration stamp) = 0;
  virtual void save_state(OutArchive&) const {}
  virtual void load_state(InArchive&) {}

  Channel channel_;
  double rate_hz_;
  double phase_;
  Duration delay_;
  std::int64_t taken_ = 0;
};

/// Differential drive: speeds of the wheels at the stamp, with scale errors, white noise, and spans of time in which
/// both wheels spin (or slide).
class SimulatedWheels : public SimulatedSensor {
 public:
  explicit SimulatedWheels(const Config& config);

 private:
  std::shared_ptr<const Payload> sample(const Truth& truth, Duration stamp) override;

  double track_m_;
  double noise_m_per_sqrt_s_;
  double left_scale_;
  double right_scale_;
  double spin_ratio_;
  Windows spins_;
};

/// Fixes of an antenna in the map's frame, with white noise, a first-order Gauss–Markov offset, and an offset that
/// jumps when the satellites change.
class SimulatedGps : public SimulatedSensor {
 public:
  explicit SimulatedGps(const Config& config);

 private:
  std::shared_ptr<const Payload> sample(const Truth& truth, Duration stamp) override;
  void save_state(OutArchive& archive) const override;
  void load_state(InArchive& archive) override;
  void change_satellites(std::uint64_t seed, Duration stamp, bool first);
  double degradation() const;

  Eigen::Vector3d p_base_antenna_;
  double sigma_m_;
  double sigma_up_m_;
  double correlated_sigma_m_;
  double correlation_time_s_;
  double satellite_change_mean_s_;  // 0: never
  double jump_sigma_m_;
  Windows outages_;
  Eigen::Vector3d offset_{0.0, 0.0, 0.0};  // east, north, up [m]; drawn from its stationary law with the first sample
  Eigen::Vector3d jump_{0.0, 0.0, 0.0};    // until the satellites change [m]
  int satellites_ = -1;                    // -1: not simulated
};

}  // namespace waymark::simulator
