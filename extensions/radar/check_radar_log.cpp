// SPDX-License-Identifier: Apache-2.0
// Writes small recordings of each format, runs the contract kit on the source, and checks values and errors.
#include <cstring>
#include <fstream>
#include <sstream>

#include "checks.hpp"
#include "radar_log.cpp"
#include "waymark/base/error.hpp"
#include "waymark/testing/source_contract.hpp"

using namespace waymark;
using radar::Checks;

namespace {

/// Little-endian numbers, one behind the other.
class Bytes {
 public:
  template <class T>
  Bytes& add(T value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Bytes& text(std::string_view text) {
    text_ += text;
    return *this;
  }
  const std::string& all() const { return text_; }

 private:
  std::string text_;
};

using u1 = std::uint8_t;
using u2 = std::uint16_t;
using i1 = std::int8_t;
using i2 = std::int16_t;

std::string polar(double second_time_s = 0.3) {
  Bytes file;
  file.text("RADT0001").add(std::uint32_t{3});
  file.add(0.1).add(u2{1}).add(u2{2});
  file.add(u2{1234}).add(i2{-5000}).add(i2{-2500}).add(i2{-1000}).add(u1{11});
  file.add(u2{200}).add(i2{0}).add(i2{250}).add(i2{300}).add(u1{0});
  file.add(0.2).add(u2{2}).add(u2{0});
  file.add(second_time_s).add(u2{7}).add(u2{0});  // not in the list of radars
  return file.all();
}

std::string cartesian() {
  Bytes file;
  file.text("RADC0001").add(std::uint32_t{1}).add(0.5).add(u2{1}).add(u2{2});
  file.add(i2{300}).add(i2{400}).add(i2{-500}).add(i2{0}).add(i1{-6}).add(u1{1}).add(u1{3}).add(u1{0});
  file.add(i2{300}).add(i2{400}).add(i2{-500}).add(i2{0}).add(i1{-6}).add(u1{1}).add(u1{2}).add(u1{0});  // ambiguous
  return file.all();
}

const char* const kPoints = "t_s,x_m,y_m,z_m,doppler_mps\n0.1,1,1,0.5,-0.2\n0.1,2,0,0,0.1\n0.2,3,0,0,0.3\n";
const char* const kMountings = "sensor,name,tx_m,ty_m,tz_m,qw,qx,qy,qz\n1,front,3.5,0.25,0.5,1,0,0,0\n";

void put(const std::string& name, const std::string& content) { std::ofstream(name, std::ios::binary) << content; }

std::shared_ptr<Source> make(const std::string& file, int number = 1) {
  const Rig rig({{"front", std::string(RadarTargets::kType), {}}, {"rear", std::string(RadarTargets::kType), {}}});
  std::ostringstream yaml;
  yaml << "{ file: " << file << ", extrinsics: mountings.csv, radars: [{ number: " << number
       << ", sensor: front }, { number: 2, sensor: rear }] }";
  return std::make_shared<radar::RadarLog>(Config::parse(yaml.str()), rig);
}

const RadarTargets::One& first_target(const std::optional<Measurement>& m) {
  return m->as<RadarTargets>().targets.at(0);
}

void reads_values(Checks& checks) {
  const auto source = make("polar.bin");
  const auto m = source->next();
  checks.expect(m && m->as<RadarTargets>().targets.size() == 2, "two targets in the first scan");
  checks.expect(m->stamp == Time(std::chrono::milliseconds(100)), "its stamp");
  checks.near(first_target(m).range_m, 12.34, 1e-9, "range");
  checks.near(first_target(m).azimuth_rad, -0.5, 1e-9, "azimuth");
  checks.near(first_target(m).radial_mps, -10.0, 1e-9, "radial velocity");
  checks.near(first_target(m).rcs_dbsm, -10.0, 1e-9, "cross-section");
  while (source->next()) {
  }
  checks.expect(source->notices().size() == 1, "a radar that is not listed is noticed");
  checks.near(source->T_base_sensor("front")->p.x(), 3.5, 1e-9, "mounting from the table");
  checks.expect(!source->T_base_sensor("rear"), "no mounting of a radar that is not in the table");

  const auto of_nuscenes = make("cartesian.bin")->next();
  checks.expect(of_nuscenes->as<RadarTargets>().targets.size() == 1, "ambiguous targets are left out");
  checks.near(first_target(of_nuscenes).range_m, 5.0, 1e-9, "range of x and y");
  checks.near(first_target(of_nuscenes).radial_mps, -3.0, 1e-9, "radial velocity of v_x and v_y");

  const auto points = make("points.csv", 0);
  checks.expect(points->next()->as<RadarTargets>().targets.size() == 2, "rows of equal time are a scan");
  checks.expect(points->next() && !points->next(), "two scans");
}

void refuses(Checks& checks, const std::string& content, const std::string& expected) {
  put("damaged.bin", content);
  try {
    const auto source = make("damaged.bin");
    while (source->next()) {
    }
    checks.expect(false, "no error: " + expected);
  } catch (const Error& error) {
    const std::string message = error.what();
    checks.expect(message.find(expected) != std::string::npos, "\"" + message + "\" lacks \"" + expected + "\"");
  }
}

}  // namespace

int main() {
  Checks checks;
  put("polar.bin", polar());
  put("cartesian.bin", cartesian());
  put("points.csv", kPoints);
  put("mountings.csv", kMountings);
  for (const char* file : {"polar.bin", "cartesian.bin", "points.csv"}) {
    const auto found = testing::check_source([&] { return make(file, file[1] == 'o' && file[2] == 'i' ? 0 : 1); });
    checks.expect(found.empty(), std::string(file) + ": " + testing::to_text(found));
  }
  reads_values(checks);
  refuses(checks, polar().substr(0, 40), "scan 0: the file ends early; 3 scans are expected");
  refuses(checks, polar() + "x", "other bytes after the last of 3 scans");
  refuses(checks, polar(0.15), "time goes back from 0.200000000 to 0.150000000 s");
  refuses(checks, "\x1f\x8b" + polar(), "damaged or ends early");
  refuses(checks, "", "no column \"t_s\"");
  refuses(checks, "t_s,x_m,y_m,z_m,doppler_mps\n0.1,1,1,abc,0\n", "damaged.bin:2: z_m: \"abc\" is not a number");
  refuses(checks, "t_s,x_m,y_m,z_m,doppler_mps\n0.1,1,1\n", "damaged.bin:2: columns: 3; at least 5 are expected");
  return checks.result();
}
