#include "yarm/perception/view.hpp"

#include <algorithm>
#include <cmath>

namespace yarm::perception {

namespace {
constexpr double kSmoothing = 0.1;  // weight of a new cloud
}  // namespace

View ViewWatch::judge(std::size_t camera, const CameraReport& report) {
  Camera& c = cameras_[camera];
  View view;
  view.share = report.points == 0 ? 0.0 : static_cast<double>(report.finite) / static_cast<double>(report.points);
  c.smooth = c.heard ? c.smooth + kSmoothing * (view.share - c.smooth) : view.share;
  c.heard = true;
  c.usual = std::max(c.usual, c.smooth);
  view.usual = c.usual;
  view.sees = view.share >= params_.min_view && view.share >= params_.usual_view * view.usual;
  return view;
}

std::size_t ViewWatch::needed() const {
  const double share = params_.least_cameras * static_cast<double>(cameras_.size());
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(share - 1e-9)));
}

void ViewWatch::reset() {
  std::fill(cameras_.begin(), cameras_.end(), Camera());
}

}  // namespace yarm::perception
