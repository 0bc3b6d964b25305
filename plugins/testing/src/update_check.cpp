// SPDX-License-Identifier: Apache-2.0
#include "update_check.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>

#include "several_threads.hpp"

namespace waymark::testing {

namespace {

constexpr std::array<const char*, kCoreStates> kCoreNames = {"x",   "y",   "z",   "roll", "pitch", "yaw",
                                                             "v_x", "v_y", "v_z", "w_x",  "w_y",   "w_z"};

std::string state_name(int state, const StateLayout& layout) {
  for (int core = 0; core < kCoreStates; ++core) {
    if (layout.active(core) == state) return kCoreNames[static_cast<std::size_t>(core)];
  }
  return layout.block_state(state - layout.core_size()).name;
}

/// How far a block's state is expected from its initial value.
double spread(const BlockState& state) { return std::max({state.initial_sigma, state.stationary_sigma, 1e-3}); }

double step_of(int state, const StateLayout& layout) {
  if (state < layout.core_size()) return 1e-3;
  return std::clamp(0.1 * spread(layout.block_state(state - layout.core_size())), 1e-4, 1e-2);
}

template <class M>
void append_bytes(std::string& out, const M& m) {
  out.append(reinterpret_cast<const char*>(m.data()), sizeof(double) * static_cast<std::size_t>(m.size()));
  out += fmt::format("|{}x{}|", m.rows(), m.cols());
}

/// a − b, where a jump of a whole turn can only be an angle that wraps.
Eigen::VectorXd difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  Eigen::VectorXd d = a - b;
  for (double& value : d) {
    if (std::abs(value) > std::numbers::pi) value = so3::wrap(value);
  }
  return d;
}

/// ∂h/∂state by the five-point rule (residual = z ⊟ h, so the sign turns); empty if a shape changes on the way.
Eigen::VectorXd numerical_column(const Update& update, const NavState& state, int column, const StateLayout& layout) {
  const double step = step_of(column, layout);
  Linearization out;
  const auto residual_at = [&](double steps) {
    NavState moved = state;
    ErrorVector delta = ErrorVector::Zero(layout.size());
    delta[column] = steps * step;
    boxplus(moved, delta, layout);
    return evaluate(update, moved, layout, out).residual;
  };
  const auto center = residual_at(0.0);
  std::array<Eigen::VectorXd, 4> moved = {residual_at(-2.0), residual_at(-1.0), residual_at(1.0), residual_at(2.0)};
  for (Eigen::VectorXd& residual : moved) {
    if (residual.size() != center.size()) return {};
    residual = difference(residual, center);
  }
  return -(8.0 * (moved[2] - moved[1]) - (moved[3] - moved[0])) / (12.0 * step);
}

void check_jacobian(const Update& update, const DenseModel& model, const NavState& state, const StateLayout& layout,
                    std::string_view name, Findings& findings) {
  Eigen::MatrixXd numerical(model.H.rows(), model.H.cols());
  for (int column = 0; column < layout.size(); ++column) {
    const Eigen::VectorXd values = numerical_column(update, state, column, layout);
    if (values.size() != numerical.rows()) {
      findings.add("linearize gives another number of rows at a neighbouring state", name);
      return;
    }
    numerical.col(column) = values;
  }
  // What subtracting two residuals loses to rounding, on the way through the position as well.
  const double rounding =
      16.0 * std::numeric_limits<double>::epsilon() *
      (model.residual.cwiseAbs().maxCoeff() + state.T_map_base.p.norm() + state.v_base.norm() + 1e-6);
  for (Eigen::Index row = 0; row < numerical.rows(); ++row) {
    const double scale = std::max(numerical.row(row).cwiseAbs().maxCoeff(), model.H.row(row).cwiseAbs().maxCoeff());
    for (int column = 0; column < layout.size(); ++column) {
      const double bound = 1e-6 * scale + rounding / step_of(column, layout);
      if (std::abs(numerical(row, column) - model.H(row, column)) <= bound) continue;
      findings.add("a Jacobian differs from central differences",
                   fmt::format("{}, row {}, state {}: {:.9g} instead of {:.9g}", name, row, state_name(column, layout),
                               model.H(row, column), numerical(row, column)));
    }
  }
}

void check_values(const DenseModel& model, std::string_view name, Findings& findings) {
  findings.require(model.residual.allFinite(), "a residual is not finite", name);
  findings.require(model.H.allFinite(), "a Jacobian is not finite", name);
  if (!model.R.allFinite()) {
    findings.add("R is not finite", name);
    return;
  }
  const double scale = model.R.cwiseAbs().maxCoeff();
  findings.require((model.R - model.R.transpose()).cwiseAbs().maxCoeff() <= 1e-12 * scale, "R is not symmetric", name);
  const Eigen::LLT<Eigen::MatrixXd> factor(model.R);
  findings.require(factor.info() == Eigen::Success && factor.matrixLLT().diagonal().minCoeff() > 0.0,
                   "R is not positive definite", name);
}

}  // namespace

