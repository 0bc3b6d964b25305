// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "live_clock.hpp"
#include "waymark/interface/source.hpp"

namespace waymark::host {

/// A log in a live run: delivered as if its robot ran now, with stamps moved to the present by one duration.
class PacedLog final : public Source {
 public:
  PacedLog(std::shared_ptr<Source> log, std::shared_ptr<const LiveClock> clock)
      : log_(std::move(log)), clock_(std::move(clock)) {}

  const std::vector<Channel>& channels() const override { return log_->channels(); }
  bool is_live() const override { return true; }
  std::optional<Measurement> next() override;
  void stop() override;
  const std::vector<BadRecord>& bad_records() const override { return log_->bad_records(); }
  std::vector<std::string> notices() const override { return log_->notices(); }

 private:
  std::shared_ptr<Source> log_;
  std::shared_ptr<const LiveClock> clock_;
  std::optional<Duration> shift_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopped_ = false;
};

}  // namespace waymark::host
