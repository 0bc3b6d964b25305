// SPDX-License-Identifier: Apache-2.0
#include "python_state.hpp"

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <stdexcept>

#include "rows.hpp"
#include "waymark/config/config.hpp"

namespace py = pybind11;

namespace waymark::python {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

Array array_of(const py::handle& value, const char* name) {
  Array array = Array::ensure(value);
  if (!array) {
    PyErr_Clear();
    throw std::runtime_error("linearize: " + std::string(name) + " is no array of numbers");
  }
  return array;
}

std::string shape_of(const Array& array) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  return text + ")";
}

/// A Jacobian of `rows` × `columns`; of one row it may be a plain list.
template <class Matrix>
void read_matrix(const py::handle& value, const char* name, int rows, int columns, Matrix&& out) {
  const Array array = array_of(value, name);
  const bool fits = array.ndim() == 2 ? array.shape(0) == rows && array.shape(1) == columns
                                      : rows == 1 && array.ndim() == 1 && array.shape(0) == columns;
  if (!fits) {
    throw std::runtime_error("linearize: " + std::string(name) + " has the shape " + shape_of(array) + "; expected (" +
                             std::to_string(rows) + ", " + std::to_string(columns) + ")");
  }
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) out(i, j) = array.data()[i * columns + j];
  }
}

/// A variance for all rows, one for each, or the whole matrix.
void read_noise(const py::handle& value, int rows, gaussian::Matrix& R) {
  const Array array = array_of(value, "R");
  if (array.ndim() == 2) return read_matrix(value, "R", rows, rows, R);
  if (array.size() != 1 && array.size() != rows)
    throw std::runtime_error("linearize: R has the shape " + shape_of(array) + " for " + std::to_string(rows) +
                             " rows");
  for (int i = 0; i < rows; ++i) R(i, i) = array.data()[array.size() == 1 ? 0 : i];
}

}  // namespace

PythonState PythonState::moved(const Eigen::VectorXd& delta) const {
  if (delta.size() != kCoreStates + block.size())
    throw py::value_error("moved: " + std::to_string(delta.size()) + " numbers; expected " +
                          std::to_string(kCoreStates + block.size()));
  PythonState out = *this;
  out.nav.T_map_base.p += delta.segment<3>(0);
  out.nav.T_map_base.q = (so3::exp(delta.segment<3>(3)) * nav.T_map_base.q).normalized();
  out.nav.v_base += delta.segment<3>(6);
  out.nav.w_base += delta.segment<3>(9);
  out.block += delta.tail(block.size());
  return out;
}

void read_linearization(const py::handle& returned, int block_size, Linearization& out) {
  if (!py::isinstance<py::dict>(returned))
    throw std::runtime_error("linearize returns a dictionary: residual, R and Jacobians");
  const auto model = py::reinterpret_borrow<py::dict>(returned);
  if (!model.contains("residual") || !model.contains("R"))
    throw std::runtime_error("linearize: the dictionary needs residual and R");
  const Array residual = array_of(model["residual"], "residual");
  const auto rows = static_cast<int>(residual.size());
  if (rows < 1 || rows > kMaxUpdateRows)
    throw std::runtime_error("linearize: " + std::to_string(rows) + " residuals; expected 1 to " +
                             std::to_string(kMaxUpdateRows));
  out.reset(rows, block_size);
  for (int i = 0; i < rows; ++i) out.residual(i) = residual.data()[i];
  for (const auto& [key, value] : model) {
    const auto name = py::cast<std::string>(key);
    if (name == "residual") continue;
    if (name == "R") {
      read_noise(value, rows, out.R);
    } else if (name == "position") {
      read_matrix(value, "position", rows, 3, out.position());
    } else if (name == "attitude") {
      read_matrix(value, "attitude", rows, 3, out.attitude());
    } else if (name == "velocity") {
      read_matrix(value, "velocity", rows, 3, out.velocity());
    } else if (name == "angular_rate") {
      read_matrix(value, "angular_rate", rows, 3, out.angular_rate());
    } else if (name == "block") {
      read_matrix(value, "block", rows, block_size, out.block());
    } else {
      throw std::runtime_error("linearize: \"" + name +
                               "\" is none of residual, R, position, attitude, velocity, angular_rate, block");
    }
  }
}

