// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <filesystem>

/// The main program of the tests. They name files by paths relative to the build folder, so that the compiler cache
/// finds their objects in another checkout too; only this file knows where the build folder is.
int main(int argc, char** argv) {
  ::testing::InitGoogleMock(&argc, argv);
  std::filesystem::current_path(WAYMARK_BUILD_DIR);
  return RUN_ALL_TESTS();
}
