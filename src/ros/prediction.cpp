#include "yarm/ros/prediction.hpp"

#include "yarm/perception/predict.hpp"
#include "yarm/ros/conversions.hpp"

#include <string>
#include <utility>
#include <vector>

namespace yarm {

void answerPrediction(const yarm::PredictNewState::Request& request, const perception::AssociatedSet& present,
                      const perception::GridSpec& grid, double point_radius,
                      yarm::PredictNewState::Response& response) {
  response.collision = true;
  if (request.names.size() != request.poses.size()) {
    response.message = "refused: " + std::to_string(request.names.size()) + " names for " +
                       std::to_string(request.poses.size()) + " poses";
    return;
  }
  std::vector<std::pair<std::string, Eigen::Isometry3d>> moves;
  for (std::size_t i = 0; i < request.names.size(); ++i) {
    const Read<Eigen::Isometry3d> pose = readPose(request.poses[i]);
    if (!pose.ok()) {
      response.message = "refused: " + request.names[i] + ": " + pose.reason;
      return;
    }
    moves.emplace_back(request.names[i], pose.value);
  }
  const perception::Prediction prediction = perception::predictNewState(present, grid, moves, point_radius);
  response.collision = !prediction.ok || prediction.collision;
  response.cells = cellsOf(grid, prediction.cells);
  for (const auto& pair : prediction.pairs) {
    response.pairs.push_back(pair.first + " " + pair.second);
  }
  response.message = prediction.ok ? prediction.message : "refused: " + prediction.message;
}

}  // namespace yarm
