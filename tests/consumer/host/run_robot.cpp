// SPDX-License-Identifier: Apache-2.0
// run_robot ROBOT.yaml OUT: runs a robot on its log, as `waymark run` does, and prints where it ended.
#include <cstdio>

#include "waymark/base/error.hpp"
#include "waymark/host/session.hpp"

using namespace waymark;

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    std::filesystem::create_directories(argv[2]);
    host::Session session(host::Robot::load(argv[1]), {.out = argv[2]});
    session.play();
    const host::SessionResult result = session.finish();
    for (const std::string& failure : result.failures) std::fprintf(stderr, "%s\n", failure.c_str());
    session.fusion().visit_last([](const Snapshot& last) {
      const Eigen::Vector3d& p = last.belief().mean.T_map_base.p;
      std::printf("ended at x %.2f y %.2f m\n", p.x(), p.y());
    });
    return result.failures.empty() ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
