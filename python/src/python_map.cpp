// SPDX-License-Identifier: Apache-2.0
// A map module whose class is written in Python, and the maps of its particles.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "measurement_view.hpp"
#include "python_state.hpp"
#include "rows.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/rig.hpp"

namespace py = pybind11;

namespace waymark::python {
namespace {

struct PythonObservation final : Observation {
  explicit PythonObservation(Held given) : object(std::move(given)) {}
  Held object;
};

struct PythonAssociation final : Association {
  explicit PythonAssociation(Held given) : object(std::move(given)) {}
  Held object;
};

PythonState state_of(const Pose& T_map_base) {
  PythonState state;
  state.nav.T_map_base = T_map_base;
  return state;
}

void read_refinement(const py::handle& returned, Refinement& out) {
  if (returned.is_none()) return;
  if (!py::isinstance<py::dict>(returned))
    throw std::runtime_error("refine returns None or a dictionary: information, gradient, log_evidence");
  for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(returned)) {
    const auto name = py::cast<std::string>(key);
    if (name == "information") {
      out.information = py::cast<Eigen::Matrix3d>(value);
    } else if (name == "gradient") {
      out.gradient = py::cast<Eigen::Vector3d>(value);
    } else if (name == "log_evidence") {
      out.log_evidence = py::cast<double>(value);
    } else if (name == "writes") {
      out.writes = py::cast<bool>(value);
    } else if (name == "failed") {
      out.failed = py::cast<bool>(value);
    } else if (name == "searched") {
      out.searched = py::cast<bool>(value);
    } else if (name == "slip") {
      out.slip = py::cast<Eigen::Matrix3d>(value);
    } else if (name == "association") {
      out.association = std::make_unique<PythonAssociation>(hold(py::reinterpret_borrow<py::object>(value)));
    } else {
      throw std::runtime_error(
          "refine: \"" + name +
          "\" is none of information, gradient, log_evidence, writes, failed, searched, slip, association");
    }
  }
}

LandmarkView landmark_of(const py::dict& given) {
  LandmarkView view;
  view.radius_m = std::nan("");
  view.existence = 1.0;
  view.confirmed = true;
  for (const auto& [key, value] : given) {
    const auto name = py::cast<std::string>(key);
    if (name == "id") {
      view.id = py::cast<std::int64_t>(value);
    } else if (name == "position") {
      view.p_map = py::cast<Eigen::Vector2d>(value);
    } else if (name == "covariance") {
      view.P.topLeftCorner<2, 2>() = py::cast<Eigen::Matrix2d>(value);
    } else if (name == "radius_m") {
      view.radius_m = py::cast<double>(value);
    } else if (name == "existence") {
      view.existence = py::cast<double>(value);
    } else if (name == "sightings") {
      view.sightings = py::cast<int>(value);
    } else if (name == "confirmed") {
      view.confirmed = py::cast<bool>(value);
    } else {
      throw std::runtime_error("landmarks: \"" + name +
                               "\" is none of id, position, covariance, radius_m, existence, sightings, confirmed");
    }
  }
  return view;
}

class PythonMap final : public ParticleMap {
 public:
  explicit PythonMap(Held map) : map_(std::move(map)) {}

  std::unique_ptr<ParticleMap> clone() const override {
    return with_gil([&] { return std::make_unique<PythonMap>(hold(map_->attr("clone")())); });
  }
  void refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
              Refinement& out) const override {
    with_gil([&] {
      read_refinement(map_->attr("refine")(state_of(prior.T_map_base), prior.P, state_of(start), seen(observation)),
                      out);
    });
  }
  void insert(const PoseGaussian& pose, const Observation& observation, const Association* association) override {
    with_gil([&] {
      const auto* found = static_cast<const PythonAssociation*>(association);
      map_->attr("insert")(state_of(pose.T_map_base), pose.P, seen(observation),
                           found != nullptr ? *found->object : py::none());
    });
  }
  void describe(MapDescription& out) const override {
    with_gil([&] {
      for (const py::handle landmark : py::reinterpret_borrow<py::object>(map_->attr("landmarks")()))
        out.landmarks.push_back(landmark_of(py::cast<py::dict>(landmark)));
      for (const auto& [name, value] : py::cast<py::dict>(map_->attr("figures")()))
        out.figures.push_back({py::cast<std::string>(name), py::cast<double>(value)});
    });
  }
  std::optional<GridView> grid() const override {
    return with_gil([&]() -> std::optional<GridView> {
      const py::object given = map_->attr("grid")();
      if (given.is_none()) return std::nullopt;
      const auto cells =
          py::cast<py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>>(given.attr("cells"));
      if (cells.ndim() != 2) throw std::runtime_error("grid: its cells are not two-dimensional");
      const auto p = py::cast<std::vector<double>>(given.attr("position"));
      GridView view;
      view.T_map_grid = Pose::planar(p.at(0), p.at(1), py::cast<double>(given.attr("yaw")));
      view.resolution_m = py::cast<double>(given.attr("resolution_m"));
      view.width = static_cast<int>(cells.shape(1));
      view.height = static_cast<int>(cells.shape(0));
      view.cells.assign(cells.data(), cells.data() + cells.size());
      return view;
    });
  }
  void save(OutArchive& archive) const override {
    const std::string state = with_gil([&] { return std::string(py::cast<py::bytes>(map_->attr("save")())); });
    archive.section("python_map", 1);
    archive.value(std::string_view(state));
  }

 private:
  static const py::object& seen(const Observation& observation) {
    return *static_cast<const PythonObservation&>(observation).object;
  }

  Held map_;
};

class PythonMapModule final : public MapModule {
 public:
  /// With the GIL.
  explicit PythonMapModule(Held module)
      : module_(std::move(module)), payload_(py::cast<std::string>(module_->attr("payload"))) {}

  std::unique_ptr<ParticleMap> create_map() const override {
    return with_gil([&] { return std::make_unique<PythonMap>(hold(module_->attr("create_map")())); });
  }
  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion> companions,
                                             const MotionWindow& motion) override {
    require_payload(trigger, payload_);
    return with_gil([&]() -> std::shared_ptr<const Observation> {
      py::dict others;
      for (const Companion& companion : companions) {
        others[py::str(std::string(companion.input))] =
            companion.measurement != nullptr ? view_of(*companion.measurement) : py::none();
      }
      PythonState state = state_of(motion.T_map_base);
      state.nav.v_base = motion.v_base;
      state.nav.w_base = motion.w_base;
      py::object observation = module_->attr("extract")(view_of(trigger), others, std::move(state));
      if (observation.is_none()) return nullptr;
      return std::make_shared<PythonObservation>(hold(std::move(observation)));
    });
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& archive) const override {
    archive.section("python_map", 1);
    std::string state;
    archive(state);
    return with_gil([&] { return std::make_unique<PythonMap>(hold(module_->attr("load_map")(py::bytes(state)))); });
  }

 private:
  Held module_;
  std::string payload_;
};

}  // namespace

MapModule* make_map_module(const Config& config, const Rig& rig) {
  const std::string name =
      config.text({"class", "name under which the class was registered with `waymark.map_module`"});
  const std::vector<std::string> inputs = config.texts("inputs");
  return with_gil([&]() -> MapModule* {
    return new PythonMapModule(hold(make_registered("map_module", name, inputs.front(), config, rig)));
  });
}

}  // namespace waymark::python
