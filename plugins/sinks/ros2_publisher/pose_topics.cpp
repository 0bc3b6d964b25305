// SPDX-License-Identifier: Apache-2.0
#include "pose_topics.hpp"

#include <cmath>
#include <utility>

#include "plugins/shared/cdr/message.hpp"

namespace waymark::ros2_publisher {
namespace {

constexpr dds::Quality kPoses{.reliable = true, .latched = false, .depth = 10};
constexpr dds::Quality kTransforms{.reliable = true, .latched = false, .depth = 100};

template <ros::Message M>
std::unique_ptr<dds::Writer> writer_of(const dds::Participant& participant, const std::string& topic,
                                       const dds::Quality& quality = kPoses) {
  return std::make_unique<dds::Writer>(participant, topic, std::string(M::kType), quality,
                                       std::chrono::nanoseconds::zero());
}

template <ros::Message M>
void write(const std::unique_ptr<dds::Writer>& writer, const M& message) {
  writer->write(ros::to_cdr(message));
}

/// Largest σ of three states.
double sigma_of(const Eigen::Matrix<double, 6, 6>& P, int first) {
  return std::sqrt(std::max(P.diagonal().segment<3>(first).maxCoeff(), 0.0));
}

}  // namespace

PoseTopics::PoseTopics(const dds::Participant& participant, const Topics& topics, Frames frames, Duration ahead,
                       std::optional<Datum> datum)
    : frames_(std::move(frames)), ahead_(ahead), datum_(datum) {
  if (topics.has("odometry")) {
    odometry_ = writer_of<ros::nav_msgs::Odometry>(participant, topics.odometry);
    odometry_in_map_ = writer_of<ros::nav_msgs::Odometry>(participant, topics.odometry_in_map);
  }
  if (topics.has("tf")) tf_ = writer_of<ros::tf2_msgs::TFMessage>(participant, "/tf", kTransforms);
  if (topics.has("pose")) pose_ = writer_of<ros::geometry_msgs::PoseWithCovarianceStamped>(participant, topics.pose);
  if (topics.has("fix")) fix_ = writer_of<ros::sensor_msgs::NavSatFix>(participant, topics.fix);
}

void PoseTopics::publish(const Belief& belief, const StateIndices& indices) {
  constexpr int kTwist = 6;
  if (last_ && belief.stamp <= *last_) return;
  last_ = belief.stamp;
  const Eigen::Matrix<double, 6, 6> P_twist = indices.covariance(belief, kTwist);
  smooth_.step(belief.stamp, belief.mean.v_base, belief.mean.w_base, sigma_of(P_twist, 0), sigma_of(P_twist, 3));
  if (tf_) write(tf_, transforms(belief, frames_, smooth_, ahead_));
  if (odometry_) write(odometry_, odometry_in_odom(belief, indices, frames_, smooth_));
  if (odometry_in_map_) write(odometry_in_map_, odometry_in_map(belief, indices, frames_));
  if (pose_) write(pose_, pose_in_map(belief, indices, frames_));
  if (fix_ && datum_) write(fix_, fix(belief, indices, frames_, *datum_));
}

std::uint64_t PoseTopics::left_out() const {
  std::uint64_t sum = 0;
  for (const auto* writer : {&odometry_, &odometry_in_map_, &tf_, &pose_, &fix_}) {
    if (*writer) sum += (*writer)->left_out();
  }
  return sum;
}

}  // namespace waymark::ros2_publisher
