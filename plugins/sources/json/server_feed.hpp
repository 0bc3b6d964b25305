// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <list>
#include <string>

#include "live_feed.hpp"
#include "plugins/shared/live/stream_server.hpp"

namespace waymark::json {

/// Bounds of what peers can demand.
struct StreamLimits {
  std::size_t line_bytes;
  std::size_t clients;
};

/// The lines of the clients of a server.
class ServerFeed final : public LiveFeed {
 public:
  ServerFeed(live::ServerPlace place, StreamLimits limits, live::EventList& events);
  ~ServerFeed() override;
  ServerFeed(const ServerFeed&) = delete;
  ServerFeed& operator=(const ServerFeed&) = delete;

 private:
  struct Client;

  void open() override { server_.open(); }
  void welcome(live::StreamSocket socket, const std::string& peer);
  void read(std::list<Client>::iterator client);
  void dismiss(std::list<Client>::iterator client, const std::string& reason);

  std::string name_;
  StreamLimits limits_;
  live::StreamServer server_;
  std::list<Client> clients_;
  bool was_connected_ = false;
  bool is_full_ = false;
};

}  // namespace waymark::json
