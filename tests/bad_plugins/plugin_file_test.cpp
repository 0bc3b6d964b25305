// SPDX-License-Identifier: Apache-2.0
// What the loader reads in a file, without loading it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <link.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <string>
#include <vector>

#include "temporary_folder.hpp"
#include "waymark/interface/sensor.hpp"
#include "waymark/interface/sink.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

const std::filesystem::path kFolder = WAYMARK_BAD_PLUGIN_DIR;

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream out(file, std::ios::binary);
  out << bytes;
}

// The text of the PluginError that creating this sensor plugin must throw.
std::string refusal(const std::string& name, const std::vector<std::filesystem::path>& folders) {
  try {
    PluginLoader(folders).create<Sensor>(name, Config::parse("sigma_mps: 0.5\n"), Rig({}));
  } catch (const PluginError& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

// What the list says against the only plugin of the folder.
std::string listed_problem(const std::filesystem::path& folder) {
  const auto infos = PluginLoader({folder}).list();
  if (infos.size() == 1) return infos[0].problem;
  ADD_FAILURE() << infos.size() << " plugins";
  return "";
}

TEST(PluginFile, TruncatedAnywhereIsRefused) {
  const std::string whole = bytes_of(kFolder / "waymark_throws_at_1000.so");
  ASSERT_GT(whole.size(), 4096u);
  const test::TemporaryFolder folder;
  for (std::size_t eighth = 0; eighth < 8; ++eighth) {
    for (const std::size_t size : {whole.size() * eighth / 8, whole.size() * (eighth + 1) / 8 - 1}) {
      SCOPED_TRACE(size);
      write_bytes(folder / "waymark_short.so", whole.substr(0, size));
      const std::string expected =
          size < 64 ? "cannot be loaded: file too short" : "cannot be loaded: it is truncated or damaged";
      EXPECT_THAT(listed_problem(folder), HasSubstr(expected));
      EXPECT_THAT(refusal("short", {folder}), HasSubstr("waymark_short.so: " + expected));
    }
  }
}

// Whatever the headers say, listing neither crashes nor throws.
TEST(PluginFile, DamagedHeadersAreOnlyReported) {
  const test::TemporaryFolder folder;
  const auto file = folder / "waymark_throws_at_1000.so";
  std::filesystem::copy(kFolder / "waymark_throws_at_1000.so", file);
  const std::string whole = bytes_of(file);
  ElfW(Ehdr) header{};
  std::memcpy(&header, whole.data(), sizeof header);
  std::vector<std::size_t> offsets(sizeof header + header.e_phnum * sizeof(ElfW(Phdr)));
  std::iota(offsets.begin(), offsets.end(), 0);
  for (std::size_t i = 0; i < header.e_shnum * sizeof(ElfW(Shdr)); ++i) offsets.push_back(header.e_shoff + i);

  const PluginLoader loader({folder});
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  const auto put = [&](std::size_t at, char byte) { stream.seekp(static_cast<std::streamoff>(at)).put(byte).flush(); };
  int refused = 0;
  for (const std::size_t at : offsets) {
    for (const int byte : {0x00, 0x7f, 0xff}) {
      put(at, static_cast<char>(byte));
      const auto infos = loader.list();
      ASSERT_EQ(infos.size(), 1u);
      if (!infos[0].problem.empty()) ++refused;
    }
    put(at, whole[at]);
  }
  EXPECT_GT(refused, 100);
  EXPECT_EQ(listed_problem(folder), "");
}

TEST(PluginFile, DebugContainersAreNotOurs) {
  EXPECT_THAT(refusal("glibcxx_debug", {kFolder}), HasSubstr("waymark_glibcxx_debug.so: built with \""));
  EXPECT_THAT(refusal("glibcxx_debug", {kFolder}),
              EndsWith(std::string("this program with \"") + kBuildKey + "\"; rebuild the plugin"));
}

TEST(PluginFile, NothingOfAPluginRunsUntilItFits) {
  const auto ran = [] { return std::getenv("WAYMARK_STATIC_INITIALIZER") != nullptr; };
  const test::TemporaryFolder folder;
  std::filesystem::copy(kFolder / "waymark_static_initializer.so", folder / "waymark_static_initializer.so");
  std::filesystem::copy(kFolder / "waymark_static_initializer.so", folder / "waymark_other_name.so");
  const PluginLoader loader({folder});
  const Config config = Config::parse("sigma_mps: 0.5\n");

  EXPECT_EQ(loader.list().size(), 2u);
  EXPECT_FALSE(ran()) << "when listed";
  EXPECT_THROW(loader.create<Sink>("static_initializer", config, Rig({})), PluginError);
  EXPECT_FALSE(ran()) << "as another kind";
  EXPECT_THROW(loader.create<Sensor>("other_name", config, Rig({})), PluginError);
  EXPECT_FALSE(ran()) << "under another name";
  EXPECT_NE(loader.create<Sensor>("static_initializer", config, Rig({})), nullptr);
  EXPECT_TRUE(ran()) << "when it fits";
}

TEST(PluginFile, DanglingLinkIsCalledSo) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("nowhere", folder / "waymark_gps.so");
  const std::string link = (folder.path() / "waymark_gps.so").string();
  EXPECT_THAT(refusal("gps", {folder}),
              EndsWith("plugin \"gps\" is not found: " + link + " is a dangling link to \"nowhere\""));
  EXPECT_EQ(listed_problem(folder), link + ": is a dangling link to \"nowhere\"");
}

TEST(PluginFile, DanglingLinkHidesNoPlugin) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("nowhere", folder / "waymark_throws_at_1000.so");
  const PluginLoader loader({folder, kFolder});
  EXPECT_NE(loader.create<Sensor>("throws_at_1000", Config::parse("sigma_mps: 0.5\n"), Rig({})), nullptr);
  for (const PluginInfo& info : loader.list()) {
    if (info.name == "throws_at_1000") {
      EXPECT_EQ(info.problem, "");
    }
  }
}

}  // namespace
}  // namespace waymark
