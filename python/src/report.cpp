// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include "python_robot.hpp"
#include "waymark/interface/finding.hpp"
#include "waymark/interface/sensor_summary.hpp"

namespace py = pybind11;

namespace waymark::python {
namespace {

py::dict sensor_dict(const SensorReport& sensor) {
  const SensorSummary summary = summarize(sensor);
  py::dict out;
  out["plugin"] = sensor.plugin;
  out["measurements"] = sensor.measurements;
  out["rate_hz"] = summary.rate_hz;
  out["fused"] = sensor.fused;
  out["gated"] = sensor.gated;
  out["mapped"] = sensor.mapped;
  out["skipped"] = sensor.skipped;
  out["held_out"] = sensor.held_out;
  out["late"] = sensor.late;
  out["before_start"] = sensor.before_start;
  out["unusable"] = sensor.unusable;
  out["ignored"] = sensor.ignored;
  out["mistimed"] = sensor.mistimed;
  out["nis_sum"] = sensor.nis_sum;
  out["nis_count"] = sensor.nis_count;
  out["nis_dof"] = sensor.nis_dof;
  out["nis_ratio"] = summary.nis_ratio;
  out["verdict"] = summary.verdict;
  return out;
}

py::dict event_dict(const Event& event) {
  py::dict out;
  out["stamp_ns"] = nanoseconds(event.stamp);
  out["text"] = event.text;
  out["is_failure"] = event.is_failure;
  return out;
}

py::dict report_dict(const RunReport& report) {
  py::dict out;
  py::dict sensors;
  for (const SensorReport& sensor : report.sensors) sensors[py::str(sensor.name)] = sensor_dict(sensor);
  out["sensors"] = sensors;
  py::list events;
  for (const Event& event : report.events) events.append(event_dict(event));
  out["events"] = events;
  py::dict health;
  health["ok_s"] = report.health.ok_s;
  health["degraded_s"] = report.health.degraded_s;
  health["lost_s"] = report.health.lost_s;
  out["health"] = health;
  py::dict matches;
  for (const MatchReport& match : report.matches) {
    py::dict of_map;
    of_map["matches"] = match.matches;
    of_map["failed"] = match.failed;
    of_map["searches"] = match.searches;
    matches[py::str(match.map)] = of_map;
  }
  out["matches"] = matches;
  py::list findings;
  for (const Finding& finding : report.findings) findings.append(describe(finding));
  out["findings"] = findings;
  py::list bad;
  for (const BadRecord& record : report.bad_records) bad.append(py::make_tuple(record.place, record.reason));
  out["bad_records"] = bad;
  out["notices"] = report.notices;
  out["resamplings"] = report.resamplings;
  out["mapping_steps"] = report.mapping_steps;
  return out;
}

}  // namespace

py::dict PythonRobot::report() const {
  py::dict out = report_dict(run_report());
  const host::SessionResult none;
  const host::SessionResult& result = result_ ? *result_ : none;
  out["failures"] = result.failures;
  out["lost"] = result.lost;
  out["log_error"] = result.log_error;
  out["replaced"] = result.replaced;
  out["started"] = started();
  return out;
}

}  // namespace waymark::python
