// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace waymark::host {

/// A Unix socket (mode 0600) that takes commands, one line each, and answers each with one line. A peer sends at most
/// 4096 bytes and is dropped after 10 s without a command; at most 16 are connected.
class ControlSocket {
 public:
  /// `submit` passes a command on and returns its number; it is called by the socket's thread. Throws Error if the
  /// socket cannot be made, or if another run listens there.
  ControlSocket(const std::filesystem::path& path, std::function<std::uint64_t(std::string)> submit);
  ~ControlSocket();
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

  /// Answers the command of that number. May be called by any thread.
  void reply(std::uint64_t number, std::string answer);

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace waymark::host
