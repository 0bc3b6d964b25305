// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/map_manifest.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <numbers>
#include <string>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::map_formats {
namespace {

using testing::HasSubstr;

class MapManifestFile : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& content) const {
    const std::filesystem::path file = folder_ / "maps.yaml";
    std::ofstream(file, std::ios::binary) << content;
    return file;
  }
  std::string error(const std::string& content) const {
    try {
      read_manifest(write(content));
    } catch (const ConfigError& error) {
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }

  test::TemporaryFolder folder_;
};

TEST_F(MapManifestFile, ReadsWhatWasWritten) {
  const std::filesystem::path folder = write("").parent_path();
  MapManifest written{folder / "maps.yaml", Datum{48.1, 11.5, 520.25}, {}};
  Pose turned = Pose::planar(4.9, -0.1, 1.0);
  turned.p.z() = 0.5;
  written.layers = {{"poles", "landmarks", folder / "poles.landmarks.yaml", {}},
                    {"it's a yard: #1", "octree", folder / "it_s.ot", turned}};
  const MapManifest read = read_manifest(write(manifest_text(written, folder)));
  ASSERT_TRUE(read.datum);
  EXPECT_EQ(read.datum->latitude_deg, 48.1);
  EXPECT_EQ(read.datum->longitude_deg, 11.5);
  EXPECT_EQ(read.datum->height_m, 520.25);
  ASSERT_EQ(read.layers.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.layers[i].name, written.layers[i].name);
    EXPECT_EQ(read.layers[i].format, written.layers[i].format);
    EXPECT_EQ(read.layers[i].file, written.layers[i].file);
    EXPECT_TRUE(read.layers[i].T_frame_file.p.isApprox(written.layers[i].T_frame_file.p, 1e-12));
    EXPECT_NEAR(read.layers[i].T_frame_file.yaw(), written.layers[i].T_frame_file.yaw(), 1e-12);
  }
  EXPECT_EQ(read.find("poles"), &read.layers.front());
  EXPECT_EQ(read.find("hall"), nullptr);
}

// An angle that went through radians and a quaternion differs in its last digits.
TEST_F(MapManifestFile, IsWrittenAgainAsItWasRead) {
  const std::filesystem::path folder = write("").parent_path();
  for (int i = 1; i < 200; ++i) {
    MapManifest manifest{folder / "maps.yaml", {}, {}};
    manifest.layers = {{"hall", "octree", folder / "hall.ot", Pose::planar(0.37 * i, -0.11 * i, 0.0152 * i)}};
    const std::string text = manifest_text(manifest, folder);
    EXPECT_EQ(manifest_text(read_manifest(write(text)), folder), text);
  }
}

TEST_F(MapManifestFile, IsKnownByItsLayersNotByItsName) {
  EXPECT_TRUE(is_manifest(write("layers: []\n")));
  EXPECT_FALSE(is_manifest(write("image: room.pgm\nresolution: 0.1\n")));
  EXPECT_FALSE(is_manifest(write("[")));
  EXPECT_FALSE(is_manifest(folder_ / "absent.yaml"));
}

TEST_F(MapManifestFile, NamesFileLineAndExpectationOfWhatIsWrong) {
  const std::string layers = "layers: [{ name: a, format: octree, file: a.ot }]\n";
  EXPECT_THAT(error("version: 2\n" + layers), HasSubstr("maps.yaml:1:10: version: 2 is not 1"));
  EXPECT_THAT(error("version: 1\nlayers: []\n"), HasSubstr("at least one layer is expected"));
  EXPECT_THAT(error("version: 1\ndatum: { latitude_deg: 91, longitude_deg: 0 }\n" + layers), HasSubstr("latitude_deg"));
  EXPECT_THAT(error("version: 1\nlayer: 1\n" + layers), HasSubstr("unknown key"));
  EXPECT_THAT(error("version: 1\nlayers: [{ name: '', format: octree, file: a.ot }]\n"), HasSubstr("name: is empty"));
  EXPECT_THAT(error("version: 1\nlayers: [{ name: a, format: octree, file: '' }]\n"), HasSubstr("file: is empty"));
  EXPECT_THAT(error("version: 1\nlayers: [{ name: a, format: octree, file: a.ot, pose: { x_m: 1e9 } }]\n"),
              HasSubstr("pose.x_m"));
  EXPECT_THAT(error("version: 1\nlayers:\n  - { name: a, format: octree, file: a.ot }\n"
                    "  - { name: a, format: octree, file: b.ot }\n"),
              HasSubstr("\"a\" is the name of two layers"));
  std::string many = "version: 1\nlayers:\n";
  for (int i = 0; i < 1001; ++i) many += "  - { name: l" + std::to_string(i) + ", format: octree, file: a.ot }\n";
  EXPECT_THAT(error(many), HasSubstr("1001 layers; at most 1000"));
}

}  // namespace
}  // namespace waymark::map_formats
