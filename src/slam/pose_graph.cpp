#include "yarm/slam/pose_graph.hpp"

#include <Eigen/SparseCholesky>

namespace yarm::slam {

namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplet = Eigen::Triplet<double>;

struct Linearised {
  Eigen::Vector3d error;
  Eigen::Matrix3d by_from;  // derivative by (x, y, yaw) of the pose `from`
  Eigen::Matrix3d by_to;
};

Eigen::Matrix2d rotation(double yaw) {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

Eigen::Vector3d errorOf(const PoseEdge& edge, const Pose2& from, const Pose2& to) {
  const Pose2 difference = edge.T_from_to.inverse() * (from.inverse() * to);
  return {difference.x, difference.y, difference.yaw};
}

Linearised linearise(const PoseEdge& edge, const Pose2& from, const Pose2& to) {
  Linearised result;
  result.error = errorOf(edge, from, to);
  const Eigen::Matrix2d back = rotation(from.yaw + edge.T_from_to.yaw).transpose();
  const Eigen::Vector2d way{to.x - from.x, to.y - from.y};
  result.by_to.setIdentity();
  result.by_to.topLeftCorner<2, 2>() = back;
  result.by_from = -result.by_to;
  result.by_from.topRightCorner<2, 1>() = back * Eigen::Vector2d{way.y(), -way.x()};
  return result;
}

// Cauchy's cost of a squared error, and its derivative: the weight of the edge.
double cost(double squared, double scale) {
  return scale * scale * std::log1p(squared / (scale * scale));
}
double weight(double squared, double scale) {
  return 1.0 / (1.0 + squared / (scale * scale));
}

double totalCost(const std::vector<Pose2>& poses, const std::vector<PoseEdge>& edges, double scale) {
  double sum = 0.0;
  for (const PoseEdge& edge : edges) {
    sum += cost(squaredErrorOf(edge, poses[edge.from], poses[edge.to]), scale);
  }
  return sum;
}

// The normal equations over all poses but the first; only the lower triangle of the matrix.
class System {
 public:
  explicit System(std::size_t poses)
      : size_(3 * (static_cast<Eigen::Index>(poses) - 1)), gradient_(Eigen::VectorXd::Zero(size_)) {}

  void add(const PoseEdge& edge, const Linearised& at, double weight) {
    const Eigen::Matrix3d information = weight * edge.information;
    addBlock(edge.from, edge.from, at.by_from.transpose() * information * at.by_from);
    addBlock(edge.to, edge.to, at.by_to.transpose() * information * at.by_to);
    if (edge.from > edge.to) {
      addBlock(edge.from, edge.to, at.by_from.transpose() * information * at.by_to);
    } else {
      addBlock(edge.to, edge.from, at.by_to.transpose() * information * at.by_from);
    }
    addGradient(edge.from, at.by_from.transpose() * information * at.error);
    addGradient(edge.to, at.by_to.transpose() * information * at.error);
  }

  [[nodiscard]] Sparse matrix() const {
    Sparse result(size_, size_);
    result.setFromTriplets(triplets_.begin(), triplets_.end());
    return result;
  }
  [[nodiscard]] const Eigen::VectorXd& gradient() const { return gradient_; }

 private:
  void addBlock(int row, int column, const Eigen::Matrix3d& block) {
    if (row == 0 || column == 0) {
      return;
    }
    const int first_row = 3 * (row - 1);
    const int first_column = 3 * (column - 1);
    for (int c = 0; c < 3; ++c) {
      for (int r = row == column ? c : 0; r < 3; ++r) {
        triplets_.emplace_back(first_row + r, first_column + c, block(r, c));
      }
    }
  }
  void addGradient(int pose, const Eigen::Vector3d& part) {
    if (pose > 0) {
      gradient_.segment<3>(3 * (pose - 1)) += part;
    }
  }

  Eigen::Index size_;
  std::vector<Triplet> triplets_;
  Eigen::VectorXd gradient_;
};

std::string faultOf(const std::vector<Pose2>& poses, const std::vector<PoseEdge>& edges) {
  const int count = static_cast<int>(poses.size());
  for (const Pose2& pose : poses) {
    if (!pose.isFinite()) {
      return "a pose is not finite";
    }
  }
  for (const PoseEdge& edge : edges) {
    if (edge.from < 0 || edge.to < 0 || edge.from >= count || edge.to >= count || edge.from == edge.to) {
      return "an edge ties pose " + std::to_string(edge.from) + " to " + std::to_string(edge.to) + ", of " +
             std::to_string(count);
    }
    if (!edge.T_from_to.isFinite() || !edge.information.allFinite()) {
      return "the edge from pose " + std::to_string(edge.from) + " to " + std::to_string(edge.to) + " is not finite";
    }
  }
  return "";
}

void move(const Eigen::VectorXd& step, std::vector<Pose2>& poses) {
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Vector3d part = step.segment<3>(3 * (static_cast<Eigen::Index>(i) - 1));
    Pose2& pose = poses[i];
    pose = {pose.x + part.x(), pose.y + part.y(), wrapAngle(pose.yaw + part.z())};
  }
}

// Gauss-Newton with the edges weighed anew in each step (iteratively reweighted least squares).
std::string iterate(const std::vector<PoseEdge>& edges, const GraphParams& params, GraphResult& result) {
  Eigen::SimplicialLDLT<Sparse, Eigen::Lower> solver;
  while (result.iterations < params.iterations) {
    System system(result.poses.size());
    for (const PoseEdge& edge : edges) {
      const Linearised at = linearise(edge, result.poses[edge.from], result.poses[edge.to]);
      system.add(edge, at, weight(at.error.dot(edge.information * at.error), params.cauchy));
    }
    const Sparse matrix = system.matrix();
    if (result.iterations == 0) {
      solver.analyzePattern(matrix);
    }
    solver.factorize(matrix);
    const Eigen::VectorXd step = solver.solve(-system.gradient());
    if (solver.info() != Eigen::Success || !step.allFinite()) {
      return "the normal equations have no solution: is every pose tied to the first?";
    }
    move(step, result.poses);
    ++result.iterations;
    if (step.cwiseAbs().maxCoeff() < params.converged) {
      break;
    }
  }
  return "";
}

}  // namespace

double squaredErrorOf(const PoseEdge& edge, const Pose2& from, const Pose2& to) {
  const Eigen::Vector3d error = errorOf(edge, from, to);
  return error.dot(edge.information * error);
}

GraphResult optimize(const std::vector<Pose2>& poses, const std::vector<PoseEdge>& edges, const GraphParams& params) {
  GraphResult result;
  result.poses = poses;
  result.reason = faultOf(poses, edges);
  if (!result.reason.empty()) {
    return result;
  }
  result.error_before = totalCost(poses, edges, params.cauchy);
  if (poses.size() > 1) {
    result.reason = iterate(edges, params, result);
  }
  result.ok = result.reason.empty();
  if (!result.ok) {
    result.poses = poses;
  }
  result.error_after = totalCost(result.poses, edges, params.cauchy);
  return result;
}

}  // namespace yarm::slam
