// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>
#include <thread>
#include <utility>

namespace waymark::live {

/// Starts a thread that no signal is delivered to. Signals are for the program's first thread: its handlers end what
/// that one waits for.
template <class Run>
std::thread thread_without_signals(Run run) {
  struct Mask {
    sigset_t before{};
    ~Mask() { pthread_sigmask(SIG_SETMASK, &before, nullptr); }
  } mask;
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &mask.before);  // a new thread inherits the mask
  return std::thread(std::move(run));
}

}  // namespace waymark::live
