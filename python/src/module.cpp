// SPDX-License-Identifier: Apache-2.0
// The module waymark._waymark: what the package waymark is made of.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "live_robot.hpp"
#include "payload_columns.hpp"
#include "python_robot.hpp"
#include "python_state.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/payload_registry.hpp"

namespace py = pybind11;

namespace waymark::python {
namespace {

constexpr const char* kFates[] = {"fused",        "gated",    "mapped",  "skipped", "held_out", "late",
                                  "before_start", "unusable", "ignored", "paired",  "mistimed"};
static_assert(std::size(kFates) == static_cast<std::size_t>(last_of(Fate{})) + 1);

void add_errors(py::module_& module) {
  const auto error = py::register_exception<Error>(module, "Error");
  py::register_exception<ConfigError>(module, "ConfigError", error);
  py::register_exception<DataError>(module, "DataError", error);
  py::register_exception<PluginError>(module, "PluginError", error);
}

void add_rows(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(PoseRow, stamp_ns, position, orientation, yaw);
  PYBIND11_NUMPY_DTYPE(TrajectoryRow, stamp_ns, position, orientation, yaw, covariance, velocity, angular_rate,
                       effective_sample_size, sensor, fate);
  PYBIND11_NUMPY_DTYPE(SmoothedRow, stamp_ns, position, orientation, yaw, covariance);
  PYBIND11_NUMPY_DTYPE(ParticleRow, position, orientation, yaw, weight);
  PYBIND11_NUMPY_DTYPE(LandmarkRow, id, birth, position, radius_m, covariance, conditional_covariance, existence,
                       sightings, confirmed);
  PYBIND11_NUMPY_DTYPE(SightingRow, stamp_ns, position_base, landmark, is_first);
  module.attr("FATES") = py::tuple(py::cast(std::vector<std::string>(std::begin(kFates), std::end(kFates))));
}

py::object belief_or_none(const StepRecord& r, const py::object& value) { return r.started ? value : py::none(); }

void add_snapshot(py::module_& module) {
  py::class_<StepRecord>(
      module, "Snapshot",
      "The belief after one measurement. stamp_ns is the time of the belief; measurement_stamp_ns, arrival_ns, "
      "sequence, "
      "sensor (index) and fate (a word of FATES) are those of the measurement. health: \"ok\", \"degraded\" or "
      "\"lost\", "
      "and health_reason.\n\n"
      "The belief, None until the filter has started: position in the map [m], orientation (x, y, z, w), yaw [rad], "
      "velocity [m/s] and angular_rate [rad/s] in the base frame, block (the sensors' own states), covariance (of the "
      "error states, in the order of Robot.state_names), pose_covariance (of x, y, yaw), effective_sample_size, and "
      "datum "
      "(latitude, longitude [deg], height [m]). All arrays are copies.")
      .def_property_readonly("stamp_ns", [](const StepRecord& r) { return nanoseconds(r.stamp); })
      .def_property_readonly("measurement_stamp_ns",
                             [](const StepRecord& r) { return nanoseconds(r.measurement_stamp); })
      .def_property_readonly("arrival_ns", [](const StepRecord& r) { return nanoseconds(r.arrival); })
      .def_readonly("sequence", &StepRecord::sequence)
      .def_readonly("sensor", &StepRecord::sensor)
      .def_property_readonly("fate", [](const StepRecord& r) { return kFates[static_cast<int>(r.fate)]; })
      .def_readonly("started", &StepRecord::started)
      .def_property_readonly("health", [](const StepRecord& r) { return to_string(r.health); })
      .def_readonly("health_reason", &StepRecord::health_reason)
      .def_property_readonly(
          "position", [](const StepRecord& r) { return belief_or_none(r, py::cast(r.belief.mean.T_map_base.p)); })
      .def_property_readonly("orientation",
                             [](const StepRecord& r) {
                               PoseRow row{};
                               set_pose(row, r.belief.mean.T_map_base);
                               return belief_or_none(r, py::array_t<double>(4, row.orientation));
                             })
      .def_property_readonly(
          "yaw", [](const StepRecord& r) { return belief_or_none(r, py::float_(r.belief.mean.T_map_base.yaw())); })
      .def_property_readonly("velocity",
                             [](const StepRecord& r) { return belief_or_none(r, py::cast(r.belief.mean.v_base)); })
      .def_property_readonly("angular_rate",
                             [](const StepRecord& r) { return belief_or_none(r, py::cast(r.belief.mean.w_base)); })
      .def_property_readonly(
          "block",
          [](const StepRecord& r) { return belief_or_none(r, py::cast(Eigen::VectorXd(r.belief.mean.block))); })
      .def_property_readonly(
          "covariance", [](const StepRecord& r) { return belief_or_none(r, py::cast(Eigen::MatrixXd(r.belief.P))); })
      .def_property_readonly("pose_covariance",
                             [](const StepRecord& r) { return belief_or_none(r, py::cast(r.pose_covariance)); })
      .def_property_readonly("effective_sample_size",
                             [](const StepRecord& r) { return belief_or_none(r, py::float_(r.effective_sample_size)); })
      .def_property_readonly("datum", [](const StepRecord& r) -> py::object {
        if (!r.datum) return py::none();
        return py::make_tuple(r.datum->latitude_deg, r.datum->longitude_deg, r.datum->height_m);
      });
}

void add_robot(py::module_& module) {
  py::class_<PythonRobot, std::shared_ptr<PythonRobot>>(module, "Robot")
      .def(py::init([](std::filesystem::path config, std::string yaml, std::vector<std::string> overrides,
                       std::optional<std::filesystem::path> out, std::string name, std::optional<double> until_s,
                       std::optional<bool> feed, bool record, bool allow_outside,
                       std::vector<std::filesystem::path> plugin_folders) {
             return std::make_unique<PythonRobot>(RobotOptions{std::move(config), std::move(yaml), std::move(overrides),
                                                               std::move(out), std::move(name), until_s, feed, record,
                                                               allow_outside, std::move(plugin_folders)});
           }),
           py::kw_only(), py::arg("config"), py::arg("yaml"), py::arg("overrides"), py::arg("out"), py::arg("name"),
           py::arg("until_s"), py::arg("feed"), py::arg("record"), py::arg("allow_outside"), py::arg("plugin_folders"))
      .def("_step", &PythonRobot::step)
      .def("_play", &PythonRobot::play)
      .def("_finish", &PythonRobot::finish)
      .def("_suspend", &PythonRobot::suspend)
      .def("_resume", &PythonRobot::resume)
      .def("_feed", &PythonRobot::feed)
      .def("_front", &PythonRobot::front)
      .def("_grid", &PythonRobot::grid)
      .def("_report", &PythonRobot::report)
      .def("_trajectory", &PythonRobot::trajectory)
      .def("_particles", &PythonRobot::particles)
      .def("_path", &PythonRobot::path)
      .def("_reference", &PythonRobot::reference)
      .def("_smoothed", &PythonRobot::smoothed)
      .def("_landmarks", &PythonRobot::landmarks)
      .def("_sightings", &PythonRobot::sightings)
      .def("_figures", &PythonRobot::figures)
      .def("_files", &PythonRobot::files)
      .def_property_readonly("is_finished", &PythonRobot::is_finished)
      .def_property_readonly("is_fed", &PythonRobot::is_fed)
      .def_property_readonly("waiting", &PythonRobot::waiting)
      .def_property_readonly("started", &PythonRobot::started)
      .def_property_readonly("config", &PythonRobot::config)
      .def_property_readonly("sensor_names", &PythonRobot::sensor_names)
      .def_property_readonly("map_names", &PythonRobot::map_names)
      .def_property_readonly("state_names", &PythonRobot::state_names);
}

py::list events_of(const LiveRobot& live) {
  py::list events;
  for (const Event& event : live.view().events())
    events.append(py::dict(py::arg("stamp_ns") = nanoseconds(event.stamp), py::arg("text") = event.text,
                           py::arg("is_failure") = event.is_failure));
  return events;
}

void add_live_robot(py::module_& module) {
  py::class_<LiveRobot>(module, "_LiveRobot")
      .def(py::init([](std::filesystem::path config, std::string yaml, std::vector<std::string> overrides,
                       std::optional<std::filesystem::path> out, std::string name, std::optional<double> until_s,
                       bool record, bool allow_outside, std::vector<std::filesystem::path> plugin_folders) {
             return std::make_unique<LiveRobot>(RobotOptions{std::move(config), std::move(yaml), std::move(overrides),
                                                             std::move(out), std::move(name), until_s, std::nullopt,
                                                             record, allow_outside, std::move(plugin_folders)});
           }),
           py::kw_only(), py::arg("config"), py::arg("yaml"), py::arg("overrides"), py::arg("out"), py::arg("name"),
           py::arg("until_s"), py::arg("record"), py::arg("allow_outside"), py::arg("plugin_folders"))
      .def("front", [](const LiveRobot& live) { return live.view().front(); })
      .def("last", [](const LiveRobot& live) { return live.view().last(); })
      .def("health",
           [](const LiveRobot& live) {
             const LiveView::HealthNow health = live.view().health();
             return py::make_tuple(to_string(health.state), health.reason);
           })
      .def("events", &events_of)
      .def("wait", &LiveRobot::wait)
      .def("stop", &LiveRobot::stop)
      .def_property_readonly("robot", &LiveRobot::robot)
      .def_property_readonly("is_running", &LiveRobot::is_running);
}

/// Names, units and meanings of the fields of each payload.
py::dict payloads() {
  py::dict out;
  for (const KnownPayload& known : known_payloads()) {
    py::dict fields;
    for (const FieldSpec& spec : fields_of(*known.make())) {
      if (spec.kind == FieldSpec::Kind::list) continue;
      for (const std::string_view name : spec.info.names) {
        if (!name.empty()) {
          fields[py::str(name.data(), name.size())] =
              py::make_tuple(std::string(spec.info.unit), std::string(spec.info.meaning), spec.info.required);
        }
      }
    }
    const std::string_view name = is_of_core(known.type) ? short_type_name(known.type) : known.type;
    out[py::str(std::string(name))] = fields;
  }
  return out;
}

void add_all(py::module_& module) {
  add_errors(module);
  add_rows(module);
  add_snapshot(module);
  add_state(module);
  add_config(module);
  add_factories(module);
  add_contract_kit(module);
  add_robot(module);
  add_live_robot(module);
  module.def("payloads", &payloads,
             "The payloads of core, by name, and those that loaded plugins registered, by their full name: the fields, "
             "by name, as (unit, meaning, whether it must be given).");
  module.attr("PLUGIN_FOLDER") = WAYMARK_PLUGIN_FOLDER;
  module.attr("PROGRAM") = WAYMARK_PROGRAM;
}

}  // namespace
}  // namespace waymark::python

PYBIND11_MODULE(_waymark, module) { waymark::python::add_all(module); }
