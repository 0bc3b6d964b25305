// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "temporary_folder.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/sensor.hpp"
#include "waymark/plugin_inspection.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

const std::filesystem::path kFolder = WAYMARK_BAD_PLUGIN_DIR;

// Asks for a sensor plugin below `sensors: bad:` of a YAML called robot.yaml.
std::shared_ptr<Sensor> create_sensor(std::string_view name,
                                      const std::vector<std::filesystem::path>& folders = {kFolder}) {
  const Config root = Config::parse("sensors:\n  bad:\n    sigma_mps: 0.5\n", "robot.yaml");
  return PluginLoader(folders).create<Sensor>(name, root.child("sensors").child("bad"), Rig({}));
}

// The text of the error E that creating this plugin must throw.
template <class E>
std::string error_of(std::string_view name, const std::vector<std::filesystem::path>& folders = {kFolder}) {
  try {
    create_sensor(name, folders);
  } catch (const E& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

std::string file_of(std::string_view name) { return (kFolder / ("waymark_" + std::string(name) + ".so")).string(); }

TEST(BadPlugins, WrongAbiNamesBothNumbers) {
  EXPECT_THAT(error_of<PluginError>("wrong_abi"),
              EndsWith(file_of("wrong_abi") + ": built for plugin ABI 999, this program has " +
                       std::to_string(kPluginAbi) + "; rebuild the plugin"));
}

// Before ABI 10 a plugin had no record in its file.
TEST(BadPlugins, OlderAbiIsReadFromTheSymbol) {
  const std::string problem =
      ": built for plugin ABI 9, this program has " + std::to_string(kPluginAbi) + "; rebuild the plugin";
  EXPECT_THAT(error_of<PluginError>("old_abi"), EndsWith(file_of("old_abi") + problem));
  EXPECT_THAT(error_of<PluginError>("without_record"),
              EndsWith(file_of("without_record") + ": its descriptor is incomplete; use WAYMARK_PLUGIN(...)"));
}

TEST(BadPlugins, WrongBuildKeyShowsBothKeys) {
  EXPECT_THAT(error_of<PluginError>("wrong_build_key"),
              EndsWith(file_of("wrong_build_key") + ": built with \"cxxabi=1\", this program with \"" + kBuildKey +
                       "\"; rebuild the plugin"));
}

TEST(BadPlugins, WrongAlignmentHintsAtMarch) {
  EXPECT_THAT(
      error_of<PluginError>("wrong_alignment"),
      EndsWith(file_of("wrong_alignment") + ": built with an Eigen alignment of 4096 bytes, this program with " +
               std::to_string(EIGEN_MAX_ALIGN_BYTES) + "; different -march?"));
}

TEST(BadPlugins, WrongKindNamesBothKinds) {
  EXPECT_THAT(error_of<PluginError>("wrong_kind"),
              EndsWith(file_of("wrong_kind") + ": is a plugin of kind \"sink\", but a \"sensor\" is asked for"));
}

TEST(BadPlugins, WrongNameNamesBothNames) {
  EXPECT_THAT(
      error_of<PluginError>("wrong_name"),
      EndsWith(file_of("wrong_name") + ": calls itself \"another_name\", but its file name says \"wrong_name\""));
}

TEST(BadPlugins, IncompleteDescriptorIsRefused) {
  for (const char* name : {"incomplete", "without_create"}) {
    EXPECT_THAT(error_of<PluginError>(name),
                EndsWith(file_of(name) + ": its descriptor is incomplete; use WAYMARK_PLUGIN(...)"));
  }
}

TEST(BadPlugins, DescriptorThatDiffersFromTheRecordIsRefused) {
  EXPECT_THAT(
      error_of<PluginError>("two_names"),
      HasSubstr(file_of("two_names") + ": its symbol \"waymark_plugin\" differs from its section \".waymark_plugin\""));
}

TEST(BadPlugins, PayloadWithANameOfCoreIsRefused) {
  EXPECT_THAT(error_of<PluginError>("registers_payload_of_core"),
              EndsWith(file_of("registers_payload_of_core") +
                       ": waymark/Height@1 is a payload of core; a plugin's own has another vendor"));
}

TEST(BadPlugins, MissingSymbolIsNamed) {
  for (const char* name : {"no_symbol", "without_symbol"}) {
    EXPECT_THAT(error_of<PluginError>(name),
                EndsWith(file_of(name) +
                         ": is a library, but not a waymark plugin: it does not export \"waymark_plugin\" (is the line "
                         "WAYMARK_PLUGIN(...) missing?)"));
  }
}

TEST(BadPlugins, UnresolvedFunctionIsNamed) {
  EXPECT_THAT(
      error_of<PluginError>("unresolved"),
      EndsWith(file_of("unresolved") + ": cannot be loaded: undefined symbol: waymark_function_that_nobody_defines"));
}

TEST(BadPlugins, TextFileIsNoLibrary) {
  EXPECT_THAT(error_of<PluginError>("not_a_library"),
              EndsWith(file_of("not_a_library") + ": cannot be loaded: invalid ELF header"));
}

TEST(BadPlugins, FolderIsNoLibrary) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "waymark_folder.so");
  EXPECT_THAT(error_of<PluginError>("folder", {folder}), EndsWith("waymark_folder.so: is not a file"));
}

