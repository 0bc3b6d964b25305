// SPDX-License-Identifier: Apache-2.0
#include "live_view.hpp"

#include <cstddef>
#include <cstdio>
#include <limits>
#include <utility>

#include "waymark/host/live_settings.hpp"

namespace waymark::python {
namespace {

/// A peer that connects and goes must not fill the memory of a robot that runs for months.
constexpr std::size_t kMostEvents = 1000;

std::string silence_of(std::chrono::duration<double> silence) {
  char text[64];
  std::snprintf(text, sizeof(text), "nothing has arrived for %.1f s", silence.count());
  return text;
}

}  // namespace

void LiveView::arrived(const Measurement&) {
  const std::lock_guard lock(mutex_);
  last_arrival_ = std::chrono::steady_clock::now();
}

void LiveView::write(const Snapshot& snapshot) {
  StepRecord record = record_of(snapshot);
  const std::lock_guard lock(mutex_);
  last_ = std::move(record);
  pose_indices_ = snapshot.layout().pose_indices();
}

void LiveView::front(const Belief& belief) {
  StepRecord record;
  record.stamp = belief.stamp;
  record.belief = belief;
  record.started = true;
  record.effective_sample_size = std::numeric_limits<double>::quiet_NaN();
  const std::lock_guard lock(mutex_);
  if (!last_) return;  // without the layout of the state
  record.health = last_->health;
  record.health_reason = last_->health_reason;
  record.datum = last_->datum;
  record.pose_covariance = belief.P(pose_indices_, pose_indices_);
  front_ = std::move(record);
}

void LiveView::note(const Event& event) {
  const std::lock_guard lock(mutex_);
  if (events_.size() == kMostEvents) events_.pop_front();
  events_.push_back(event);
}

std::optional<StepRecord> LiveView::front() const {
  const std::lock_guard lock(mutex_);
  return front_;
}

std::optional<StepRecord> LiveView::last() const {
  const std::lock_guard lock(mutex_);
  return last_;
}

LiveView::HealthNow LiveView::health() const {
  const std::lock_guard lock(mutex_);
  if (!last_arrival_) return {Health::State::lost, "nothing has arrived"};
  const auto silence = std::chrono::steady_clock::now() - *last_arrival_;
  if (silence > host::kSilence) return {Health::State::lost, silence_of(silence)};
  if (!last_) return {Health::State::lost, "the filter has not started"};
  return {last_->health, last_->health_reason};
}

std::vector<Event> LiveView::events() const {
  const std::lock_guard lock(mutex_);
  return {events_.begin(), events_.end()};
}

}  // namespace waymark::python
