// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <boost/asio.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"

namespace waymark::command {

namespace {

namespace asio = boost::asio;

constexpr std::size_t kLongestAnswer = 1 << 20;

struct CtlOptions {
  std::filesystem::path socket;
  std::vector<std::string> words;
};

std::string ask(const CtlOptions& options) {
  const std::string command = fmt::format("{}", fmt::join(options.words, " "));
  // What follows a line feed would be another command.
  if (command.find('\n') != std::string::npos) throw Error("a command is one line");
  try {
    asio::io_context context;
    asio::local::stream_protocol::socket socket(context);
    socket.connect(asio::local::stream_protocol::endpoint(options.socket.string()));
    asio::write(socket, asio::buffer(command + "\n"));
    std::string answer;
    asio::read_until(socket, asio::dynamic_buffer(answer, kLongestAnswer), '\n');
    return answer.substr(0, answer.find('\n'));
  } catch (const boost::system::system_error& error) {
    throw Error(fmt::format("{}: no answer of a running robot: {}", options.socket.string(), error.what()));
  }
}

int ctl(const CtlOptions& options) {
  const std::string answer = ask(options);
  if (answer.starts_with("ok")) {
    if (answer.size() > 3) fmt::print("{}\n", visible_text(answer.substr(3)));
    return kSuccess;
  }
  print_message("waymark: {}\n", answer);
  return kError;
}

}  // namespace

void add_ctl_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<CtlOptions>();
  CLI::App* command = app.add_subcommand("ctl", "Send a command to a running robot");
  command->footer(
      "Commands: enable NAME, disable NAME (a sensor or a map), shadow SENSOR (evaluated only), "
      "set sensors.NAME.KEY=VALUE, set maps.NAME.KEY=VALUE, "
      "set-pose X_M Y_M HEADING_DEG [SIGMA_M SIGMA_DEG], save-maps, checkpoint, status, stop.\n"
      "Commands that change the filter are part of the flight record, so that a replay repeats them.\n\n"
      "Example:\n  waymark run robot.yaml --set live.control=/run/waymark.sock\n"
      "  waymark ctl /run/waymark.sock shadow gps");
  command->add_option("socket", options->socket, "the socket: live.control of the YAML")->required();
  command->add_option("command", options->words, "the command and its arguments")->required();
  command->callback([options, &exit_code] { exit_code = ctl(*options); });
}

}  // namespace waymark::command
