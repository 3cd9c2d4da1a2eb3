// What service predict_new_state answers.
#pragma once

#include "yarm/perception/types.hpp"

#include <yarm/PredictNewState.h>

namespace yarm {

/// Answers whether objects would touch if they stood elsewhere. A refused question is answered with collision = true:
/// nothing was shown to be safe. point_radius: points are balls of this radius, metres.
void answerPrediction(const yarm::PredictNewState::Request& request, const perception::AssociatedSet& present,
                      const perception::GridSpec& grid, double point_radius, yarm::PredictNewState::Response& response);

}  // namespace yarm
