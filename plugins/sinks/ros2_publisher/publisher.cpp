// SPDX-License-Identifier: Apache-2.0
#include "publisher.hpp"

#include <utility>

#include "plugins/shared/live/thread_without_signals.hpp"

namespace waymark::ros2_publisher {

Publisher::Publisher(std::size_t most_bytes) : most_bytes_(most_bytes) {
  thread_ = live::thread_without_signals([this] { run(); });
}

Publisher::~Publisher() { finish({}); }

void Publisher::send(dds::Writer& writer, std::vector<std::uint8_t> cdr, std::optional<Time> written) {
  const std::lock_guard lock(mutex_);
  bytes_ += cdr.size();
  waiting_.push_back({&writer, std::move(cdr), written});
  while (bytes_ > most_bytes_ && waiting_.size() > 1) {
    bytes_ -= waiting_.front().cdr.size();
    waiting_.pop_front();
    ++left_out_;
  }
  filled_.notify_one();
}

void Publisher::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    filled_.wait(lock, [this] { return stopped_ || !waiting_.empty(); });
    if (stopped_) return;
    Waiting next = std::move(waiting_.front());
    waiting_.pop_front();
    bytes_ -= next.cdr.size();
    is_writing_ = true;
    lock.unlock();
    next.writer->write(std::move(next.cdr), next.written);
    lock.lock();
    is_writing_ = false;
    if (waiting_.empty()) emptied_.notify_all();
  }
}

void Publisher::finish(std::chrono::milliseconds limit) {
  {
    std::unique_lock lock(mutex_);
    emptied_.wait_for(lock, limit, [this] { return waiting_.empty() && !is_writing_; });
    stopped_ = true;
    left_out_ += waiting_.size();
    waiting_.clear();
    filled_.notify_one();
  }
  if (thread_.joinable()) thread_.join();
}

std::uint64_t Publisher::left_out() const {
  const std::lock_guard lock(mutex_);
  return left_out_;
}

}  // namespace waymark::ros2_publisher