std::string DenseModel::bytes() const {
  std::string out = problem;
  append_bytes(out, residual);
  append_bytes(out, R);
  append_bytes(out, H);
  return out;
}

DenseModel evaluate(const Update& update, const NavState& state, const StateLayout& layout, Linearization& out) {
  update.linearize({state, state.block.data()}, out);
  DenseModel model;
  const int rows = out.rows();
  if (rows < 1 || rows > kMaxUpdateRows) {
    model.problem = fmt::format("{} rows, 1..{} are expected; was out.reset called?", rows, kMaxUpdateRows);
    return model;
  }
  if (out.R.rows() != rows || out.R.cols() != rows) {
    model.problem = fmt::format("R is {} x {} in an update of {} rows", out.R.rows(), out.R.cols(), rows);
    return model;
  }
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(rows, layout.size());
  for (int part = 0; part < 4; ++part) {
    const auto p = static_cast<Linearization::Part>(part);
    if (!out.uses(p)) continue;
    if (out.get(p).rows() != rows) {
      model.problem = fmt::format("a Jacobian has {} rows in an update of {}", out.get(p).rows(), rows);
      return model;
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (const int active = layout.active(3 * part + axis); active >= 0) H.col(active) = out.get(p).col(axis);
    }
  }
  if (out.uses_block()) {
    if (out.get_block().rows() != rows || out.get_block().cols() != layout.block_size()) {
      model.problem = fmt::format("the block's Jacobian is {} x {}, {} x {} is expected", out.get_block().rows(),
                                  out.get_block().cols(), rows, layout.block_size());
      return model;
    }
    H.rightCols(layout.block_size()) = out.get_block();
  }
  model.residual = out.residual;
  model.R = out.R;
  model.H = std::move(H);
  return model;
}

NavState random_state(Random& random, const SensorSetting& setting, const StateLayout& layout) {
  NavState state = setting.center;
  const bool planar = layout.motion() == StateLayout::Motion::planar;
  const auto normal3 = [&](double sigma) {
    return Eigen::Vector3d{sigma * random.normal(), sigma * random.normal(), sigma * random.normal()};  // in this order
  };
  Eigen::Vector3d p = normal3(10.0);
  Eigen::Vector3d tilt = normal3(0.3);
  Eigen::Vector3d v = normal3(2.0);
  Eigen::Vector3d w = normal3(1.0);
  const double yaw = 2.0 * std::numbers::pi * random.uniform();
  if (planar) {
    p.z() = v.z() = 0.0;
    tilt.setZero();
    w.head<2>().setZero();
  }
  state.T_map_base.p += p;
  state.T_map_base.q = (so3::exp({0.0, 0.0, yaw}) * so3::exp(tilt) * state.T_map_base.q).normalized();
  state.v_base += v;
  state.w_base += w;
  state.block.resize(layout.block_size());
  for (int i = 0; i < layout.block_size(); ++i) {
    state.block[i] = layout.block_state(i).initial + spread(layout.block_state(i)) * random.normal();
  }
  return state;
}

void check_update(const Update& update, const std::vector<NavState>& states, const StateLayout& layout,
                  std::string_view name, Findings& findings) {
  std::vector<std::string> expected;
  Linearization used;  // goes dirty from state to state, as the host's does
  for (const NavState& state : states) {
    Linearization fresh;
    const DenseModel model = evaluate(update, state, layout, fresh);
    if (!model.problem.empty()) {
      findings.add("linearize fills in a wrong shape", std::string(name) + ": " + model.problem);
      return;
    }
    expected.push_back(model.bytes());
    findings.require(evaluate(update, state, layout, used).bytes() == expected.back(),
                     "linearize depends on what `out` held before or on earlier calls", name);
    check_values(model, name, findings);
    check_jacobian(update, model, state, layout, name, findings);
  }
  std::atomic<bool> same = true;
  on_several_threads(4 * static_cast<int>(states.size()), [&](int i) {
    const std::size_t k = static_cast<std::size_t>(i) % states.size();
    try {
      Linearization out;
      if (evaluate(update, states[k], layout, out).bytes() != expected[k]) same = false;
    } catch (...) {
      same = false;
    }
  });
  findings.require(same, "linearize gives something else when several threads call it", name);
}

}  // namespace waymark::testing
