// SPDX-License-Identifier: Apache-2.0
#include "front_output.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <utility>

namespace waymark::host {
namespace {

constexpr std::size_t kMostAhead = 20000;  // measurements, of a filter that does not follow
constexpr Duration kFarAhead = std::chrono::seconds(2);

/// Without the older half of too many.
void bound(std::vector<Measurement>& measurements) {
  if (measurements.size() > kMostAhead) measurements.erase(measurements.begin(), measurements.end() - kMostAhead / 2);
}

}  // namespace

FrontOutput::FrontOutput(std::function<void(const Belief&)> publish, double rate_hz, std::vector<bool> prompts,
                         const LiveClock& clock)
    : publish_(std::move(publish)),
      period_(from_seconds(1.0 / rate_hz)),
      prompts_(std::move(prompts)),
      clock_(clock),
      thread_([this] { run(); }) {}

FrontOutput::~FrontOutput() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    wake_.notify_all();
  }
  thread_.join();
}

void FrontOutput::arrived(const Measurement& measurement) {
  const std::lock_guard lock(mutex_);
  incoming_.push_back(measurement);
  bound(incoming_);  // the thread may be far behind a flood
  if (prompts_[measurement.sensor]) {
    prompted_ = true;
    wake_.notify_one();
  }
}

void FrontOutput::rebase(std::unique_ptr<Front> front) {
  const std::lock_guard lock(mutex_);
  base_.swap(front);  // the older one is destroyed after the lock
}

void FrontOutput::replace(std::unique_ptr<Front> front) {
  std::unique_lock lock(mutex_);
  base_.swap(front);
  must_follow_ = prompted_ = true;
  wake_.notify_one();
  followed_.wait(lock, [this] { return !must_follow_; });
}

Latency FrontOutput::latency() const {
  const std::lock_guard lock(mutex_);
  return latency_;
}

void FrontOutput::run() {
  auto due = std::chrono::steady_clock::now();
  std::vector<Measurement> news;
  while (true) {
    std::unique_ptr<Front> base;
    {
      std::unique_lock lock(mutex_);
      due += period_;
      due = std::max(due, std::chrono::steady_clock::now());
      wake_.wait_until(lock, due, [&] { return stopped_ || prompted_; });
      if (stopped_) return;
      if (std::exchange(prompted_, false)) due = std::chrono::steady_clock::now();
      news.clear();
      news.swap(incoming_);
      base.swap(base_);
    }
    ahead_.insert(ahead_.end(), news.begin(), news.end());
    bound(ahead_);
    try {
      if (base) {
        follow(std::move(base));
      } else if (front_) {
        for (const Measurement& m : news) advance(m);
      }
      report_following();
      if (!front_) continue;
      // Stamps may be of another clock: the present is the newest stamp and the time since it arrived.
      const Duration since = std::clamp<Duration>(clock_.now() - newest_arrival_, Duration::zero(), period_ * 2);
      publish_(front_->at(std::max(newest_stamp_, front_->stamp()) + since));
    } catch (const std::exception&) {
      front_ = nullptr;  // the filter processes the same measurements and reports what is wrong
      report_following();
    }
    const std::lock_guard lock(mutex_);
    for (const Measurement& m : news) {
      if (prompts_[m.sensor]) latency_.add(to_seconds(clock_.now() - m.arrival));
    }
  }
}

void FrontOutput::report_following() {
  const std::lock_guard lock(mutex_);
  // If another base came meanwhile, `replace` waits for that one.
  if (base_) return;
  must_follow_ = false;
  followed_.notify_all();
}

void FrontOutput::follow(std::unique_ptr<Front> base) {
  front_ = std::move(base);
  const Time committed = newest_stamp_ = front_->stamp();
  const auto stamp = [&](const Measurement& m) { return front_->corrected_stamp(m); };
  std::erase_if(ahead_, [&](const Measurement& m) { return stamp(m) <= committed; });
  std::ranges::stable_sort(ahead_, {}, stamp);
  for (const Measurement& m : ahead_) advance(m);
}

/// An implausible stamp must not move the front away: the filter decides about it.
void FrontOutput::advance(const Measurement& m) {
  const Time stamp = front_->corrected_stamp(m);
  if (stamp > front_->stamp() + kFarAhead) return;
  front_->add(m);
  newest_stamp_ = std::max(newest_stamp_, stamp);
  newest_arrival_ = std::max(newest_arrival_, m.arrival);
}

}  // namespace waymark::host
