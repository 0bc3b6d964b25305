// SPDX-License-Identifier: Apache-2.0
#include "particles/grid_mixture.hpp"

#include <gmock/gmock.h>

#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using ::testing::ElementsAre;

constexpr std::uint8_t kUnknown = GridView::kUnknown;

particles::WeightedGrid grid(double weight, double x, double y, int width, std::vector<std::uint8_t> cells) {
  const int height = static_cast<int>(cells.size()) / width;
  return {{Pose::planar(x, y, 0.0), 0.5, width, height, std::move(cells)}, weight};
}

TEST(GridMixture, IsTheShareOfTheWeightThatHasACellOccupied) {
  const auto mixture = particles::mix_grids(
      std::vector{grid(0.75, 1.0, 2.0, 4, {90, 10, 90, kUnknown}), grid(0.25, 1.0, 2.0, 4, {80, 20, 10, kUnknown})});
  ASSERT_TRUE(mixture);
  EXPECT_THAT(mixture->cells, ElementsAre(100, 0, 75, kUnknown));
}

TEST(GridMixture, AParticleWithAnUnknownCellHasNoWeightInIt) {
  const auto mixture = particles::mix_grids(std::vector{
      grid(0.5, 0, 0, 2, {90, kUnknown}), grid(0.25, 0, 0, 2, {kUnknown, 90}), grid(0.25, 0, 0, 2, {90, 10})});
  EXPECT_THAT(mixture->cells, ElementsAre(100, 50));
}

TEST(GridMixture, CoversTheMapsOfAllParticles) {
  const auto mixture =
      particles::mix_grids(std::vector{grid(0.5, 1.0, 2.0, 2, {90, 10}), grid(0.5, 0.5, 1.5, 2, {10, 90, 10, 10})});
  ASSERT_TRUE(mixture);
  EXPECT_EQ(mixture->width, 3);
  EXPECT_EQ(mixture->height, 2);
  EXPECT_TRUE(mixture->T_map_grid.p.isApprox(Eigen::Vector3d(0.5, 1.5, 0.0)));
  EXPECT_THAT(mixture->cells, ElementsAre(0, 100, kUnknown, 0, 50, 0));
}

TEST(GridMixture, AgreementIsTheOnlyWayToNoughtAndHundred) {
  const auto mixture =
      particles::mix_grids(std::vector{grid(0.999, 0, 0, 2, {90, 10}), grid(0.001, 0, 0, 2, {10, 90})});
  EXPECT_THAT(mixture->cells, ElementsAre(99, 1));
  // Weights whose sum is not exact.
  const std::vector<particles::WeightedGrid> agreeing(10, grid(0.1, 0, 0, 1, {90}));
  EXPECT_THAT(particles::mix_grids(agreeing)->cells, ElementsAre(100));
}

TEST(GridMixture, OfNothingIsNothingAndOfTwoLatticesAnError) {
  EXPECT_FALSE(particles::mix_grids({}));
  EXPECT_THROW(particles::mix_grids(std::vector{grid(0.5, 0, 0, 1, {90}), grid(0.5, 0.2, 0, 1, {90})}), Error);
}

}  // namespace
}  // namespace waymark
