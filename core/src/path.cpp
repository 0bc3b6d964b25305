// SPDX-License-Identifier: Apache-2.0
#include "waymark/path.hpp"

namespace waymark {

void Path::save(OutArchive& out) const {
  out.section("path", 1);
  poses_.save(out, [](const StampedPose& pose, OutArchive& to) {
    to.value(pose.stamp);
    to.value(pose.T_map_base.p);
    to.value(Eigen::Vector4d(pose.T_map_base.q.coeffs()));
  });
}

void Path::load(InArchive& in) {
  in.section("path", 1);
  poses_.load(in, [](StampedPose& pose, InArchive& from) {
    Eigen::Vector4d q;
    from.value(pose.stamp);
    from.value(pose.T_map_base.p);
    from.value(q);
    pose.T_map_base.q = Eigen::Quaterniond(q);
  });
}

}  // namespace waymark
