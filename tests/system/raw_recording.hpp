// SPDX-License-Identifier: Apache-2.0
// A raw recording of KITTI's kind, written by the test: 16 frames along a straight line among coloured poles.
#pragma once

#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "tests/system/command.hpp"

namespace waymark::system_test {

/// An image of 8 bits per colour as a PNG file; `rgb` holds its rows from the top.
inline std::string png(int width, int height, const std::vector<std::uint8_t>& rgb) {
  const auto big_endian = [](std::uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
    return bytes;
  };
  const auto chunk = [&](const std::string& body) {  // body: four letters of the type, then the data
    const auto crc = ::crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
    return big_endian(static_cast<std::uint32_t>(body.size() - 4)) + body + big_endian(static_cast<std::uint32_t>(crc));
  };
  std::string rows;
  const std::size_t stride = 3 * static_cast<std::size_t>(width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
    rows += '\0';  // no filter
    rows.append(reinterpret_cast<const char*>(rgb.data()) + y * stride, stride);
  }
  uLongf size = ::compressBound(rows.size());
  std::string packed(size, '\0');
  ::compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()), rows.size());
  packed.resize(size);
  const std::string header = big_endian(static_cast<std::uint32_t>(width)) +
                             big_endian(static_cast<std::uint32_t>(height)) + std::string("\x08\x02\x00\x00\x00", 5);
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR" + header) + chunk("IDAT" + packed) + chunk("IEND");
}

/// Scanner and camera look forward from 1 m above the ground, the camera 0.3 m before the scanner. The base drives
/// along x; the map is its frame at the start.
class RawRecording {
 public:
  struct Pole {
    double x, y, radius;
    std::array<std::uint8_t, 3> rgb;
  };
  static constexpr int kFrames = 16;
  static constexpr int kWidth = 480;
  static constexpr int kHeight = 120;
  static constexpr double kFocal = 240.0;
  static constexpr std::array<Pole, 4> kPoles{{{6.0, 2.0, 0.15, {200, 40, 30}},
                                               {7.0, -1.5, 0.2, {30, 60, 190}},
                                               {10.0, 1.0, 0.25, {40, 150, 40}},
                                               {11.0, -4.0, 0.2, {190, 170, 40}}}};

  static double x_at(int frame) { return 0.1 * frame; }

  std::filesystem::path folder() const { return folder_.path(); }
  std::filesystem::path yaml() const { return folder_ / "robot.yaml"; }
  std::filesystem::path image(int frame) const {
    return folder_.path() / "image_02/data" / fmt::format("{:010}.png", frame);
  }
  std::filesystem::path cloud(int frame) const {
    return folder_.path() / "velodyne_points/data" / fmt::format("{:010}.bin", frame);
  }

  void write() const {
    std::filesystem::create_directories(cloud(0).parent_path());
    std::filesystem::create_directories(image(0).parent_path());
    for (int frame = 0; frame < kFrames; ++frame) {
      write_cloud(frame);
      write_image(frame, kWidth, kHeight);
    }
    write_text(yaml(), fmt::format(R"(
source:
  plugin: kitti
  folder: .
  calibration: none
  max_bad_records: 2
  lidar: {{ sensor: lidar, height_m: [0.8, 1.2], start_deg: -80, beams: 800, range_max_m: 30 }}
  camera: {{ sensor: camera }}
motion: {{ source: maps }}
initial: {{ x_m: 0, y_m: 0, yaw_deg: 0 }}
sensors:
  - {{ name: camera, payload: Image, base_T_sensor: {{ xyz_m: [0.3, 0, 1] }}, intrinsics: {{ size_px: [{0}, {1}], focal_px: [{2}, {2}], center_px: [{3}, {4}] }} }}
  - {{ name: lidar, payload: LaserScan, base_T_sensor: {{ xyz_m: [0, 0, 1] }} }}
maps:
  - name: poles
    plugin: feature_map
    inputs: [lidar, camera]
    pair_max_age_s: 0.05
    attributes: [radius, signature]
    extraction: {{ range_min_m: 1, range_max_m: 25, no_return_m: 30.5 }}
    noise: {{ range_m: 0.03, bearing_deg: 0.2, tangential_m: 0.03 }}
filter: {{ particles: 5 }}
sinks: [ {{ plugin: tum }}, {{ plugin: landmarks }}, {{ plugin: diagnostics }} ]
)",
                                   kWidth, kHeight, kFocal, 0.5 * (kWidth - 1), 0.5 * (kHeight - 1)));
  }

  /// The image of a frame, all colours times `light`; of another size the poles are where they are in the right one.
  void write_image(int frame, int width, int height, double light = 1.0) const {
    std::vector<std::uint8_t> rgb;
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const double bearing = std::atan2(0.5 * (kWidth - 1) - u, kFocal);
        const Hit hit = look(x_at(frame) + 0.3, bearing);
        const std::array<std::uint8_t, 3> sky{150, 150, 150};
        for (const std::uint8_t value : hit.pole != nullptr ? hit.pole->rgb : sky)
          rgb.push_back(static_cast<std::uint8_t>(std::min(255.0, light * value)));
      }
    }
    write_text(image(frame), png(width, height, rgb));
  }

 private:
  struct Hit {
    const Pole* pole = nullptr;
    double range = 0.0;
  };

  static Hit look(double x, double bearing) {
    Hit nearest;
    for (const Pole& pole : kPoles) {
      const double along = (pole.x - x) * std::cos(bearing) + pole.y * std::sin(bearing);
      const double across = (pole.x - x) * std::sin(bearing) - pole.y * std::cos(bearing);
      if (along < 0.0 || std::abs(across) > pole.radius) continue;
      const double range = along - std::sqrt(pole.radius * pole.radius - across * across);
      if (nearest.pole == nullptr || range < nearest.range) nearest = {&pole, range};
    }
    return nearest;
  }

  void write_cloud(int frame) const {
    std::vector<float> points;
    for (int k = 0; k < 1600; ++k) {
      const double bearing = (-80.0 + 0.1 * k) * std::numbers::pi / 180.0;
      const Hit hit = look(x_at(frame), bearing);
      if (hit.pole == nullptr) continue;
      for (const double z : {-0.5, -0.1, 0.1, 0.5}) {
        points.insert(points.end(), {static_cast<float>(hit.range * std::cos(bearing)),
                                     static_cast<float>(hit.range * std::sin(bearing)), static_cast<float>(z), 0.4f});
      }
    }
    write_text(cloud(frame), {reinterpret_cast<const char*>(points.data()), points.size() * sizeof(float)});
  }

  TemporaryFolder folder_;
};

}  // namespace waymark::system_test
