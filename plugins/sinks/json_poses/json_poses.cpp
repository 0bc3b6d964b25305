// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "outlet.hpp"
#include "pose_line.hpp"
#include "server_outlet.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::json_poses {
namespace {

bool was_taken_in(Fate fate) {
  return fate == Fate::fused || fate == Fate::gated || fate == Fate::mapped || fate == Fate::skipped ||
         fate == Fate::held_out;
}

/// The pose as lines of JSON, for programs that run beside the robot.
class JsonPoses final : public Sink {
 public:
  explicit JsonPoses(const Config& config);

  void start(const RunInfo& info) override;
  void front(const Belief& belief) override;
  void write(const Snapshot& snapshot) override;
  void finish(const Snapshot* last, const RunReport& report) override;
  std::vector<std::string> take_events() override { return events_.take(); }

 private:
  std::string line_of(const Belief& belief) const;

  std::string to_;
  std::string file_;
  live::NetworkPlace network_;
  ServerLimits limits_{};
  bool wants_front_;
  std::string payload_;
  std::string sensor_;

  live::EventList events_;
  std::mutex mutex_;  // `front` is called by another thread than the rest
  std::unique_ptr<Outlet> outlet_;
  std::optional<Estimate> estimate_;  // once started
  Health health_;
};

JsonPoses::JsonPoses(const Config& config)
    : to_(config.choice({"to",
                         "where the lines go: a `file` in the output folder; datagrams to a UDP port; every client of "
                         "a TCP port or of a Unix socket"},
                        {"file", "udp", "tcp", "unix"})),
      wants_front_(config.choice({"when",
                                  "`committed`: after every measurement that the filter took; `front`: the pose now, "
                                  "at the rate of the live host, of a running robot only"},
                                 {"committed", "front"}, "committed") == "front"),
      payload_(config.choice({"payload",
                              "what a line is: a `pose`, or a message of that payload for the source json of another "
                              "robot: the velocity, or the position in the map"},
                             {"pose", "BodyTwist", "GnssFix"}, "pose")) {
  if (payload_ != "pose") sensor_ = config.text({"sensor", "the sensor that the messages name"});
  if (to_ == "file") {
    file_ = config.output({"file", "file name in the output folder"}, "poses.jsonl");
    return;
  }
  if (to_ == "udp") {
    network_ = live::read_network_place(config, "address that the datagrams are sent to");
    return;
  }
  limits_.clients =
      static_cast<std::size_t>(config.integer_in({"max_clients", "clients at a time; others are refused"}, 1, 1000, 8));
  limits_.lines = static_cast<std::size_t>(config.integer_in(
      {"max_waiting_lines", "lines that wait for a client that reads slowly; the oldest ones are left out"}, 1, 100'000,
      256));
  if (to_ == "tcp") {
    network_ = live::read_network_place(
        config,
        "address to listen at; others than that of this machine itself can be reached by anybody in the network");
  } else {
    file_ = config.output({"path", "of the Unix socket, in the output folder, which only the same user can open"},
                          "poses.sock");
  }
}

void JsonPoses::start(const RunInfo& info) {
  if (to_ == "file") {
    outlet_ = std::make_unique<FileOutlet>(info.out_dir / file_);
  } else if (to_ == "udp") {
    outlet_ = std::make_unique<DatagramOutlet>(network_, events_);
  } else {
    live::ServerPlace place = network_;
    if (to_ == "unix") place = info.out_dir / file_;
    outlet_ = std::make_unique<ServerOutlet>(std::move(place), limits_, events_);
  }
}

std::string JsonPoses::line_of(const Belief& belief) const {
  if (payload_ == "BodyTwist") return twist_line(belief, sensor_);
  if (payload_ == "GnssFix") return fix_line(belief, *estimate_, sensor_);
  return pose_line(belief, *estimate_, health_);
}

void JsonPoses::front(const Belief& belief) {
  if (!wants_front_) return;
  const std::lock_guard lock(mutex_);
  if (outlet_ && estimate_) outlet_->send(line_of(belief));
}

void JsonPoses::write(const Snapshot& snapshot) {
  if (!snapshot.started()) return;
  const std::lock_guard lock(mutex_);
  if (!estimate_) estimate_.emplace(snapshot.layout());
  health_.state = snapshot.health().state;
  health_.reason = snapshot.health().reason;
  if (outlet_ && !wants_front_ && was_taken_in(snapshot.fate())) outlet_->send(line_of(snapshot.belief()));
}

void JsonPoses::finish(const Snapshot*, const RunReport&) {
  const std::lock_guard lock(mutex_);
  if (const auto outlet = std::exchange(outlet_, nullptr)) outlet->finish();
}

}  // namespace
}  // namespace waymark::json_poses

WAYMARK_PLUGIN(waymark::Sink, waymark::json_poses::JsonPoses, "json_poses", "1.0.0")
