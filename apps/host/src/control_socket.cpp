// SPDX-License-Identifier: Apache-2.0
#include "control_socket.hpp"

#include <fmt/format.h>

#include <boost/asio.hpp>
#include <chrono>
#include <map>
#include <thread>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::host {

namespace asio = boost::asio;
using Protocol = asio::local::stream_protocol;
using boost::system::error_code;

namespace {

constexpr std::size_t kLongestCommand = 4096;
constexpr std::size_t kMostPeers = 16;
constexpr std::chrono::seconds kPatience{10};
constexpr std::chrono::milliseconds kPause{200};

/// Removes the socket of a run that has ended.
void remove_abandoned(const std::filesystem::path& path) {
  const std::filesystem::file_status status = std::filesystem::symlink_status(path);
  if (!std::filesystem::exists(status)) return;
  if (!std::filesystem::is_socket(status)) throw Error("the file is not a socket");
  asio::io_context context;
  Protocol::socket probe(context);
  error_code error;
  probe.connect(Protocol::endpoint(path.string()), error);
  if (!error) throw Error("another run listens there");
  std::filesystem::remove(path);
}

}  // namespace

class ControlSocket::Server {
 public:
  Server(const std::filesystem::path& path, std::function<std::uint64_t(std::string)> submit)
      : path_(path), submit_(std::move(submit)), acceptor_(context_), retry_(context_) {
    try {
      remove_abandoned(path);
      acceptor_.open();
      acceptor_.bind(Protocol::endpoint(path.string()));
      // Nobody can connect before `listen`, so there is no moment at which others could.
      std::filesystem::permissions(path, std::filesystem::perms(0600));
      acceptor_.listen();
    } catch (const std::exception& error) {
      throw Error(fmt::format("live.control: {}: {}", path.string(), error.what()));
    }
    accept();
    thread_ = std::thread([this] { context_.run(); });
  }

  ~Server() {
    asio::post(context_, [this] { context_.stop(); });  // behind the answers that were passed on before
    thread_.join();
    error_code ignored;
    acceptor_.close(ignored);
    std::error_code also_ignored;
    std::filesystem::remove(path_, also_ignored);
  }

  void reply(std::uint64_t number, std::string answer) {
    asio::post(context_, [this, number, answer = std::move(answer)]() mutable {
      const auto found = waiting_.find(number);
      if (found == waiting_.end()) return;
      const auto peer = std::exchange(found->second, nullptr);
      waiting_.erase(found);
      peer->answer = std::move(answer) + "\n";
      limit_time(peer);  // of a peer that does not read its answer, too
      asio::async_write(peer->socket, asio::buffer(peer->answer), [this, peer](const error_code& error, std::size_t) {
        peer->deadline.cancel();
        error ? close(peer) : read(peer);
      });
    });
  }

 private:
  struct Peer {
    explicit Peer(Protocol::socket accepted) : socket(std::move(accepted)), deadline(socket.get_executor()) {}
    Protocol::socket socket;
    asio::steady_timer deadline;
    std::string received;
    std::string answer;
  };

  void accept() {
    acceptor_.async_accept([this](const error_code& error, Protocol::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) {
        // Too many open files, for a while. A pause, so that the fault is not repeated at once.
        retry_.expires_after(kPause);
        retry_.async_wait([this](const error_code& aborted) {
          if (!aborted) accept();
        });
        return;
      }
      if (peers_ < kMostPeers) {
        ++peers_;
        read(std::make_shared<Peer>(std::move(socket)));
      }
      accept();
    });
  }

  static void limit_time(const std::shared_ptr<Peer>& peer) {
    peer->deadline.expires_after(kPatience);
    peer->deadline.async_wait([peer](const error_code& error) {
      error_code ignored;
      if (!error) peer->socket.cancel(ignored);
    });
  }

  void read(const std::shared_ptr<Peer>& peer) {
    limit_time(peer);
    asio::async_read_until(peer->socket, asio::dynamic_buffer(peer->received, kLongestCommand), '\n',
                           [this, peer](const error_code& error, std::size_t length) {
                             peer->deadline.cancel();
                             if (error) return close(peer);
                             std::string line = peer->received.substr(0, length - 1);
                             peer->received.erase(0, length);
                             waiting_[submit_(std::move(line))] = peer;
                           });
  }

  void close(const std::shared_ptr<Peer>& peer) {
    error_code ignored;
    peer->socket.close(ignored);
    --peers_;
  }

  std::filesystem::path path_;
  std::function<std::uint64_t(std::string)> submit_;
  asio::io_context context_;
  Protocol::acceptor acceptor_;
  asio::steady_timer retry_;
  std::map<std::uint64_t, std::shared_ptr<Peer>> waiting_;  // for the answers to their commands
  std::size_t peers_ = 0;
  std::thread thread_;
};

ControlSocket::ControlSocket(const std::filesystem::path& path, std::function<std::uint64_t(std::string)> submit)
    : server_(std::make_unique<Server>(path, std::move(submit))) {}
ControlSocket::~ControlSocket() = default;

void ControlSocket::reply(std::uint64_t number, std::string answer) { server_->reply(number, std::move(answer)); }

}  // namespace waymark::host
