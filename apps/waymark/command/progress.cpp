// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <string>

#include "apps/waymark/command/command_line.hpp"

namespace waymark::command {

namespace {

constexpr auto kInterval = std::chrono::milliseconds(200);
constexpr int kBarWidth = 24;

/// Empty if there are none: of a dense map there is no such number.
std::string landmarks_of(const Snapshot& snapshot) {
  std::ptrdiff_t confirmed = 0;
  bool any = false;
  try {
    for (const MapDescription& map : snapshot.best_maps(MapDetail::summary)) {
      any = any || !map.landmarks.empty();
      confirmed += std::ranges::count_if(map.landmarks, &LandmarkView::confirmed);
    }
  } catch (const std::exception&) {
    return "";  // a map that fails here does not end the run
  }
  return any ? fmt::format("  landmarks {}", confirmed) : "";
}

}  // namespace

Progress::Progress() : terminal_(isatty(STDERR_FILENO) != 0) {}

double Progress::wall_seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

void Progress::update(const Snapshot& snapshot, double share) {
  if (snapshot.fate() == Fate::mistimed) return;  // its stamp is no time of the log
  if (first_) first_stamp_ = snapshot.stamp();
  first_ = false;
  log_seconds_ = to_seconds(snapshot.stamp() - first_stamp_);
  const int tenths = static_cast<int>(10.0 * share);
  if (terminal_) {
    const auto now = Clock::now();
    if (now - last_shown_ < kInterval) return;
    last_shown_ = now;
  } else {
    if (tenths <= tenths_shown_) return;
    tenths_shown_ = tenths;
  }
  double n_eff = 0.0;
  if (snapshot.started()) {
    n_eff = snapshot.effective_sample_size();
    // A large dense map takes its time to sum itself up: no more than about a fiftieth of the run.
    if (const auto now = Clock::now(); now >= next_landmarks_) {
      landmarks_ = landmarks_of(snapshot);
      next_landmarks_ = now + 50 * (Clock::now() - now);
    }
  }
  const double shown = std::clamp(share, 0.0, 1.0);
  const int filled = static_cast<int>(shown * kBarWidth);
  print_message("{}[{}{}] {:3.0f} %  t {:.1f} s  {:.0f}x real time  N_eff {:.1f}{}{}", terminal_ ? "\r" : "",
                std::string(static_cast<std::size_t>(filled), '='),
                std::string(static_cast<std::size_t>(kBarWidth - filled), ' '), 100.0 * shown, log_seconds_,
                log_seconds_ / std::max(wall_seconds(), 1e-9), n_eff, landmarks_, terminal_ ? "   " : "\n");
  line_open_ = terminal_;
}

void Progress::finish() {
  if (line_open_) print_message("\n");
  line_open_ = false;
}

}  // namespace waymark::command
