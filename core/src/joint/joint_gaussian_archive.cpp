// SPDX-License-Identifier: Apache-2.0
#include "estimation/belief_archive.hpp"
#include "joint/joint_gaussian.hpp"
#include "waymark/base/error.hpp"

namespace waymark::joint {

template <class Archive>
void JointGaussian::serialize(Archive& archive) {
  archive.section("joint_gaussian", 2);
  estimation::serialize_belief(archive, belief_, layout_);
  archive.each(nodes_, [](auto& each, Node& node) { each(node.id, node.size, node.used, node.is_near); });
  Eigen::MatrixXd cross;
  Eigen::MatrixXd between;
  Eigen::MatrixXd pending;
  Eigen::VectorXd corrections;
  if constexpr (!Archive::kReads) {
    cross = cross_.topRows(size_);
    between = between_.topLeftCorner(size_, size_);
    pending = pending_.topLeftCorner(size_, pending_columns_);
    corrections = corrections_.head(size_);
  }
  archive(next_id_, relations_, cross, between, pending, corrections);
  if constexpr (Archive::kReads) {
    size_ = 0;
    int distant = 0;
    NodeId next = 0;
    for (Node& node : nodes_) {
      if (node.size < 1 || node.size > 3 || node.id < next || node.id >= next_id_ || node.used > relations_)
        throw DataError("the checkpoint has an invalid node of the joint Gaussian");
      next = node.id + 1;
      int& end = node.is_near ? size_ : distant;
      node.offset = end;
      end += node.size;
    }
    const bool fits = cross.rows() == size_ && cross.cols() == layout_.size() && between.rows() == size_ &&
                      between.cols() == size_ && pending.rows() == size_ && pending.cols() <= kPending &&
                      corrections.size() == size_ && corrections.allFinite() && cross.allFinite() &&
                      between.allFinite() && pending.allFinite();
    if (!fits) throw DataError("the checkpoint has a joint Gaussian of another size");
    cross_ = cross;
    between_ = between;
    corrections_ = corrections;
    pending_.setZero(size_, kPending);
    pending_columns_ = static_cast<int>(pending.cols());
    pending_.leftCols(pending_columns_) = pending;
    reserve(size_ + kFirstStates);
    distant_.serialize(archive, layout_.size(), size_);
    if (distant_.size() != distant)
      throw DataError("the checkpoint has distant nodes that do not fit its list of nodes");
  } else {
    distant_.serialize(archive, layout_.size(), size_);
  }
}
template void JointGaussian::serialize(OutArchive& archive);
template void JointGaussian::serialize(InArchive& archive);

}  // namespace waymark::joint
