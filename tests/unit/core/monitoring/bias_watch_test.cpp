// SPDX-License-Identifier: Apache-2.0
#include "monitoring/bias_watch.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "waymark/math/random.hpp"

namespace waymark {
namespace {

/// A skewed covariance, its factor, and innovations that scatter like it.
struct Innovations {
  gaussian::Matrix S = (gaussian::Matrix(2, 2) << 0.5, 0.2, 0.2, 0.3).finished();
  Random random{{.seed = 11, .slot = 0, .stamp = 1, .sensor = 1}};

  gaussian::Vector next(const Eigen::Vector2d& bias) {
    const gaussian::Vector white = Eigen::Vector2d(random.normal(), random.normal());
    gaussian::Vector nu = bias;
    nu += S.llt().matrixL() * white;
    return nu;
  }
};

TEST(BiasWatch, SeesNothingInWhiteInnovations) {
  Innovations innovations;
  monitoring::BiasWatch watch;
  int alarms = 0;
  for (int k = 0; k < 100'000; ++k) alarms += watch.add(innovations.next({0.0, 0.0}), innovations.S);
  // Neighbouring means share most of their innovations, so one chance shows several times.
  EXPECT_LE(alarms, 5);
}

TEST(BiasWatch, SeesASmallBiasOfManyInnovations) {
  Innovations innovations;
  monitoring::BiasWatch watch;
  const Eigen::Vector2d bias(0.8, 0.0);  // 1.1 σ: no gate would reject it
  int needed = 0;
  while (!watch.add(innovations.next(bias), innovations.S) && needed < 1000) ++needed;
  EXPECT_LT(needed, 60);
  // A lucky draw ends the search; the mean of a full window is 0.14 m off per axis.
  for (int k = 0; k < 100; ++k) watch.add(innovations.next(bias), innovations.S);
  EXPECT_LT((watch.mean().head<2>() - bias).norm(), 0.5);
  EXPECT_EQ(watch.mean().z(), 0.0);
}

TEST(BiasWatch, NeedsSeveralInnovationsHoweverLarge) {
  Innovations innovations;
  monitoring::BiasWatch watch;
  const gaussian::Vector far = Eigen::Vector2d(50.0, 0.0);
  for (int k = 0; k < 4; ++k) EXPECT_FALSE(watch.add(far, innovations.S));
  EXPECT_TRUE(watch.add(far, innovations.S));
  watch.reset();
  EXPECT_FALSE(watch.add(far, innovations.S));
}

TEST(BiasWatch, ContinuesAfterItWasLoaded) {
  Innovations innovations;
  monitoring::BiasWatch one;
  for (int k = 0; k < 7; ++k) one.add(innovations.next({0.5, 0.1}), innovations.S);
  std::stringstream stream;
  OutArchive out(stream);
  out(one);
  monitoring::BiasWatch other;
  InArchive in(stream);
  in(other);
  for (int k = 0; k < 30; ++k) {
    const gaussian::Vector nu = innovations.next({0.5, 0.1});
    EXPECT_EQ(one.add(nu, innovations.S), other.add(nu, innovations.S));
    EXPECT_EQ(one.mean(), other.mean());
  }
}

}  // namespace
}  // namespace waymark
