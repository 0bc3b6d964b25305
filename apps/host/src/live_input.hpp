// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "clock_offset.hpp"
#include "clock_steps.hpp"
#include "gap_watch.hpp"
#include "live_clock.hpp"
#include "source_list.hpp"
#include "waymark/interface/source.hpp"

namespace waymark::host {

/// An event that begins so says that a source has failed, and why.
inline constexpr std::string_view kSourceEnded = "a source ended: ";

/// The sources of a running robot as one: each is read in a thread of its own into one bounded queue, in order of
/// arrival. If the filter falls behind, scans are thinned; if the queue is full, sensors that allow it lose their
/// oldest measurements, and otherwise the source waits. All is counted.
class LiveInput final : public Source {
 public:
  /// What the queue may do with the measurements of a channel if the filter falls behind.
  struct Policy {
    /// Only the newest of its waiting measurements is kept once the oldest of all waits for so long; zero: never.
    Duration thin_after{};
    bool may_drop = false;  ///< its oldest waiting measurement may be dropped if the queue is full
    UsableOffsets offsets = {};
  };
  struct Options {
    std::size_t capacity = 20000;                             ///< measurements
    const std::atomic<bool>* stop = nullptr;                  ///< true: `next` returns nothing soon
    std::function<void(const Measurement&)> on_arrival = {};  ///< called by the reading threads, in order of arrival
    std::function<void()> on_wait = {};                       ///< called by `next` now and then while it waits
  };
  struct Counts {
    std::uint64_t received = 0;
    std::uint64_t dropped = 0;     ///< not passed to the filter
    std::uint64_t waits = 0;       ///< times at which the source had to wait for room in the queue
    bool was_crowded_out = false;  ///< some of them were dropped because the queue was full
    ClockOffset clock = {};        ///< without its steps
    ClockSteps steps = {};         ///< of its clock, which were taken out of its stamps
    GapWatch gaps = {};            ///< in its stamps: measurements that did not arrive
  };
  /// Measurements of a channel that did not arrive.
  struct ChannelGap {
    std::uint32_t channel = 0;
    Gap gap;
  };

  /// Reading begins with the first `next`.
  LiveInput(std::vector<std::shared_ptr<Source>> sources, std::shared_ptr<const LiveClock> clock);
  ~LiveInput() override;

  /// Before the first `next`. `policies`: of each channel.
  void configure(Options options, std::vector<Policy> policies);

  const std::vector<Channel>& channels() const override { return channels_; }
  bool is_live() const override { return true; }
  /// Waits for the next measurement. Nothing after `stop`, or when all sources have ended.
  std::optional<Measurement> next() override;
  /// Ends all sources and their threads.
  void stop() override;
  std::vector<std::string> take_events() override;
  /// After `stop` only, as the notices.
  const std::vector<BadRecord>& bad_records() const override { return sources_.bad_records(); }
  std::vector<std::string> notices() const override { return sources_.notices(); }

  /// Appends a command to the queue. Returns its sequence number. May be called by any thread.
  std::uint64_t command(std::string text);
  /// The measurements dropped since the last call, in order of arrival.
  std::vector<Measurement> take_dropped();
  /// The gaps in stamps that were found since the last call.
  std::vector<ChannelGap> take_gaps();
  /// Sequence number of the next measurement. Those of a run that goes on must not repeat: they
  /// distinguish measurements.
  std::uint64_t next_sequence() const;
  /// Before the first `next`.
  void number_from(std::uint64_t sequence) { sequence_ = sequence; }
  /// Copies of the waiting measurements, without the commands.
  std::vector<Measurement> waiting_measurements() const;
  /// Of each channel but that of the commands.
  std::vector<Counts> counts() const;
  /// Number of waiting measurements.
  std::size_t waiting() const;

 private:
  void read(std::size_t source);
  void admit(Measurement&& measurement);
  void set_times(Measurement& measurement);
  void look_for_gap(const Measurement& measurement, std::optional<Duration> best_offset);
  void thin_if_behind(const Measurement& newest);
  bool make_room();
  void drop(std::deque<Measurement>::iterator which);

  SourceList sources_;
  std::vector<Channel> channels_;  // the last one is that of commands
  std::shared_ptr<const LiveClock> clock_;
  Options options_;
  std::vector<Policy> policies_;

  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::condition_variable room_;
  std::deque<Measurement> queue_;
  std::vector<Measurement> dropped_;
  std::vector<ChannelGap> gaps_;
  std::vector<Counts> counts_;
  std::vector<std::string> events_;
  std::uint64_t sequence_ = 0;
  std::size_t reading_ = 0;  // sources that have not ended
  bool stopped_ = false;
  bool overloaded_ = false;  // reported already

  std::vector<std::thread> threads_;
};

}  // namespace waymark::host
