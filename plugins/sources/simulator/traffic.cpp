// SPDX-License-Identifier: Apache-2.0
#include "traffic.hpp"

#include <cmath>

#include "streams.hpp"

namespace waymark::simulator {

Traffic::Traffic(const Config& config, std::uint64_t seed) {
  const auto count = config.integer_in({"count", "how many things drive about"}, 0, 1000, 0);
  if (count == 0 && !config.has("area_m")) return;
  const std::vector<double> area =
      config.numbers({"area_m", "m", "x_min, y_min, x_max, y_max of the ends of their lines"}, 4);
  if (!(area[0] < area[2] && area[1] < area[3])) config.fail("area_m", "x_min < x_max and y_min < y_max are expected");
  const std::vector<double> speed =
      config.numbers({"speed_mps", "m/s", "smallest, largest speed"}, 2, std::vector<double>{2.0, 8.0});
  if (!(0.0 < speed[0] && speed[0] <= speed[1])) config.fail("speed_mps", "0 < smallest <= largest is expected");
  lines_.reserve(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    Random random = stream(seed, Draw::traffic, Duration{i});
    const auto point = [&] {
      const double x = area[0] + (area[2] - area[0]) * random.uniform();
      return Eigen::Vector2d(x, area[1] + (area[3] - area[1]) * random.uniform());
    };
    Line line{point(), point(), speed[0] + (speed[1] - speed[0]) * random.uniform(), 0.0};
    line.start_m = 2.0 * (line.to - line.from).norm() * random.uniform();
    lines_.push_back(line);
  }
}

std::vector<Traffic::Thing> Traffic::at(Duration time) const {
  std::vector<Thing> things;
  things.reserve(lines_.size());
  for (const Line& line : lines_) {
    const double length = (line.to - line.from).norm();
    const Eigen::Vector2d along = (line.to - line.from) / length;
    const double driven = std::fmod(line.start_m + line.speed_mps * to_seconds(time), 2.0 * length);
    const bool back = driven > length;
    things.push_back({line.from + along * (back ? 2.0 * length - driven : driven),
                      along * (back ? -line.speed_mps : line.speed_mps)});
  }
  return things;
}

}  // namespace waymark::simulator
