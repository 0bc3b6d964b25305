// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <optional>
#include <utility>
#include <vector>

#include "connection.hpp"
#include "epoch_reports.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::gpsd {
namespace {

constexpr std::uint16_t kPortOfGpsd = 2947;

/// Fixes of the receivers that gpsd serves.
class GpsdSource final : public Source {
 public:
  GpsdSource(const Config& config, const Rig& rig)
      : connection_(live::read_network_place(config, "address of gpsd", kPortOfGpsd),
                    config.text({"device", "receiver, as gpsd names it: /dev/ttyUSB0; empty: any"}, ""), events_),
        settle_(std::chrono::milliseconds(static_cast<std::int64_t>(
            1e3 * config.number_in({"settle_s", "s",
                                    "reports of one time are put together until one of another time comes, or until "
                                    "there was none for so long"},
                                   0.001, 10.0, 0.05)))) {
    channels_.push_back(channel_to_sensor(config.child({"gnss", "its `sensor` gets the fixes"}), rig, GnssFix::kType));
    config.child("gnss").reject_unread();
  }

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  bool is_live() const override { return true; }
  void stop() override { connection_.stop(); }
  std::vector<std::string> take_events() override { return events_.take(); }

 private:
  Measurement measurement_of(TimedFix fix);

  std::vector<Channel> channels_;
  live::EventList events_;
  Connection connection_;
  std::chrono::milliseconds settle_;
  EpochReports reports_;
  std::uint64_t delivered_ = 0;
};

std::optional<Measurement> GpsdSource::next() {
  using Got = Connection::Got;
  live::Line line;
  for (;;) {
    std::optional<TimedFix> fix;
    switch (connection_.next(line, reports_.is_waiting() ? settle_ : std::chrono::milliseconds::zero())) {
      case Got::line:
        fix = reports_.take(line.text);
        break;
      case Got::pause:
      case Got::lost:
        fix = reports_.finish();
        break;
      case Got::end:
        return std::nullopt;
    }
    if (fix) return measurement_of(std::move(*fix));
  }
}

Measurement GpsdSource::measurement_of(TimedFix fix) {
  Measurement measurement;
  measurement.stamp = fix.stamp;
  measurement.sequence = delivered_++;
  measurement.payload = std::move(fix.fix);
  return measurement;
}

}  // namespace
}  // namespace waymark::gpsd

WAYMARK_PLUGIN(waymark::Source, waymark::gpsd::GpsdSource, "gpsd", "1.0.0")
