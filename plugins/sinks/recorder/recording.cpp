// SPDX-License-Identifier: Apache-2.0
#include "recording.hpp"

#include <fmt/format.h>

#include <chrono>
#include <exception>
#include <span>
#include <utility>

#include "waymark/base/overloaded.hpp"

namespace waymark::recorder {
namespace {

/// Memory that a payload keeps, about.
class PayloadSize final : public FieldVisitor {
 public:
  void field(const FieldInfo&, const FieldValue& value) override {
    std::visit(Overloaded{[](std::span<const double>) {}, [](std::int64_t) {}, [](bool) {}, [](FieldWord) {},
                          [this](const auto& list) { bytes += list.size_bytes(); }},
               value);
  }
  void list(const FieldInfo&, std::size_t size) override { bytes += size * kElement; }

  static constexpr std::size_t kElement = 64;
  std::size_t bytes = 256;  // of the struct itself
};

std::size_t size_of(const Entry& entry) {
  return std::visit(Overloaded{[](const Delivered& delivered) {
                                 PayloadSize size;
                                 delivered.measurement.payload->visit(size);
                                 return size.bytes;
                               },
                               [](const Commanded& commanded) { return sizeof commanded + commanded.text.size(); },
                               [](const Attached& attached) { return sizeof attached + attached.content.size(); }},
                    entry);
}

}  // namespace

Recording::Recording(const std::filesystem::path& file, FlightEncoder encoder, std::size_t queue_bytes)
    : file_(file), encoder_(std::move(encoder)), path_(file), queue_bytes_(queue_bytes) {
  thread_ = std::thread([this] { run(); });
}

Recording::~Recording() { finish(); }

void Recording::add(Entry entry) {
  const std::size_t bytes = size_of(entry);
  const std::lock_guard lock(mutex_);
  if (is_ending_) return;
  // What is attached comes at the start or the end, when the filter does not wait.
  if (bytes_ + bytes > queue_bytes_ && !std::holds_alternative<Attached>(entry)) {
    is_ending_ = true;
    ended_because_ = fmt::format("the disk is too slow: more than {} MB wait to be written", queue_bytes_ >> 20);
    events_.push_back(fmt::format("the recording to {} ended early: {}", path_.string(), ended_because_));
  } else {
    bytes_ += bytes;
    queue_.push_back({std::move(entry), bytes});
  }
  filled_.notify_one();
}

void Recording::finish() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
    filled_.notify_one();
  }
  if (thread_.joinable()) thread_.join();
}

std::vector<std::string> Recording::take_events() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

void Recording::end_early(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  is_ending_ = true;
  queue_.clear();
  events_.push_back(fmt::format("the recording ended early: {}", reason));
}

void Recording::encode(const Entry& entry) {
  std::visit(
      Overloaded{[this](const Delivered& one) { encoder_.add(one.measurement, one.is_dropped); },
                 [this](const Commanded& one) { encoder_.add_command(one.arrival, one.text); },
                 [this](const Attached& one) { encoder_.add_attachment(one.name, one.media_type, one.content); }},
      entry);
}

void Recording::write(std::vector<std::uint8_t> bytes) {
  if (!bytes.empty()) file_.append(bytes);
}

void Recording::run() {
  constexpr std::chrono::seconds kIdle{1};
  try {
    write(encoder_.take());
    while (true) {
      std::deque<Queued> taken;
      {
        std::unique_lock lock(mutex_);
        const bool woken = filled_.wait_for(lock, kIdle, [this] { return !queue_.empty() || is_ending_; });
        taken = std::exchange(queue_, {});
        if (woken && taken.empty()) break;
      }
      if (taken.empty()) {
        if (!flush_when_idle_) continue;
        encoder_.flush();
      }
      for (const Queued& one : taken) {
        encode(one.entry);
        write(encoder_.take());
        const std::lock_guard lock(mutex_);
        bytes_ -= one.bytes;
      }
      write(encoder_.take());
      const std::lock_guard lock(mutex_);
      for (std::string& event : encoder_.take_events()) events_.push_back(std::move(event));
    }
    if (!ended_because_.empty()) encoder_.add_metadata("waymark.end", {{"reason", ended_because_}});
    encoder_.finish();
    write(encoder_.take());
  } catch (const std::exception& error) {
    end_early(error.what());
  }
}

}  // namespace waymark::recorder
