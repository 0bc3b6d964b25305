// SPDX-License-Identifier: Apache-2.0
// The contract kit on sensors and map modules that are written in Python.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "measurement_block.hpp"
#include "python_state.hpp"
#include "waymark/host/fusion_settings.hpp"
#include "waymark/testing.hpp"

namespace py = pybind11;

namespace waymark::python {
namespace {

using Poses = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

void append(testing::Violations& found, testing::Violations more) {
  for (std::string& violation : more) found.push_back(std::move(violation));
}

testing::Violations check_sensor(const std::string& yaml, const std::string& motion, const py::object& stamps,
                                 const std::string& payload, const py::dict& columns) {
  if (motion != "planar" && motion != "spatial")
    throw std::invalid_argument("motion: \"" + motion + "\" is none of planar, spatial");
  const MeasurementBlock block("sensor", stamps, py::none(), payload, columns);
  const py::gil_scoped_release released;
  const std::vector<Measurement> measurements = block.make(0);
  const auto make = [](const Config& entry) {
    return std::unique_ptr<Sensor>(make_sensor(entry, Rig({read_mounting(entry)})));
  };
  testing::Violations found = testing::check_keys([&](const Config& entry) { make(entry); }, yaml);
  const std::unique_ptr<Sensor> sensor = make(Config::parse(yaml));
  append(found, testing::check_sensor(*sensor, measurements,
                                      motion == "planar" ? StateLayout::Motion::planar : StateLayout::Motion::spatial));
  return found;
}

testing::Violations check_map_module(const std::string& yaml, const std::optional<Eigen::Matrix4d>& T_base_sensor,
                                     const Poses& poses, const py::object& stamps, const std::string& payload,
                                     const py::dict& columns) {
  const MeasurementBlock block("sensor", stamps, py::none(), payload, columns);
  if (static_cast<std::size_t>(poses.rows()) != block.size())
    throw std::invalid_argument(std::to_string(poses.rows()) + " poses for " + std::to_string(block.size()) +
                                " stamps");
  const py::gil_scoped_release released;
  std::vector<testing::MappingStep> steps;
  steps.reserve(block.size());
  for (Measurement& trigger : block.make(0)) {
    const Eigen::Index row = static_cast<Eigen::Index>(steps.size());
    steps.push_back({std::move(trigger), Pose::planar(poses(row, 0), poses(row, 1), poses(row, 2))});
  }
  Mounting mounting{Config::parse(yaml).texts("inputs").front(), std::string(block.type()), std::nullopt};
  if (T_base_sensor) {
    const Eigen::Matrix3d R = T_base_sensor->topLeftCorner<3, 3>();
    mounting.T_base_sensor = Pose{Eigen::Quaterniond(R), T_base_sensor->topRightCorner<3, 1>()};
  }
  const Rig rig({std::move(mounting)});
  const auto make = [&rig](const Config& entry) { return std::unique_ptr<MapModule>(make_map_module(entry, rig)); };
  testing::Violations found = testing::check_keys([&](const Config& entry) { make(entry); }, yaml);
  append(found, testing::check_map_module(*make(Config::parse(yaml)), steps));
  return found;
}

}  // namespace

void add_contract_kit(py::module_& module) {
  module.def("_check_sensor", &check_sensor);
  module.def("_check_map_module", &check_map_module);
}

}  // namespace waymark::python
