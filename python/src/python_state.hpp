// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "python_call.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/sensor.hpp"

namespace waymark::python {

/// A state at which a model is evaluated, with the sensor's own block, by value.
struct PythonState {
  NavState nav;
  BlockVector block;
  /// The state moved by a small error: position and attitude in the map frame, velocity and rate in the base frame,
  /// then the block.
  PythonState moved(const Eigen::VectorXd& delta) const;
};

/// What `process` may look at.
struct PythonPrediction {
  PythonState state;
  Eigen::MatrixXd covariance;
  Eigen::Matrix3d pose_covariance;
  bool planar = false;
  bool standing = false;
  std::optional<Datum> datum;
};

/// What `process` fills: the updates, and what it reports.
struct PythonUpdates {
  std::vector<Held> updates;
  UpdateList::Motion motion = UpdateList::Motion::not_reported;
  std::optional<UpdateList::UnknownTwist> twist_reset;
  std::string degraded_reason;
  bool is_continuous = false;
};

/// Reads a model from the dictionary that `linearize` returned. Throws std::runtime_error for wrong names and shapes.
void read_linearization(const pybind11::handle& returned, int block_size, Linearization& out);

/// Adds State, Prediction, Updates and Config to the module.
void add_state(pybind11::module_& module);
void add_config(pybind11::module_& module);

/// An object of the class that was registered as `name`, built from its entry of the YAML. `sensor`: whose mounting it
/// gets. Throws ConfigError if there is no such class. The GIL is held.
pybind11::object make_registered(const char* kind, const std::string& name, const std::string& sensor,
                                 const Config& config, const Rig& rig);
/// What the plugins `python_sensor` and `python_map` make of their entry of the YAML; the caller owns it.
Sensor* make_sensor(const Config& config, const Rig& rig);
MapModule* make_map_module(const Config& config, const Rig& rig);

/// Adds the capsules with which the plugins `python_sensor` and `python_map` make their objects.
void add_factories(pybind11::module_& module);

/// Adds the contract kit (contract_kit.cpp).
void add_contract_kit(pybind11::module_& module);

}  // namespace waymark::python
