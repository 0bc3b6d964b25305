// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "waymark/interface/payloads.hpp"
#include "waymark/interface/sensor.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::sensor_test {

inline std::shared_ptr<Sensor> make_sensor(std::string_view plugin, const std::string& yaml) {
  const Config config = Config::parse(yaml);
  auto sensor = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Sensor>(plugin, config, Rig({}));
  config.reject_unread();
  return sensor;
}

/// The text of the ConfigError that the constructor throws; a failure if there is none.
inline std::string refusal(std::string_view plugin, const std::string& yaml) {
  try {
    make_sensor(plugin, yaml);
  } catch (const ConfigError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error: " << yaml;
  return "";
}

template <class P>
Measurement measurement_of(P payload, double t = 100.0) {
  Measurement m;
  m.stamp = m.arrival = Time{from_seconds(t)};
  m.payload = std::make_shared<P>(std::move(payload));
  return m;
}

/// One sensor, alone in its filter, with a mean at the map's origin.
class SensorBench {
 public:
  explicit SensorBench(std::shared_ptr<Sensor> sensor, StateLayout::Motion motion = StateLayout::Motion::planar)
      : sensor_(std::move(sensor)), layout_(motion, {{"sensor", sensor_->block()}}) {
    mean.block.setZero(layout_.block_size());
  }

  /// Processes a measurement that must give one update, and linearises it at `mean`.
  const Linearization& feed(const Measurement& measurement) {
    updates_.clear();
    Belief belief;
    belief.stamp = measurement.stamp;
    belief.mean = mean;
    belief.P.setIdentity(layout_.size(), layout_.size());
    sensor_->process(measurement, {belief, layout_, mean.block.data(), datum ? &*datum : nullptr, false}, updates_);
    if (updates_.size() != 1) {
      ADD_FAILURE() << updates_.size() << " updates";
    } else {
      updates_[0].linearize({mean, mean.block.data()}, model_);
    }
    return model_;
  }

  const Sensor& sensor() const { return *sensor_; }
  UpdateList::Motion motion() const { return updates_.motion(); }
  const std::optional<UpdateList::UnknownTwist>& twist_reset() const { return updates_.twist_reset(); }

  NavState mean;
  std::optional<Datum> datum;

 private:
  std::shared_ptr<Sensor> sensor_;
  StateLayout layout_;
  UpdateList updates_;
  Linearization model_;
};

}  // namespace waymark::sensor_test
