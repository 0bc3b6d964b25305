// SPDX-License-Identifier: Apache-2.0
// needs plugins: altimeter, carmen, compass, csv, dgps, diagnostics, feature_map, held_out, imu, kitti, landmarks, log
// needs plugins: clouds, nmea, occupancy_grid, octomap_grid, odometry, plot, rosbag1, simulator, tum
// Every wrong input of tests/hostile/catalogue.txt ends in one line that names file or key, and leaves no result.
#include <gtest/gtest.h>

#include <charconv>
#include <map>

#include "tests/system/small_robot.hpp"

namespace waymark::system_test {
namespace {

/// One row of the catalogue.
struct Wrong {
  std::string what;
  std::string change;
  int exit_code = 0;
  std::vector<std::string> parts;  ///< of the line of error
};

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(' ') + 1 - first);
}

std::vector<std::string> split(const std::string& text, const std::string& mark) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, from)) {
    parts.push_back(text.substr(from, at - from));
    from = at + mark.size();
  }
  parts.push_back(text.substr(from));
  return parts;
}

std::string with_escapes(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view rest = std::string_view(text).substr(i);
    if (rest.starts_with("\\n") || rest.starts_with("\\t")) {
      result += rest[1] == 'n' ? '\n' : '\t';
      ++i;
    } else if (rest.starts_with("\\x") && rest.size() >= 4) {
      int byte = 0;
      std::from_chars(rest.data() + 2, rest.data() + 4, byte, 16);
      result += static_cast<char>(byte);
      i += 3;
    } else {
      result += text[i];
    }
  }
  return result;
}

std::vector<Wrong> catalogue() {
  std::vector<Wrong> rows;
  for (const std::string& line : lines_of(read_text(WAYMARK_SOURCE_DIR "/tests/hostile/catalogue.txt"))) {
    if (line.empty() || line.starts_with('#')) continue;
    const std::vector<std::string> fields = split(line, " |");
    if (fields.size() < 3) throw std::runtime_error("the catalogue has a row of too few fields: " + line);
    // The change keeps its blanks: it may be a line of YAML.
    Wrong row{trimmed(fields[0]), fields[1].substr(1), std::stoi(fields[2]), {}};
    if (fields.size() > 3) {
      for (const std::string& part : split(fields[3], ";;")) {
        if (!trimmed(part).empty()) row.parts.push_back(trimmed(part));
      }
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

/// A robot with one thing wrong, and what its command line has besides.
class WrongRobot {
 public:
  explicit WrongRobot(const std::string& changes) {
    for (const std::string& change : split(changes, " && ")) apply(change);
    robot_.write();
    for (const auto& [name, text] : files_) {
      std::filesystem::create_directories(robot_.file(name).parent_path());
      write_text(robot_.file(name), text);
    }
  }

  Outcome run() const {
    Command command = command_.empty() ? robot_.command(arguments_) : Command(command_);
    return command.in_child(enter_).run();
  }
  const SmallRobot& robot() const { return robot_; }

 private:
  void apply(const std::string& change) {
    const std::size_t blank = change.find(' ');
    const std::string verb = change.substr(0, blank);
    const std::string rest = blank == std::string::npos ? "" : change.substr(blank + 1);
    if (verb == "set") {
      arguments_.insert(arguments_.end(), {"--set", rest});
    } else if (verb == "args") {
      const std::vector<std::string> more = split(rest, " ");
      arguments_.insert(arguments_.end(), more.begin(), more.end());
    } else if (verb == "command") {
      command_ = split(with_escapes(rest), " ");
    } else if (verb == "write") {
      const std::size_t end = rest.find(' ');
      files_[rest.substr(0, end)] = with_escapes(rest.substr(end + 1));
    } else if (verb == "yaml") {
      robot_.yaml = with_escapes(rest);
    } else if (verb == "replace") {
      const std::vector<std::string> sides = split(rest, " =>");
      const std::string instead = sides.at(1).starts_with(' ') ? sides[1].substr(1) : sides[1];
      robot_.replace(with_escapes(sides[0]), with_escapes(instead));
    } else {
      change_file(verb, rest);
    }
  }

  void change_file(const std::string& name, const std::string& rest) {
    std::vector<std::string>* lines = name == "twist.csv"   ? &robot_.twist
                                      : name == "fixes.csv" ? &robot_.fixes
                                      : name == "scans.csv" ? &robot_.scans
                                                            : nullptr;
    if (lines == nullptr) throw std::runtime_error("the catalogue has an unknown change: " + name);
    const std::size_t blank = rest.find(' ');
    const bool is_line = blank != std::string::npos && rest.find_first_not_of("0123456789") == blank;
    if (is_line) {
      lines->at(std::stoul(rest) - 1) = rest.substr(blank + 1);
    } else {
      files_[name] = with_escapes(rest);
    }
  }

  SmallRobot robot_;
  std::vector<std::string> arguments_;
  std::vector<std::string> command_;          // instead of a run of the robot
  std::map<std::string, std::string> files_;  // written after the robot's own
  // Files on the command line lie beside the robot.
  std::function<void()> enter_ = [folder = robot_.out().parent_path().string()] {
    if (::chdir(folder.c_str()) != 0) ::_exit(126);
  };
};

class Hostile : public testing::TestWithParam<int> {};

// Side by side in a few tests: each starts the program some hundred times.
constexpr int kTests = 4;

TEST_P(Hostile, InputEndsInOneLineThatNamesIt) {
  const std::vector<Wrong> rows = catalogue();
  ASSERT_GE(rows.size(), 198U);
  for (std::size_t i = static_cast<std::size_t>(GetParam()); i < rows.size(); i += kTests) {
    SCOPED_TRACE(rows[i].what + ": " + rows[i].change);
    const WrongRobot wrong(rows[i].change);
    const Outcome outcome = wrong.run();
    if (rows[i].exit_code == 0) {
      EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
      continue;
    }
    EXPECT_TRUE(reports_error(outcome, rows[i].exit_code, rows[i].parts));
    EXPECT_FALSE(std::filesystem::exists(wrong.robot().out() / "config.yaml.new"));
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, Hostile, testing::Range(0, kTests));

}  // namespace
}  // namespace waymark::system_test