void add_state(py::module_& module) {
  py::class_<PythonState>(
      module, "State",
      "A state at which a model is evaluated: position of the base in the map [m], R (rotation from base to map), yaw "
      "[rad], velocity [m/s] and angular_rate [rad/s] in the base frame, block (the sensor's own states).\n\n"
      "moved(delta): the state moved by a small error: position and rotation vector in the map frame, velocity and "
      "rate in "
      "the base frame (12 numbers), then the block.")
      .def_property_readonly("position", [](const PythonState& s) { return s.nav.T_map_base.p; })
      .def_property_readonly("R", [](const PythonState& s) { return s.nav.T_map_base.q.toRotationMatrix(); })
      .def_property_readonly("yaw", [](const PythonState& s) { return s.nav.T_map_base.yaw(); })
      .def_property_readonly("velocity", [](const PythonState& s) { return s.nav.v_base; })
      .def_property_readonly("angular_rate", [](const PythonState& s) { return s.nav.w_base; })
      .def_property_readonly("block", [](const PythonState& s) { return Eigen::VectorXd(s.block); })
      .def("moved", &PythonState::moved, py::arg("delta"));
  py::class_<PythonPrediction>(module, "Prediction",
                               "The mixture predicted to a measurement's stamp: state (State), covariance of the error "
                               "states, pose_covariance of "
                               "(x, y, yaw), planar, standing (the host detects standstill), datum (latitude, "
                               "longitude [deg], height [m]; None).")
      .def_readonly("state", &PythonPrediction::state)
      .def_property_readonly("covariance", [](const PythonPrediction& p) { return p.covariance; })
      .def_property_readonly("pose_covariance", [](const PythonPrediction& p) { return p.pose_covariance; })
      .def_readonly("planar", &PythonPrediction::planar)
      .def_readonly("standing", &PythonPrediction::standing)
      .def_property_readonly("datum", [](const PythonPrediction& p) -> py::object {
        if (!p.datum) return py::none();
        return py::make_tuple(p.datum->latitude_deg, p.datum->longitude_deg, p.datum->height_m);
      });
  py::class_<PythonUpdates>(
      module, "Updates",
      "What Sensor.process fills. add(update): at most four. report_motion(moving): a motion source says it with every "
      "measurement. reset_twist(velocity_sigma, rate_sigma): the measurement alone determines the twist from now on. "
      "report_degraded(reason): a fixed text. report_continuous(): the measurement follows the last ones without a "
      "jump.")
      .def(
          "add",
          [](PythonUpdates& out, py::object update) {
            if (out.updates.size() >= UpdateList::kSlots)
              throw py::value_error("a measurement has at most four updates");
            out.updates.push_back(hold(std::move(update)));
          },
          py::arg("update"))
      .def(
          "report_motion",
          [](PythonUpdates& out, bool moving) {
            out.motion = moving ? UpdateList::Motion::moving : UpdateList::Motion::still;
          },
          py::arg("moving"))
      .def(
          "reset_twist",
          [](PythonUpdates& out, double velocity_sigma, double rate_sigma) {
            out.twist_reset = UpdateList::UnknownTwist{velocity_sigma, rate_sigma};
          },
          py::arg("velocity_sigma"), py::arg("rate_sigma"))
      .def(
          "report_degraded", [](PythonUpdates& out, std::string reason) { out.degraded_reason = std::move(reason); },
          py::arg("reason"))
      .def("report_continuous", [](PythonUpdates& out) { out.is_continuous = true; });
}

void add_config(py::module_& module) {
  const auto key = [](const std::string& name, const std::string& unit, const std::string& meaning) {
    return Config::Key(name, unit, meaning);
  };
  const auto arguments = [](auto& cls, const char* name, auto function) {
    cls.def(name, function, py::arg("name"), py::arg("default") = py::none(), py::kw_only(), py::arg("unit") = "",
            py::arg("meaning") = "");
  };
  using Text = const std::string&;
  py::class_<Config> config(module, "Config",
                            "An entry of the YAML. number, positive, integer, boolean, text and numbers read a key; "
                            "without a default it must be "
                            "there. A key that is never read is an error of the YAML. fail(name, message) raises "
                            "ConfigError at the key's place.");
  arguments(config, "number", [key](const Config& c, Text name, std::optional<double> otherwise, Text unit, Text what) {
    return otherwise ? c.number(key(name, unit, what), *otherwise) : c.number(key(name, unit, what));
  });
  arguments(config, "positive",
            [key](const Config& c, Text name, std::optional<double> otherwise, Text unit, Text what) {
              return otherwise ? c.positive(key(name, unit, what), *otherwise) : c.positive(key(name, unit, what));
            });
  arguments(config, "integer",
            [key](const Config& c, Text name, std::optional<std::int64_t> otherwise, Text unit, Text what) {
              return otherwise ? c.integer(key(name, unit, what), *otherwise) : c.integer(key(name, unit, what));
            });
  arguments(config, "boolean", [key](const Config& c, Text name, std::optional<bool> otherwise, Text unit, Text what) {
    return otherwise ? c.boolean(key(name, unit, what), *otherwise) : c.boolean(key(name, unit, what));
  });
  arguments(config, "text",
            [key](const Config& c, Text name, std::optional<std::string> otherwise, Text unit, Text what) {
              return otherwise ? c.text(key(name, unit, what), *otherwise) : c.text(key(name, unit, what));
            });
  config.def(
      "numbers",
      [key](const Config& c, Text name, int count, const std::optional<std::vector<double>>& otherwise, Text unit,
            Text what) {
        const std::vector<double> found =
            otherwise ? c.numbers(key(name, unit, what), count, *otherwise) : c.numbers(key(name, unit, what), count);
        return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(found.data(), std::ssize(found)));
      },
      py::arg("name"), py::arg("count") = -1, py::arg("default") = py::none(), py::kw_only(), py::arg("unit") = "",
      py::arg("meaning") = "");
  config.def(
      "has", [](const Config& c, Text name) { return c.has(name); }, py::arg("name"));
  config.def(
      "fail", [](const Config& c, Text name, Text message) { c.fail(name, message); }, py::arg("name"),
      py::arg("message"));
}

}  // namespace waymark::python
