// SPDX-License-Identifier: Apache-2.0
// What a robot shows of its particles and maps, as arrays.
#include <pybind11/stl.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "python_robot.hpp"
#include "waymark/base/error.hpp"

namespace py = pybind11;

namespace waymark::python {
namespace {

template <class Row>
py::object as_array(const std::vector<Row>& rows) {
  return py::array_t<Row>(static_cast<py::ssize_t>(rows.size()), rows.data());
}

}  // namespace

py::object PythonRobot::trajectory() const {
  const Turn turn(*this);
  return as_array(rows_);
}

py::object PythonRobot::particles() const {
  const Turn turn(*this);
  std::vector<ParticleRow> rows;
  {
    const py::gil_scoped_release released;
    session_->fusion().visit_last([&](const Snapshot& last) {
      if (!last.started()) return;
      for (const ParticleView& particle : last.particles()) {
        ParticleRow row{};
        set_pose(row, particle.T_map_base);
        row.weight = particle.weight;
        rows.push_back(row);
      }
    });
  }
  return as_array(rows);
}

py::object PythonRobot::path() const {
  const Turn turn(*this);
  std::vector<PoseRow> rows;
  {
    const py::gil_scoped_release released;
    session_->fusion().visit_last([&](const Snapshot& last) {
      if (!last.started()) return;
      for (const StampedPose& pose : last.best_path()) {
        PoseRow row{nanoseconds(pose.stamp), {}, {}, 0.0};
        set_pose(row, pose.T_map_base);
        rows.push_back(row);
      }
    });
  }
  return as_array(rows);
}

py::object PythonRobot::reference() const {
  const Turn turn(*this);
  std::vector<PoseRow> rows;
  {
    const py::gil_scoped_release released;
    if (const auto truth = session_->robot().source->reference()) {
      for (const Reference::Point& point : truth->trajectory) {
        PoseRow row{nanoseconds(point.stamp), {}, {}, 0.0};
        set_pose(row, point.T_map_base);
        if (!point.has_yaw) row.yaw = std::numeric_limits<double>::quiet_NaN();
        rows.push_back(row);
      }
    }
  }
  return as_array(rows);
}

py::object PythonRobot::smoothed() const {
  const Turn turn(*this);
  std::vector<SmoothedRow> rows;
  if (result_) {
    for (const SmoothedPose& pose : result_->report.smoothed) {
      SmoothedRow row{};
      row.stamp_ns = nanoseconds(pose.stamp);
      set_pose(row, pose.T_map_base);
      set_matrix(row.covariance, pose.P);
      rows.push_back(row);
    }
  }
  return as_array(rows);
}

MapDescription PythonRobot::describe(const std::string& map, MapDetail detail) const {
  const py::gil_scoped_release released;
  const std::vector<MapSlot>& maps = session_->robot().maps;
  if (std::ranges::find(maps, map, &MapSlot::name) == maps.end()) {
    std::string names;
    for (const MapSlot& slot : maps) names += (names.empty() ? "" : ", ") + slot.name;
    throw Error("there is no map \"" + map + "\"" + (names.empty() ? "; the robot has none" : "; there is " + names));
  }
  MapDescription found;
  session_->fusion().visit_last([&](const Snapshot& last) {
    if (!last.started()) return;
    for (MapDescription& description : last.best_maps(detail)) {
      if (description.module == map) found = std::move(description);
    }
  });
  return found;
}

py::object PythonRobot::landmarks(const std::string& map) const {
  const Turn turn(*this);
  const MapDescription description = describe(map, MapDetail::summary);
  std::vector<LandmarkRow> rows;
  rows.reserve(description.landmarks.size());
  for (const LandmarkView& view : description.landmarks) {
    LandmarkRow row{};
    row.id = view.id;
    row.birth = view.birth;
    for (int i = 0; i < 2; ++i) row.position[i] = view.p_map(i);
    row.radius_m = view.radius_m;
    set_matrix(row.covariance, view.P);
    set_matrix(row.conditional_covariance, view.P_conditional);
    row.existence = view.existence;
    row.sightings = view.sightings;
    row.confirmed = view.confirmed;
    rows.push_back(row);
  }
  return as_array(rows);
}

py::object PythonRobot::sightings(const std::string& map) const {
  const Turn turn(*this);
  const MapDescription description = describe(map, MapDetail::summary);
  std::vector<SightingRow> rows;
  rows.reserve(description.sightings.size());
  for (const Sighting& sighting : description.sightings) {
    rows.push_back({nanoseconds(sighting.stamp),
                    {sighting.p_base.x(), sighting.p_base.y()},
                    sighting.landmark,
                    sighting.is_first});
  }
  return as_array(rows);
}

py::object PythonRobot::grid(const std::string& map, bool is_mixture) const {
  const Turn turn(*this);
  MapDescription description = describe(map, is_mixture ? MapDetail::with_mixtures : MapDetail::with_grids);
  std::optional<GridView>& view = is_mixture ? description.mixture : description.grid;
  if (!view) return py::none();
  py::dict out;
  const Pose& pose = view->T_map_grid;
  out["position"] = py::cast(std::vector<double>{pose.p.x(), pose.p.y(), pose.p.z()});
  out["yaw"] = pose.yaw();
  out["resolution_m"] = view->resolution_m;
  // Without a copy: the array owns the cells.
  auto* cells = new std::vector<std::uint8_t>(std::move(view->cells));
  const py::capsule owner(cells, [](void* p) { delete static_cast<std::vector<std::uint8_t>*>(p); });
  out["cells"] = py::array_t<std::uint8_t>({view->height, view->width}, cells->data(), owner);
  return out;
}

py::dict PythonRobot::figures(const std::string& map) const {
  const Turn turn(*this);
  py::dict out;
  for (const MapFigure& figure : describe(map, MapDetail::summary).figures) out[py::str(figure.name)] = figure.value;
  return out;
}

py::dict PythonRobot::files(const std::string& map) const {
  const Turn turn(*this);
  py::dict out;
  for (const MapFile& file : describe(map, MapDetail::with_files).files)
    out[py::str(file.extension)] = py::bytes(file.content);
  return out;
}

}  // namespace waymark::python
