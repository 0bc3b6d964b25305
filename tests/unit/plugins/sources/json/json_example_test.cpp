// SPDX-License-Identifier: Apache-2.0
// The README's example in Python feeds the source.
#include <sys/wait.h>

#include <fstream>
#include <sstream>

#include "json_fixture.hpp"
#include "live_source.hpp"

namespace waymark::json_test {
namespace {

std::string example(const std::string& page) {
  const std::string start = "```python\n";
  const std::size_t begin = page.find(start);
  if (begin == std::string::npos) return "";
  return page.substr(begin + start.size(), page.find("```", begin + start.size()) - begin - start.size());
}

TEST_F(Json, TenLinesOfPythonFeedTheWheels) {
  std::ifstream file(WAYMARK_SOURCE_DIR "/plugins/sources/json/README.md");
  std::stringstream page;
  page << file.rdbuf();
  std::string program = example(page.str());
  EXPECT_LE(std::count(program.begin(), program.end(), '\n'), 10);
  const std::string port = std::to_string(test::free_port(SOCK_DGRAM));
  ASSERT_NE(program.find("5005"), std::string::npos);
  program.replace(program.find("5005"), 4, port);
  std::ofstream(folder_ / "feed.py") << program;

  test::LiveReader reader(make("from: udp\nport: " + port));
  const std::string script = folder_ / "feed.py";
  const pid_t child = ::fork();
  if (child == 0) {
    ::execlp("python3", "python3", script.c_str(), nullptr);
    ::_exit(127);
  }
  EXPECT_TRUE(reader.wait_for(5));
  ::kill(child, SIGTERM);
  int status = 0;
  ::waitpid(child, &status, 0);
  reader.stop();
  ASSERT_GE(reader.measurements().size(), 5U);
  const auto all = reader.measurements();
  EXPECT_EQ(all[4].as<WheelSpeeds>().left_mps, 1.0);
  EXPECT_NEAR(to_seconds(all[4].stamp - all[3].stamp), 0.02, 0.5);
  EXPECT_TRUE(reader.source().bad_records().empty());
}

}  // namespace
}  // namespace waymark::json_test
