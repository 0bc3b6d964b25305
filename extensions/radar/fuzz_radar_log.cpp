// SPDX-License-Identifier: Apache-2.0
// A libFuzzer harness of the source: the input is a recording of radars, or the table of their mountings. Whatever it
// is, the source reads it or throws waymark::Error. Built with -DRADAR_FUZZ=ON and clang; CMakeLists.txt has the
// commands.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "radar_log.cpp"
#include "waymark/base/error.hpp"

using namespace waymark;

namespace {

const char* const kPoints = "t_s,x_m,y_m,z_m,doppler_mps\n0.1,1,1,0.5,-0.2\n";
const char* const kMountings = "sensor,tx_m,ty_m,tz_m,qw,qx,qy,qz\n1,3.5,0.25,0.5,1,0,0,0\n";

/// A folder of this process.
std::filesystem::path make_folder() {
  auto folder = std::filesystem::temp_directory_path() / ("fuzz_radar_log_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  return folder;
}

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

void require(bool holds) {
  if (!holds) std::abort();
}

void read_all(radar::RadarLog& log) {
  Time last{};
  for (bool is_first = true; const auto measurement = log.next(); is_first = false) {
    require(measurement->payload != nullptr && measurement->sensor < log.channels().size());
    require(is_first || measurement->arrival >= last);
    require(log.progress() >= 0.0 && log.progress() <= 1.0);
    last = measurement->arrival;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path kFolder = make_folder();
  static const Rig kRig({{"front", "waymark/RadarTargets@1", Pose{}}});
  const std::string text(reinterpret_cast<const char*>(data), size);
  const bool is_table = text.starts_with("sensor");
  write(kFolder / "targets", is_table ? kPoints : text);
  write(kFolder / "mountings", is_table ? text : kMountings);
  try {
    radar::RadarLog log(Config::parse("file: targets\nextrinsics: mountings\nradars: [{ number: 0, sensor: front }]\n",
                                      (kFolder / "robot.yaml").string()),
                        kRig);
    read_all(log);
  } catch (const Error&) {  // the message is for the user; anything else ends the fuzzer
  }
  return 0;
}
