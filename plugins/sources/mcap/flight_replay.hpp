// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plugins/shared/mcap/mcap_log.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/io/bad_record_list.hpp"

namespace waymark::mcap_source {

/// Replays what the sink `recorder` wrote: every measurement with its stamp, arrival and sequence number, and the
/// commands between them.
class FlightReplay final : public Source {
 public:
  /// `config` is for messages. Throws ConfigError if the files are not a flight record of this robot.
  FlightReplay(std::unique_ptr<mcap::McapLog> log, std::uint64_t max_bad_records, const Config& config, const Rig& rig);

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  double progress() const override { return log_->progress(); }
  const std::vector<BadRecord>& bad_records() const override { return bad_.records(); }
  std::vector<std::string> notices() const override { return notices_; }

 private:
  /// What becomes of the messages of a topic.
  struct Route {
    std::uint32_t channel = 0;
    bool is_command = false;
    std::uint64_t next_sequence = 0;  ///< expected, since a message has only 32 bits of it
  };

  void add_topic(std::size_t topic, const Config& config, const Rig& rig);
  std::uint32_t channel(const std::string& sensor, const std::string& payload);
  Measurement measure(const message_log::Message& message);

  std::unique_ptr<mcap::McapLog> log_;
  BadRecordList bad_;
  std::vector<Channel> channels_;
  std::vector<std::optional<Route>> routes_;  // by topic
  std::vector<std::string> notices_;
};

}  // namespace waymark::mcap_source