TEST(BadPlugins, NotFoundListsTheFoldersAndTheNearestName) {
  EXPECT_THAT(
      error_of<PluginError>("throws_at_100", {"/nonexistent/plugins", kFolder}),
      EndsWith("plugin \"throws_at_100\" is not found: no waymark_throws_at_100.so in /nonexistent/plugins (no such "
               "folder), " +
               kFolder.string() + "; did you mean \"throws_at_1000\"?"));
}

TEST(BadPlugins, NotFoundGivesNoHintWithoutASimilarName) {
  EXPECT_THAT(error_of<PluginError>("xyzzy"), Not(HasSubstr("did you mean")));
}

TEST(BadPlugins, NameMayNotLeaveTheFolder) {
  EXPECT_THAT(error_of<PluginError>("../wrong_abi"),
              EndsWith("plugin \"../wrong_abi\": a plugin's name has only letters, digits, _ and -"));
}

TEST(BadPlugins, ErrorStartsAtThePlaceInTheYaml) {
  EXPECT_THAT(error_of<PluginError>("wrong_abi"), StartsWith("robot.yaml:"));
  EXPECT_THAT(error_of<PluginError>("wrong_abi"), HasSubstr(": sensors.bad: "));
}

TEST(BadPlugins, ErrorOfAConstructorPassesThrough) {
  EXPECT_EQ(error_of<DataError>("throws_error"), "calibration.bin:7: 3 columns, expected 4");
}

TEST(BadPlugins, OtherExceptionOfAConstructorBecomesConfigError) {
  const std::string text = error_of<ConfigError>("throws_runtime_error");
  EXPECT_THAT(text, StartsWith("robot.yaml:"));
  EXPECT_THAT(text, EndsWith("plugin \"throws_runtime_error\" could not be built: the device does not answer"));
}

TEST(BadPlugins, ThrownIntegerBecomesConfigError) {
  EXPECT_THAT(error_of<ConfigError>("throws_int"),
              EndsWith("plugin \"throws_int\" could not be built: it threw something that is not a std::exception"));
}

TEST(BadPlugins, ObjectOutlivesTheLoader) {
  std::shared_ptr<Sensor> sensor = create_sensor("throws_at_1000");  // the loader is gone after this line
  const std::unique_ptr<Sensor> copy = sensor->clone();
  EXPECT_FALSE(sensor->traits().is_motion_source);
  sensor.reset();
  EXPECT_FALSE(copy->traits().is_motion_source);
}

TEST(BadPlugins, ThrowsAt1000WorksUntilThen) {
  const auto sensor = create_sensor("throws_at_1000");
  const StateLayout layout(StateLayout::Motion::planar, {});
  Belief belief;
  belief.mean.v_base.x() = 1.0;
  belief.P.setIdentity(layout.size(), layout.size());
  const Prediction prediction{belief, layout, nullptr, nullptr, false};
  auto twist = std::make_shared<BodyTwist>();
  twist->v_x_mps = 1.5;
  Measurement measurement;
  measurement.payload = twist;
  for (int i = 1; i < 1000; ++i) {
    UpdateList updates;
    ASSERT_NO_THROW(sensor->process(measurement, prediction, updates)) << "measurement " << i;
    ASSERT_EQ(updates.size(), 1u);
    Linearization model;
    updates[0].linearize({belief.mean, nullptr}, model);
    ASSERT_EQ(model.rows(), 1);
    ASSERT_DOUBLE_EQ(model.residual(0), 0.5);
    ASSERT_DOUBLE_EQ(model.R(0, 0), 0.25);
  }
  UpdateList updates;
  EXPECT_THROW(sensor->process(measurement, prediction, updates), std::runtime_error);
}

