// SPDX-License-Identifier: Apache-2.0
#include "live_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <utility>

#include "waymark/interface/command.hpp"

namespace waymark::host {
namespace {

/// How often a waiting reader looks at the flag that a signal sets.
constexpr std::chrono::milliseconds kLook{50};

}  // namespace

LiveInput::LiveInput(std::vector<std::shared_ptr<Source>> sources, std::shared_ptr<const LiveClock> clock)
    : sources_(std::move(sources)), channels_(sources_.channels()), clock_(std::move(clock)) {
  channels_.push_back({"", std::string(Command::kType)});
  counts_.resize(channels_.size());
  policies_.resize(channels_.size());
}

LiveInput::~LiveInput() { stop(); }

void LiveInput::configure(Options options, std::vector<Policy> policies) {
  options_ = std::move(options);
  policies_ = std::move(policies);
  policies_.resize(channels_.size());
}

// --- the reading threads
// -----------------------------------------------------------------------------------------------

void LiveInput::read(std::size_t source) {
  try {
    while (std::optional<Measurement> measurement = sources_[source].next()) {
      measurement->sensor += sources_.first_channel(source);
      admit(std::move(*measurement));
    }
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    events_.push_back(fmt::format("{}{}", kSourceEnded, error.what()));
  } catch (...) {
    const std::lock_guard lock(mutex_);
    events_.push_back(fmt::format("{}unknown exception", kSourceEnded));
  }
  const std::lock_guard lock(mutex_);
  --reading_;
  filled_.notify_all();
}

void LiveInput::admit(Measurement&& measurement) {
  std::unique_lock lock(mutex_);
  Counts& counts = counts_[measurement.sensor];
  if (!make_room()) {
    if (counts.waits++ == 0) {
      events_.push_back(
          fmt::format("{} measurements wait for the filter: the source of {} waits, too (further times "
                      "are only counted)",
                      queue_.size(), channels_[measurement.sensor].sensor));
    }
    room_.wait(lock, [&] { return stopped_ || make_room(); });
  }
  if (stopped_) return;
  set_times(measurement);
  measurement.sequence = sequence_++;
  ++counts.received;
  thin_if_behind(measurement);
  if (options_.on_arrival) options_.on_arrival(measurement);
  queue_.push_back(std::move(measurement));
  filled_.notify_one();
}

void LiveInput::set_times(Measurement& m) {
  Counts& counts = counts_[m.sensor];
  m.arrival = clock_->now();
  std::optional<Duration> best_offset = Duration::zero();
  if (m.stamp == kUnknownStamp) {
    m.stamp = m.arrival;
  } else {
    const UsableOffsets& usable = policies_[m.sensor].offsets;
    best_offset = counts.clock.best_offset(usable);
    m.stamp = counts.steps.corrected(m.stamp, m.arrival, best_offset, usable);
  }
  look_for_gap(m, best_offset);
  if (const auto step = counts.steps.take_step()) {
    events_.push_back(fmt::format(
        "the clock of {} was set {} by {:.3f} s: its stamps are carried on as if it had not been",
        channels_[m.sensor].sensor, *step > Duration::zero() ? "forward" : "back", std::abs(to_seconds(*step))));
  }
  if (!counts.steps.in_doubt()) counts.clock.add(m.stamp, m.arrival);
}

void LiveInput::look_for_gap(const Measurement& m, std::optional<Duration> best_offset) {
  Counts& counts = counts_[m.sensor];
  if (counts.steps.in_doubt()) {
    counts.gaps.break_off();
  } else if (const auto gap = counts.gaps.add(m.stamp, m.stamp - m.arrival, best_offset)) {
    gaps_.push_back({m.sensor, *gap});
  }
}

void LiveInput::thin_if_behind(const Measurement& newest) {
  const Duration thin_after = policies_[newest.sensor].thin_after;
  if (thin_after == Duration::zero()) return;
  const Duration behind = queue_.empty() ? Duration::zero() : newest.arrival - queue_.front().arrival;
  if (behind <= thin_after) {
    overloaded_ = overloaded_ && !queue_.empty();
    return;
  }
  if (!std::exchange(overloaded_, true)) {
    events_.push_back(fmt::format("the filter is {:.2f} s behind: scans for maps are thinned", to_seconds(behind)));
  }
  for (auto it = queue_.begin(); it != queue_.end();) {
    if (it->sensor == newest.sensor) {
      drop(it);
      it = queue_.erase(it);
    } else {
      ++it;
    }
  }
}

bool LiveInput::make_room() {
  if (queue_.size() < options_.capacity) return true;
  const auto oldest = std::ranges::find_if(queue_, [&](const Measurement& m) { return policies_[m.sensor].may_drop; });
  if (oldest == queue_.end()) return false;
  if (!std::exchange(counts_[oldest->sensor].was_crowded_out, true)) {
    events_.push_back(
        fmt::format("{} measurements wait for the filter: the oldest of {} are dropped (further ones are only counted)",
                    queue_.size(), channels_[oldest->sensor].sensor));
  }
  drop(oldest);
  queue_.erase(oldest);
  return true;
}

void LiveInput::drop(std::deque<Measurement>::iterator which) {
  ++counts_[which->sensor].dropped;
  dropped_.push_back(std::move(*which));
}

// --- the filter's thread
// -----------------------------------------------------------------------------------------------

std::optional<Measurement> LiveInput::next() {
  std::unique_lock lock(mutex_);
  if (threads_.empty() && !stopped_) {
    reading_ = sources_.size();
    for (std::size_t i = 0; i < sources_.size(); ++i) threads_.emplace_back([this, i] { read(i); });
  }
  while (queue_.empty()) {
    if (stopped_ || reading_ == 0 || (options_.stop != nullptr && *options_.stop)) return std::nullopt;
    filled_.wait_for(lock, kLook);
    if (!options_.on_wait) continue;
    lock.unlock();
    options_.on_wait();
    lock.lock();
  }
  Measurement measurement = std::move(queue_.front());
  queue_.pop_front();
  room_.notify_all();
  return measurement;
}

void LiveInput::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    room_.notify_all();
    filled_.notify_all();
  }
  for (const std::shared_ptr<Source>& source : sources_) source->stop();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

