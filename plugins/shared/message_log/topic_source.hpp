// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <queue>
#include <set>
#include <string>
#include <vector>

#include "plugins/shared/cdr/message_kinds.hpp"
#include "plugins/shared/message_log/message_log.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/source.hpp"

namespace waymark::message_log {

/// What the recordings of a plugin are called, and how they are opened.
struct LogFormat {
  std::string_view one;         ///< "the bag"
  std::string_view file_key;    ///< meaning of the key `file`
  std::string_view bad_record;  ///< meaning of the key `max_bad_records`
  /// Opens files that are read as one. Throws DataError.
  std::function<std::unique_ptr<MessageLog>(const std::vector<std::filesystem::path>& files)> open;
};

/// A source of recorded topics, in order of the time of recording or of the stamps. Its keys are those of rosbag1.
class TopicSource : public Source {
 public:
  /// Throws ConfigError.
  TopicSource(const Config& config, const Rig& rig, const LogFormat& format);

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  double progress() const override { return log_->progress(); }
  const std::vector<BadRecord>& bad_records() const override { return bad_.records(); }

 private:
  /// An entry of `channels` in the YAML.
  struct Route {
    std::string topic;
    std::string sensor;
    std::string payload;       // that is asked for; empty: the usual one
    std::string payload_type;  // that is made
    bool has_fields = false;
    std::vector<std::string> negate;
    ros::DecoderSettings settings;
    ros::Decoder decode;
    std::uint32_t channel = 0;
    bool stamp_recorded = false;
    Duration stamp_offset{};
  };
  struct LaterArrival {
    bool operator()(const Measurement& a, const Measurement& b) const {
      return a.arrival != b.arrival ? a.arrival > b.arrival : a.sequence > b.sequence;
    }
  };

  static Route read_route(const Config& entry);
  void add_route(Route route, const Config& entry, const Rig& rig);
  std::string topics_with_counts() const;
  Topic find_topic(const Config& entry, const std::string& name) const;
  static void choose_decoder(Route& route, const Topic& topic, const Config& entry);
  std::set<std::size_t> wanted_topics() const;
  void take(const Message& message);
  std::optional<Measurement> measure(const Route& route, const Message& message) const;
  bool is_due() const;

  std::string log_name_;
  std::unique_ptr<MessageLog> log_;
  std::vector<Route> routes_;
  std::vector<Channel> channels_;
  BadRecordList bad_;
  bool arrival_recorded_ = true;
  Duration reorder_window_{};
  Duration max_ahead_{};

  std::priority_queue<Measurement, std::vector<Measurement>, LaterArrival> ready_;
  Time newest_recorded_ = Time::min();   // of the messages that were taken
  Time newest_delivered_ = Time::min();  // arrival
  std::uint64_t taken_ = 0;              // measurements made, for the order of equal arrivals
  std::uint64_t delivered_ = 0;
  bool ended_ = false;
};

}  // namespace waymark::message_log
