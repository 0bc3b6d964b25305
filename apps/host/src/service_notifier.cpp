// SPDX-License-Identifier: Apache-2.0
#include "service_notifier.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

namespace waymark::host {
namespace {

/// One datagram (sd_notify(3)). libsystemd's own function waits while the socket is full, and a robot must not.
void notify(std::string_view state) {
  const char* path = std::getenv("NOTIFY_SOCKET");
  sockaddr_un address{};
  const std::size_t length = path == nullptr ? 0 : std::strlen(path);
  if (length < 2 || length >= sizeof address.sun_path || (path[0] != '/' && path[0] != '@')) return;
  address.sun_family = AF_UNIX;
  std::memcpy(static_cast<char*>(address.sun_path), path, length);
  if (path[0] == '@') address.sun_path[0] = '\0';  // of the abstract kind
  const int descriptor = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return;
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);
  ::sendto(descriptor, state.data(), state.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
           reinterpret_cast<const sockaddr*>(&address), size);
  ::close(descriptor);
}

/// A number in the environment; 0: there is none.
std::uint64_t number_of(const char* name) {
  const char* text = std::getenv(name);
  std::uint64_t number = 0;
  if (text != nullptr) std::from_chars(text, text + std::strlen(text), number);
  return number;
}

}  // namespace

ServiceNotifier::ServiceNotifier() {
  const std::uint64_t process = number_of("WATCHDOG_PID");
  if (process == 0 || process == static_cast<std::uint64_t>(::getpid()))
    interval_ = std::chrono::microseconds(number_of("WATCHDOG_USEC") / 4);
}

void ServiceNotifier::ready() {
  if (!std::exchange(ready_, true)) notify("READY=1");
}

void ServiceNotifier::alive() {
  const auto now = std::chrono::steady_clock::now();
  if (interval_.count() == 0 || now - last_ < interval_) return;
  last_ = now;
  notify("WATCHDOG=1");
}

void ServiceNotifier::stopping() { notify("STOPPING=1"); }

}  // namespace waymark::host
