// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/live_settings.hpp"

#include <limits>

namespace waymark::host {

LiveSettings read_live_settings(const Config& yaml) {
  const Config live = yaml.child_or_empty({"live", "", "how a running robot is served", "defaults"});
  LiveSettings settings;
  settings.real_time = live.boolean(
      {"real_time", "true: a log is delivered as if its robot ran now; a log beside a live source always is"}, false);
  settings.front_hz = live.number_in(
      {"front_hz", "Hz", "rate at which the pose now goes to the sinks; it also follows each motion measurement"}, 1.0,
      1000.0, 50.0);
  settings.queue = static_cast<std::size_t>(
      live.integer_in({"queue", "most measurements that wait for the filter; if it is full, sources wait, too"}, 100,
                      10'000'000, 20'000));
  settings.overload_after = from_seconds(live.number_in(
      {"overload_after_s", "s",
       "waiting time from which on only the newest scan is kept of a sensor that feeds maps only; twice as long "
       "if a map localises with it"},
      0.01, 3600.0, 0.3));
  settings.may_drop =
      live.texts({"may_drop", "", "sensors whose oldest measurements are dropped if the queue is full", "none"},
                 std::vector<std::string>{});
  settings.control = live.text(
      {"control", "", "Unix socket for `waymark ctl`, relative to the working folder; `none`: no socket"}, "none");
  if (settings.control == "none") settings.control.clear();
  const Config checkpoint =
      live.child_or_empty({"checkpoint", "", "the state is written in between, to go on from after a failure", "none"});
  settings.resumes = checkpoint.boolean(
      {"resume", "a run begins at the checkpoint in its output folder, if there is one of this configuration"}, false);
  if (live.has("checkpoint")) {
    settings.checkpoint = checkpoint.output({"file", "file in the output folder"}, "live.ckpt");
    settings.checkpoint_every =
        from_seconds(checkpoint.number_in({"every_s", "s", "time between two checkpoints"}, 0.1, 86400.0, 10.0));
  }
  return settings;
}

}  // namespace waymark::host
