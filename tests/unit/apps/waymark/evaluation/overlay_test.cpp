// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/overlay.hpp"

#include <gmock/gmock.h>

namespace waymark::evaluation {
namespace {

using testing::HasSubstr;

TEST(Overlay, DrawsEachPathAndNamesIt) {
  const std::string svg = overlay_svg({{"reference", {{0, 0}, {10, 0}}}, {"out/a <b>", {{0, 1}, {10, 1}}}});
  EXPECT_THAT(svg, HasSubstr("stroke=\"black\""));
  EXPECT_THAT(svg, HasSubstr(">out/a &lt;b&gt;</text>"));
  EXPECT_THAT(svg, testing::EndsWith("</svg>\n"));
}

TEST(Overlay, HasOneScaleAndNorthUp) {
  // 10 m are 900 px; around the paths there are 5 % of that, and a margin of 60 px.
  const std::string svg = overlay_svg({{"a", {{0, 0}, {10, 5}}}});
  EXPECT_THAT(svg, HasSubstr("points=\"105.0,555.0 1005.0,105.0 \""));
}

TEST(Overlay, OfNothingIsAPicture) { EXPECT_THAT(overlay_svg({}), HasSubstr("</svg>")); }

}  // namespace
}  // namespace waymark::evaluation