TEST(PluginList, ReportsWhatIsWrongWithoutThrowing) {
  const auto infos = PluginLoader({kFolder}).list();
  const auto info = [&](std::string_view name) {
    const auto found = std::find_if(infos.begin(), infos.end(), [&](const PluginInfo& i) { return i.name == name; });
    return found == infos.end() ? PluginInfo{} : *found;
  };
  EXPECT_EQ(info("throws_at_1000").problem, "");
  EXPECT_EQ(info("throws_at_1000").kind, "sensor");
  EXPECT_EQ(info("throws_at_1000").version, "1.0.0");
  EXPECT_EQ(info("throws_at_1000").file, file_of("throws_at_1000"));
  EXPECT_THAT(info("wrong_abi").problem, HasSubstr("ABI 999"));
  EXPECT_THAT(info("wrong_name").problem, HasSubstr("calls itself \"another_name\""));
  EXPECT_THAT(info("not_a_library").problem, HasSubstr("cannot be loaded"));
  EXPECT_THAT(info("no_symbol").problem, HasSubstr("does not export \"waymark_plugin\""));
}

TEST(PluginList, IsSortedByNameAndSkipsMissingFolders) {
  const auto infos = PluginLoader({"/nonexistent/plugins", kFolder}).list();
  EXPECT_GE(infos.size(), 13u);
  EXPECT_TRUE(std::is_sorted(infos.begin(), infos.end(), [](const auto& a, const auto& b) { return a.name < b.name; }));
}

std::string problem_of(std::string_view name) { return inspect_plugin(file_of(name)).problem; }

TEST(PluginInspection, ShowsTheWholeDescriptorOfAPluginThatFits) {
  const PluginInspection found = inspect_plugin(file_of("throws_at_1000"));
  EXPECT_EQ(found.problem, "");
  EXPECT_EQ(found.kind, "sensor");
  EXPECT_EQ(found.name, "throws_at_1000");
  EXPECT_EQ(found.version, "1.0.0");
  EXPECT_EQ(found.abi, kPluginAbi);
  EXPECT_EQ(found.build_key, kBuildKey);
  EXPECT_EQ(found.eigen_max_align, EIGEN_MAX_ALIGN_BYTES);
}

// These end the program, or leave a trace, as soon as they are loaded.
TEST(PluginInspection, RunsNothingOfTheLibrary) {
  EXPECT_EQ(problem_of("static_initializer"), "");
  EXPECT_EQ(std::getenv("WAYMARK_STATIC_INITIALIZER"), nullptr);
  EXPECT_EQ(problem_of("exits_at_load"), "");
}

TEST(PluginInspection, SaysWhyThePluginWouldBeRefused) {
  const PluginInspection other_abi = inspect_plugin(file_of("wrong_abi"));
  EXPECT_EQ(other_abi.abi, 999u);
  EXPECT_EQ(other_abi.name, "") << "the rest may have another layout";
  EXPECT_THAT(other_abi.problem, HasSubstr("built for plugin ABI 999"));
  EXPECT_THAT(problem_of("old_abi"), HasSubstr("built for plugin ABI 9,"));
  EXPECT_THAT(problem_of("without_record"), HasSubstr("its descriptor is incomplete"));
  EXPECT_THAT(problem_of("incomplete"), HasSubstr("its descriptor is incomplete"));
  EXPECT_THAT(problem_of("wrong_build_key"), HasSubstr("built with \"cxxabi=1\""));
  EXPECT_THAT(problem_of("wrong_alignment"), HasSubstr("an Eigen alignment of 4096 bytes"));
  EXPECT_THAT(problem_of("wrong_name"), HasSubstr("calls itself \"another_name\""));
  EXPECT_THAT(problem_of("without_symbol"), HasSubstr("does not export \"waymark_plugin\""));
  EXPECT_EQ(inspect_plugin(file_of("wrong_kind")).kind, "sink") << "which is a kind, if not the one that was asked for";
}

TEST(PluginInspection, RefusesWhatIsNoPlugin) {
  for (const char* name : {"no_symbol", "not_a_library", "that_is_not_there"}) {
    EXPECT_THROW(problem_of(name), PluginError) << name;
  }
}

TEST(PluginInspection, NamesAFileThatNoSearchFinds) {
  const test::TemporaryFolder folder;
  std::filesystem::copy(file_of("throws_at_1000"), folder / "renamed.so");
  EXPECT_THAT(inspect_plugin(folder / "renamed.so").problem, HasSubstr("not called waymark_throws_at_1000.so"));
}

TEST(SearchPath, YamlBeforeEnvironmentBeforeInstallation) {
  ::setenv("WAYMARK_PLUGIN_PATH", "/env/one::/env/two", 1);
  const auto folders = PluginLoader::standard_search_path({"/yaml"});
  ::unsetenv("WAYMARK_PLUGIN_PATH");
  const auto program = std::filesystem::read_symlink("/proc/self/exe");
  EXPECT_THAT(folders, ::testing::ElementsAre("/yaml", "/env/one", "/env/two",
                                              program.parent_path().parent_path() / "lib/waymark/plugins"));
}

}  // namespace
}  // namespace waymark
