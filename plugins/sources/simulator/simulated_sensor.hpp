// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "course.hpp"
#include "faults.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/interface/source.hpp"
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

/// What a sensor sends at one time.
struct Sample {
  Duration time;                           ///< when it was measured
  Duration stamp;                          ///< what the sensor's clock showed
  Duration arrival;                        ///< when it is received
  std::shared_ptr<const Payload> payload;  ///< null: the sensor delivered nothing
};

/// A sensor that samples the truth at a constant rate. Times count from the start of the run.
class SimulatedSensor {
 public:
  virtual ~SimulatedSensor() = default;
  SimulatedSensor(const SimulatedSensor&) = delete;
  SimulatedSensor& operator=(const SimulatedSensor&) = delete;

  const Channel& channel() const { return channel_; }

  /// When the next sample arrives of those measured until `end`; Duration::max() if there is none.
  Duration next_arrival(const Truth& truth, Duration end);
  /// The sample that `next_arrival`, to be called before, has announced.
  Sample take(const Truth& truth);

 protected:
  /// Reads `sensor`, `rate_hz` and the faults that all sensors can have. `phase` is the time of the first sample in
  /// periods, different for each kind, so that the sensors are not synchronised.
  SimulatedSensor(const Config& config, std::string_view payload_type, double default_rate_hz, double phase);
  double period_s() const { return 1.0 / rate_hz_; }

 private:
  /// A sample that is on its way, or has overtaken one that is.
  struct Underway {
    Sample sample;
    bool delivered = false;
  };

  /// What the sensor measures at `time`, in order of time; null if it delivers nothing.
  virtual std::shared_ptr<Payload> sample(const Truth& truth, Duration time) = 0;

  Duration next_time() const;
  Sample measure(const Truth& truth);
  std::vector<Underway>::iterator first_to_arrive();

  Channel channel_;
  double rate_hz_;
  double phase_;
  Faults faults_;
  std::int64_t taken_ = 0;          // measured so far
  std::vector<Underway> underway_;  // in order of time, the first not delivered; empty if nothing can overtake
};

}  // namespace waymark::simulator
