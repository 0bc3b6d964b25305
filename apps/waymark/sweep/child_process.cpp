// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/sweep/child_process.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <boost/process/args.hpp>
#include <boost/process/child.hpp>
#include <boost/process/exe.hpp>
#include <boost/process/io.hpp>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <iterator>
#include <system_error>

#include "waymark/base/error.hpp"

namespace waymark::sweep {

namespace {

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

Ended run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                  const std::filesystem::path& out, const std::filesystem::path& err) {
  namespace process = boost::process;
  const auto start = std::chrono::steady_clock::now();  // reported, never used by a filter
  std::error_code error;
  process::child child(process::exe = program.string(), process::args = arguments,
                       process::std_in<process::null, process::std_out> out.string(), process::std_err > err.string(),
                       error);
  if (error) throw Error(fmt::format("{}: cannot be started: {}", program.string(), error.message()));
  const pid_t pid = child.id();
  child.detach();  // wait4 reaps it: it reports the CPU time as well
  int status = 0;
  rusage usage{};
  while (::wait4(pid, &status, 0, &usage) < 0) {
    if (errno != EINTR) throw Error(fmt::format("{}: {}", program.string(), std::generic_category().message(errno)));
  }
  Ended ended;
  ended.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  ended.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  ended.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return ended;
}

std::string read_all(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

}  // namespace waymark::sweep