std::uint64_t LiveInput::command(std::string text) {
  auto payload = std::make_shared<Command>();
  payload->text = std::move(text);
  const std::lock_guard lock(mutex_);
  Measurement measurement;
  measurement.stamp = measurement.arrival = clock_->now();
  measurement.sensor = static_cast<std::uint32_t>(channels_.size() - 1);
  measurement.sequence = sequence_++;
  measurement.payload = std::move(payload);
  const std::uint64_t sequence = measurement.sequence;
  queue_.push_back(std::move(measurement));
  filled_.notify_one();
  return sequence;
}

std::vector<std::string> LiveInput::take_events() {
  std::vector<std::string> all;
  {
    const std::lock_guard lock(mutex_);
    all = std::exchange(events_, {});
  }
  for (const std::shared_ptr<Source>& source : sources_)
    std::ranges::move(source->take_events(), std::back_inserter(all));
  return all;
}

std::vector<Measurement> LiveInput::take_dropped() {
  const std::lock_guard lock(mutex_);
  return std::exchange(dropped_, {});
}

std::vector<LiveInput::ChannelGap> LiveInput::take_gaps() {
  const std::lock_guard lock(mutex_);
  return std::exchange(gaps_, {});
}

std::uint64_t LiveInput::next_sequence() const {
  const std::lock_guard lock(mutex_);
  return sequence_;
}

std::vector<Measurement> LiveInput::waiting_measurements() const {
  std::vector<Measurement> waiting;
  const std::lock_guard lock(mutex_);
  std::ranges::copy_if(queue_, std::back_inserter(waiting),
                       [this](const Measurement& m) { return m.sensor + 1 < channels_.size(); });
  return waiting;
}

std::vector<LiveInput::Counts> LiveInput::counts() const {
  const std::lock_guard lock(mutex_);
  return {counts_.begin(), counts_.end() - 1};
}

std::size_t LiveInput::waiting() const {
  const std::lock_guard lock(mutex_);
  return queue_.size();
}

}  // namespace waymark::host
