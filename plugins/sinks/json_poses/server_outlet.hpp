// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <condition_variable>
#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "outlet.hpp"
#include "plugins/shared/live/stream_server.hpp"

namespace waymark::json_poses {

/// Bounds of what clients can demand.
struct ServerLimits {
  std::size_t clients;
  std::size_t lines;  ///< that wait for a client
};

/// Lines for every client of a server, from when it connects. A client that reads too slowly loses the oldest ones.
/// Sockets are served by a thread of this object.
class ServerOutlet final : public Outlet {
 public:
  /// Throws Error if it cannot listen there.
  ServerOutlet(live::ServerPlace place, ServerLimits limits, live::EventList& events);
  ~ServerOutlet() override;
  ServerOutlet(const ServerOutlet&) = delete;
  ServerOutlet& operator=(const ServerOutlet&) = delete;

  void send(std::string_view line) override;
  /// Gives the clients 0.5 s to read what waits for them.
  void finish() override;

 private:
  struct Client;
  using ClientList = std::list<std::shared_ptr<Client>>;

  void run();
  void welcome(live::StreamSocket socket, const std::string& peer);
  void watch(const std::shared_ptr<Client>& client);
  void write_all();
  void write(const std::shared_ptr<Client>& client);
  void dismiss(const std::shared_ptr<Client>& client, const std::string& reason);
  void stop();

  std::string name_;
  ServerLimits limits_;
  live::EventList& events_;
  boost::asio::io_context context_;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  live::StreamServer server_;

  std::mutex mutex_;  // of all below
  std::condition_variable progress_;
  ClientList clients_;
  bool is_woken_ = false;
  bool was_connected_ = false;
  bool is_full_ = false;

  std::thread thread_;
};

}  // namespace waymark::json_poses
