// SPDX-License-Identifier: Apache-2.0
// A plugin that registers a payload of its own, with a list of elements and a field behind it.
#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "waymark/interface/measurement.hpp"
#include "waymark/plugin/sensor.hpp"

namespace {

struct Echo : waymark::PayloadOf<Echo> {
  static constexpr std::string_view kType = "test/Echo@1";
  struct One {
    double strength = 0.0;
    Eigen::Vector3d p_m = Eigen::Vector3d::Zero();

    template <class Visitor>
    static void fields(Visitor&& field) {
      field(&One::strength, {.names = {"strength"}, .meaning = "of the echo"});
      field(&One::p_m, {.names = {"x_m", "y_m", "z_m"}, .unit = "m", .meaning = "where it comes from"});
    }
  };
  std::vector<One> echoes;
  double tilt_rad = 0.0;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Echo::echoes, {.names = {"echoes"}, .meaning = "may be empty"});
    field(&Echo::tilt_rad, {.names = {"tilt_rad"}, .unit = "rad", .meaning = "of the instrument"});
  }
};

/// Ignores what it is fed.
class EchoSensor final : public waymark::Sensor {
 public:
  explicit EchoSensor(const waymark::Config&) {}
  void process(const waymark::Measurement&, const waymark::Prediction&, waymark::UpdateList&) override {}
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<EchoSensor>(*this); }
  void save(waymark::OutArchive&) const override {}
  void load(waymark::InArchive&) override {}
};

}  // namespace

WAYMARK_PLUGIN(waymark::Sensor, EchoSensor, "test_echo", "1.0.0", Echo)
