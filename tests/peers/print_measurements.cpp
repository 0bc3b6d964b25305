// SPDX-License-Identifier: Apache-2.0
// print_measurements FILE.yaml: all that the source of a YAML delivers, a line each with every digit:
//   sensor type arrival_ns stamp_ns value…
// and, behind them, "bad place: reason". The sensors are names only.
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <limits>

#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace {

using namespace waymark;

std::string joined(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) text += fmt::format(" {:.17g}", value);
  return text;
}

std::string joined(const Eigen::Vector3d& v) { return joined({v.x(), v.y(), v.z()}); }

std::string values_of(const Measurement& m) {
  const std::string_view type = m.payload->type();
  if (type == ImuSample::kType) {
    const auto& s = m.as<ImuSample>();
    const Eigen::Quaterniond& q = s.q_enu_sensor;
    return joined(s.w_sensor) + joined(s.f_sensor) + joined({q.w(), q.x(), q.y(), q.z()});
  }
  if (type == GnssFix::kType) {
    const auto& f = m.as<GnssFix>();
    return joined({f.latitude_deg, f.longitude_deg, f.height_m, f.sigma_horizontal_m, f.sigma_vertical_m, f.hdop,
                   static_cast<double>(f.satellites), static_cast<double>(f.type), f.speed_mps, f.course_rad});
  }
  if (type == BodyTwist::kType) {
    const auto& t = m.as<BodyTwist>();
    return joined({t.v_x_mps, t.v_y_mps, t.w_z_radps});
  }
  if (type == Height::kType) return joined({m.as<Height>().height_m, m.as<Height>().sigma_m});
  if (type == CompassHeading::kType) return joined({m.as<CompassHeading>().heading_rad});
  if (type == MagneticField::kType) return joined(m.as<MagneticField>().m_sensor);
  if (type == LaserScan::kType) {
    const auto& s = m.as<LaserScan>();
    std::string text = joined({s.start_rad, s.step_rad});
    for (const auto* list : {&s.ranges_m, &s.intensities}) {
      for (const float value : *list) text += fmt::format(" {:.9g}", value);
    }
    return text;
  }
  if (type == Image::kType) {
    const auto& i = m.as<Image>();
    std::string text = fmt::format(" {} {} ", i.width, i.height);
    for (const std::uint8_t byte : i.data) text += fmt::format("{:02x}", byte);
    return text;
  }
  throw Error(fmt::format("{} cannot be printed", type));
}

int print(const char* file) {
  const Config config = Config::load(file);
  std::vector<Mounting> mountings;
  for (const std::string& name : config.texts("sensors")) mountings.push_back({name, "", std::nullopt});
  const auto source =
      PluginLoader({WAYMARK_PLUGIN_DIR})
          .create<Source>(config.child("source").text("plugin"), config.child("source"), Rig(std::move(mountings)));
  while (const auto m = source->next()) {
    const Channel& channel = source->channels()[m->sensor];
    fmt::print("{} {} {} {}{}\n", channel.sensor, channel.payload_type, m->arrival.time_since_epoch().count(),
               m->stamp.time_since_epoch().count(), values_of(*m));
  }
  for (const BadRecord& bad : source->bad_records()) fmt::print("bad {}: {}\n", bad.place, bad.reason);
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fputs("usage: print_measurements FILE.yaml\n", stderr);
    return 2;
  }
  try {
    return print(arguments[1]);
  } catch (const std::exception& error) {
    fmt::print(stderr, "print_measurements: {}\n", error.what());
    return 1;
  }
}
