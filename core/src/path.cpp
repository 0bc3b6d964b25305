// SPDX-License-Identifier: Apache-2.0
#include "waymark/path.hpp"

namespace waymark {

void Path::save(OutArchive& out) const {
  out.section("path", 1);
  poses_.save(out, [](const StampedPose& pose, OutArchive& to) {
    to.value(pose.stamp.time_since_epoch().count());
    to.value(pose.T_map_base.p);
    to.value(Eigen::Vector4d(pose.T_map_base.q.coeffs()));
  });
}

void Path::load(InArchive& in) {
  in.section("path", 1);
  poses_.load(in, [](StampedPose& pose, InArchive& from) {
    std::int64_t stamp = 0;
    Eigen::Vector4d q;
    from.value(stamp);
    from.value(pose.T_map_base.p);
    from.value(q);
    pose.stamp = Time{Duration{stamp}};
    pose.T_map_base.q = Eigen::Quaterniond(q);
  });
}

}  // namespace waymark
