// SPDX-License-Identifier: Apache-2.0
// A sensor whose class is written in Python: the host calls it like any other, the GIL is taken for each call.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "measurement_view.hpp"
#include "python_state.hpp"
#include "rows.hpp"
#include "waymark/base/error.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/rig.hpp"

namespace py = pybind11;

namespace waymark::python {
namespace {

/// Reasons must be literals: each text is kept once, for ever.
std::string_view literal(const std::string& text) {
  static std::mutex mutex;
  static std::set<std::string> texts;
  const std::lock_guard lock(mutex);
  return *texts.insert(text).first;
}

Quantity quantity_of(const py::object& update) {
  if (!py::hasattr(update, "observes")) return Quantity::other;
  const auto word = py::cast<std::string>(update.attr("observes"));
  if (word == "other") return Quantity::other;
  if (word == "position") return Quantity::position;
  if (word == "attitude") return Quantity::attitude;
  if (word == "velocity") return Quantity::velocity;
  if (word == "height") return Quantity::height;
  throw std::runtime_error("observes: \"" + word + "\" is none of other, position, attitude, velocity, height");
}

/// An update that a Python object linearises.
class PythonUpdate final : public Update {
 public:
  PythonUpdate(Held update, Quantity observes, int block_size)
      : update_(std::move(update)), observes_(observes), block_size_(block_size) {}
  Quantity observes() const override { return observes_; }
  void linearize(const StateView& state, Linearization& out) const override {
    with_gil([&] {
      const PythonState at{state.nav, Eigen::Map<const Eigen::VectorXd>(state.block, block_size_)};
      read_linearization(update_->attr("linearize")(at), block_size_, out);
    });
  }

 private:
  Held update_;
  Quantity observes_;
  int block_size_;
};

StateBlock block_of(const py::object& sensor) {
  StateBlock block;
  for (const py::handle item : py::reinterpret_borrow<py::object>(sensor.attr("block"))) {
    BlockState state;
    for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(item)) {
      const auto name = py::cast<std::string>(key);
      if (name == "name") {
        state.name = py::cast<std::string>(value);
        continue;
      }
      double* place = name == "initial"            ? &state.initial
                      : name == "initial_sigma"    ? &state.initial_sigma
                      : name == "walk_per_sqrt_s"  ? &state.walk_per_sqrt_s
                      : name == "walk_per_sqrt_m"  ? &state.walk_per_sqrt_m
                      : name == "tau_s"            ? &state.tau_s
                      : name == "stationary_sigma" ? &state.stationary_sigma
                                                   : nullptr;
      if (place == nullptr) throw std::runtime_error("block: \"" + name + "\" is no property of a state");
      *place = py::cast<double>(value);
    }
    if (state.name.empty()) throw std::runtime_error("block: a state needs a name, with its unit: \"offset_m\"");
    block.push_back(std::move(state));
  }
  return block;
}

StartHint start_hint_of(const py::dict& given) {
  StartHint hint;
  for (const auto& [key, value] : given) {
    const auto name = py::cast<std::string>(key);
    if (name == "position") {
      const auto p = py::cast<std::vector<double>>(value);
      if (p.size() != 2 && p.size() != 3) throw std::runtime_error("start_hint: position has two or three numbers");
      hint.p_map_point = Eigen::Vector3d(p[0], p[1], p.size() == 3 ? p[2] : 0.0);
    } else if (name == "base_point") {
      hint.p_base_point = py::cast<Eigen::Vector3d>(value);
    } else if (name == "sigma_m") {
      hint.sigma_m = py::cast<double>(value);
    } else if (name == "yaw_rad") {
      hint.yaw_rad = py::cast<double>(value);
    } else if (name == "yaw_sigma_rad") {
      hint.yaw_sigma_rad = py::cast<double>(value);
    } else {
      throw std::runtime_error("start_hint: \"" + name +
                               "\" is none of position, base_point, sigma_m, yaw_rad, yaw_sigma_rad");
    }
  }
  return hint;
}

class PythonSensor final : public Sensor {
 public:
  /// With the GIL.
  explicit PythonSensor(py::object sensor) {
    block_ = block_of(sensor);
    traits_.is_motion_source = py::cast<bool>(sensor.attr("is_motion_source"));
    traits_.is_absolute = py::cast<bool>(sensor.attr("is_absolute"));
    traits_.observes_roll_and_pitch = py::cast<bool>(sensor.attr("observes_roll_and_pitch"));
    takes_outcomes_ = py::hasattr(sensor, "outcome");
    payload_ = py::cast<std::string>(sensor.attr("payload"));
    sensor_ = hold(std::move(sensor));
  }

