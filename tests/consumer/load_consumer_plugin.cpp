// SPDX-License-Identifier: Apache-2.0
// load_consumer_plugin FOLDER: builds the altimeter plugin in FOLDER, gives it a height, and looks at the update.
#include <cmath>
#include <cstdio>

#include "waymark/interface/sensor.hpp"
#include "waymark/plugin_loader.hpp"

namespace {

// The plugin's own payload as a source of the same vendor would make it: only name and layout count.
struct Height : waymark::PayloadOf<Height> {
  static constexpr std::string_view kType = "example/Height@1";
  double up_m = 0.0;
};

bool altimeter_works(const char* folder) {
  using namespace waymark;
  const Config config = Config::parse("sigma_m: 0.2\n");
  const auto sensor = PluginLoader({folder}).create<Sensor>("altimeter", config, Rig({}));
  config.reject_unread();

  const StateLayout layout(StateLayout::Motion::spatial, {});
  Belief belief;
  belief.P.setIdentity(layout.size(), layout.size());
  auto height = std::make_shared<Height>();
  height->up_m = 3.0;
  Measurement measurement;
  measurement.payload = height;
  UpdateList updates;
  sensor->process(measurement, {belief, layout, nullptr, nullptr, false}, updates);
  if (updates.size() != 1) return false;
  Linearization model;
  updates[0].linearize({belief.mean, nullptr}, model);
  return model.rows() == 1 && model.residual(0) == 3.0 && std::abs(model.R(0, 0) - 0.04) < 1e-12 &&
         model.uses(Linearization::kPosition) && model.get(Linearization::kPosition)(0, 2) == 1.0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: load_consumer_plugin FOLDER\n", stderr);
    return 2;
  }
  try {
    if (altimeter_works(argv[1])) return 0;
    std::fputs("the altimeter's update is not what was expected\n", stderr);
  } catch (const waymark::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  return 1;
}
