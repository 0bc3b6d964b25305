// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "temporary_folder.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::csv_test {

/// A gzip file that holds `text` in stored blocks of at most `block` bytes.
inline std::string gzip(std::string_view text, std::size_t block = 64) {
  const auto little_endian = [](std::string& out, std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) out += static_cast<char>((value >> (8 * i)) & 0xff);
  };
  std::string out("\x1f\x8b\x08\x00\x00\x00\x00\x00\x00\x03", 10);
  for (std::size_t at = 0; at < text.size(); at += block) {
    const auto part = text.substr(at, block);
    const auto length = static_cast<std::uint32_t>(part.size());
    out += at + block >= text.size() ? '\x01' : '\x00';
    little_endian(out, length, 2);
    little_endian(out, ~length, 2);
    out += part;
  }
  std::uint32_t crc = 0xffffffff;
  for (const char c : text) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320u : 0u);
  }
  little_endian(out, ~crc, 4);
  little_endian(out, static_cast<std::uint32_t>(text.size()), 4);
  return out;
}

/// A temporary folder, and csv sources whose YAML lies in it.
class CsvTest : public ::testing::Test {
 protected:
  void write(const std::string& name, std::string_view content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }

  std::shared_ptr<Source> make(const std::string& yaml) const {
    const Config config = Config::parse(yaml, (folder_ / "run.yaml").string());
    return PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("csv", config, rig_);
  }

  static std::vector<Measurement> read_all(Source& source) {
    std::vector<Measurement> all;
    while (auto measurement = source.next()) all.push_back(std::move(*measurement));
    return all;
  }

  /// The text of the error that `make` throws; a failure if it throws none.
  template <class E>
  std::string construction_error(const std::string& yaml) const {
    try {
      make(yaml);
    } catch (const E& error) {
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }

  /// The text of the DataError that reading ends with, and in `good` what came before it.
  static std::string reading_error(Source& source, std::vector<Measurement>* good = nullptr) {
    try {
      while (auto measurement = source.next()) {
        if (good != nullptr) good->push_back(std::move(*measurement));
      }
    } catch (const DataError& error) {
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }

  test::TemporaryFolder folder_;
  Rig rig_{{{"wheels", "", std::nullopt},
            {"other", "", std::nullopt},
            {"gps", "waymark/GnssFix@1", std::nullopt},
            {"lidar", "waymark/LaserScan@1", std::nullopt},
            {"camera", "", std::nullopt}}};
};

/// One file of WheelSpeeds with time, left and right in the columns 0, 1 and 2.
inline std::string wheels_yaml(const std::string& file, const std::string& more_of_the_file = "",
                               const std::string& more_of_the_source = "") {
  return more_of_the_source + "files:\n  - {path: " + file +
         ", sensor: wheels, payload: WheelSpeeds, time: 0, columns: {left_mps: 1, right_mps: 2}" + more_of_the_file +
         "}\n";
}

}  // namespace waymark::csv_test
