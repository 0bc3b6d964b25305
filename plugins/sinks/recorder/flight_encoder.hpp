// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "plugins/shared/mcap/writer.hpp"
#include "waymark/interface/measurement.hpp"

namespace waymark::recorder {

/// Writes measurements and commands as MCAP. Its bytes depend on what is added only, not on any clock.
class FlightEncoder {
 public:
  /// Begins the file. `sensors`: names in the order of the rig. `flush`: a chunk spans this much time at most.
  FlightEncoder(mcap::WriterOptions options, std::vector<std::string> sensors, Duration flush);

  /// Adds a measurement that was delivered, or one that was dropped. One whose payload registers no fields is left out,
  /// with an event.
  void add(const Measurement& measurement, bool is_dropped);
  void add_command(Time arrival, std::string_view command);
  void add_attachment(const std::string& name, const std::string& media_type, std::string_view content);
  void add_metadata(const std::string& name, const std::map<std::string, std::string>& values);

  /// Ends the current chunk.
  void flush();
  /// Ends the file.
  void finish() { writer_.finish(); }

  /// Bytes since the last call, and events since the last call.
  std::vector<std::uint8_t> take() { return writer_.take(); }
  std::vector<std::string> take_events();

 private:
  using ChannelKey = std::tuple<std::uint32_t, std::string, bool>;  // sensor, payload type, dropped

  std::uint16_t channel_of(const Measurement& measurement, bool is_dropped);
  std::uint16_t schema_of(const Payload& payload);
  std::uint16_t command_channel();
  void add_message(const mcap::Message& message, Time arrival);

  mcap::Writer writer_;
  std::vector<std::string> sensors_;
  Duration flush_;
  std::map<std::string, std::uint16_t, std::less<>> schemas_;  // by payload type
  std::map<ChannelKey, std::uint16_t> channels_;
  std::uint16_t next_schema_ = 1;
  std::uint16_t next_channel_ = 1;
  std::uint16_t command_channel_ = 0;
  std::uint32_t commands_ = 0;
  bool chunk_is_open_ = false;
  Time chunk_begin_{};
  std::set<std::string, std::less<>> left_out_;  // payload types
  std::vector<std::string> events_;
};

}  // namespace waymark::recorder
