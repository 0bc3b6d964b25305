// SPDX-License-Identifier: Apache-2.0
#include "input_feed.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::json {

constexpr std::size_t kBytesOfInput = 1 << 14;

InputFeed::InputFeed(int input, std::size_t longest_line, live::EventList& events)
    : input_(input),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      events_(events),
      splitter_(longest_line, live::LineEnd::lf),
      buffer_(kBytesOfInput),
      origin_(std::make_shared<const std::string>("stdin:")) {
  if (wake_ < 0) throw Error(fmt::format("stdin: no eventfd: {}", std::strerror(errno)));
}

InputFeed::~InputFeed() { ::close(wake_); }

void InputFeed::stop() {
  stopped_ = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_, &one, sizeof one);
}

bool InputFeed::next(FedLine& line) {
  while (lines_.empty()) {
    if (stopped_ || ended_) return false;
    read();
  }
  if (stopped_) return false;
  line = {std::move(lines_.front()), origin_};
  lines_.pop_front();
  return true;
}

void InputFeed::read() {
  std::array<pollfd, 2> waits{pollfd{input_, POLLIN, 0}, pollfd{wake_, POLLIN, 0}};
  if (::poll(waits.data(), waits.size(), -1) < 0 || waits[1].revents != 0) return;
  const ssize_t count = ::read(input_, buffer_.data(), buffer_.size());
  if (count > 0) return splitter_.add({buffer_.data(), static_cast<std::size_t>(count)}, lines_);
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return;
  events_.add(count == 0 ? "stdin: it has ended" : fmt::format("stdin: lost: {}", std::strerror(errno)));
  splitter_.finish(lines_);
  ended_ = true;
}

}  // namespace waymark::json