  StateBlock block() const override { return block_; }
  SensorTraits traits() const override { return traits_; }

  std::optional<StartHint> start_hint(const Measurement& measurement, const Datum*) const override {
    require_payload(measurement, payload_);
    return with_gil([&]() -> std::optional<StartHint> {
      const py::object given = sensor_->attr("start_hint")(view_of(measurement));
      if (given.is_none()) return std::nullopt;
      return start_hint_of(py::cast<py::dict>(given));
    });
  }

  void process(const Measurement& measurement, const Prediction& prediction, UpdateList& out) override {
    require_payload(measurement, payload_);
    with_gil([&] {
      const auto own = static_cast<int>(block_.size());
      PythonPrediction view{{prediction.belief.mean, Eigen::Map<const Eigen::VectorXd>(prediction.block, own)},
                            prediction.belief.P,
                            pose_covariance(prediction.belief, prediction.layout),
                            prediction.planar(),
                            prediction.standing,
                            prediction.datum != nullptr ? std::optional(*prediction.datum) : std::nullopt};
      PythonUpdates updates;
      sensor_->attr("process")(view_of(measurement), std::move(view),
                               py::cast(&updates, py::return_value_policy::reference));
      for (const Held& update : updates.updates) out.emplace<PythonUpdate>(update, quantity_of(*update), own);
      if (updates.motion != UpdateList::Motion::not_reported)
        out.report_motion(updates.motion == UpdateList::Motion::moving);
      if (updates.twist_reset) out.reset_twist(*updates.twist_reset);
      if (!updates.degraded_reason.empty()) out.report_degraded(literal(updates.degraded_reason));
      if (updates.is_continuous) out.report_continuous();
    });
  }

  void outcome(const Outcome& outcome) override {
    if (!takes_outcomes_) return;
    with_gil([&] {
      sensor_->attr("outcome")(outcome.update, Eigen::VectorXd(outcome.innovation), Eigen::MatrixXd(outcome.S),
                               outcome.nis, outcome.accepted);
    });
  }

  std::unique_ptr<Sensor> clone() const override {
    return with_gil(
        [&] { return std::make_unique<PythonSensor>(py::module_::import("copy").attr("deepcopy")(*sensor_)); });
  }

  void save(OutArchive& archive) const override {
    const std::string state = with_gil([&] { return std::string(py::cast<py::bytes>(sensor_->attr("save")())); });
    archive.section("python_sensor", 1);
    archive.value(std::string_view(state));
  }
  void load(InArchive& archive) override {
    archive.section("python_sensor", 1);
    std::string state;
    archive(state);
    with_gil([&] { sensor_->attr("load")(py::bytes(state)); });
  }

 private:
  Held sensor_;
  StateBlock block_;
  SensorTraits traits_;
  bool takes_outcomes_ = false;
  std::string payload_;
};

}  // namespace

Sensor* make_sensor(const Config& config, const Rig& rig) {
  const std::string name = config.text({"class", "name under which the class was registered with `waymark.sensor`"});
  const std::string own = config.text("name");
  return with_gil([&]() -> Sensor* { return new PythonSensor(make_registered("sensor", name, own, config, rig)); });
}

py::object make_registered(const char* kind, const std::string& name, const std::string& sensor, const Config& config,
                           const Rig& rig) {
  const py::module_ registry = py::module_::import("waymark._sensors");
  const py::object cls = registry.attr("registered")(kind, name);
  if (cls.is_none()) {
    config.fail("class", "\"" + name + "\" is no registered " + kind +
                             "; there are: " + py::cast<std::string>(registry.attr("names")(kind)));
  }
  const int place = rig.find(sensor);
  py::object T_base_sensor = py::none();
  if (place >= 0) {
    if (const auto& mounting = rig.mountings()[static_cast<std::size_t>(place)].T_base_sensor) {
      Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
      T.topLeftCorner<3, 3>() = mounting->q.toRotationMatrix();
      T.topRightCorner<3, 1>() = mounting->p;
      T_base_sensor = py::cast(T);
    }
  }
  // Before the constructor runs, which may need it.
  py::object object = cls.attr("__new__")(cls);
  object.attr("T_base_sensor") = T_base_sensor;
  object.attr("__init__")(config);
  return object;
}

void add_factories(py::module_& module) {
  module.attr("_make_map_module") =
      py::capsule(reinterpret_cast<void*>(&make_map_module), "waymark._waymark._make_map_module");
  module.attr("_make_sensor") = py::capsule(reinterpret_cast<void*>(&make_sensor), "waymark._waymark._make_sensor");
}

}  // namespace waymark::python
