// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

namespace waymark::host {

/// Reports to systemd, if it started this program (NOTIFY_SOCKET, WATCHDOG_USEC): that the filter runs, that it is
/// alive, that it stops. Does nothing elsewhere, and never waits.
class ServiceNotifier {
 public:
  ServiceNotifier();

  /// The robot's pose is known from now on; later calls do nothing.
  void ready();
  /// Call it often: the filter is alive. A few messages per watchdog interval are sent.
  void alive();
  void stopping();

 private:
  bool ready_ = false;
  std::chrono::microseconds interval_{0};  // 0: no watchdog
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace waymark::host
