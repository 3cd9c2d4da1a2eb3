#include "association_score.hpp"

#include <algorithm>
#include <cmath>

namespace yarm::test {

namespace {

/// From the body centre of a robot to the mast its tip touches: reach, half the mast, and the breadth of a hair.
constexpr double kTipToMast = 1.30 + 0.05 + 0.005;

/// 0 at set 0, 1 in the middle third, 0 at the end: approach, stay, part.
double approach(int k, int sets) {
  const double t = static_cast<double>(k) / (sets - 1);
  return std::clamp(3.0 * std::min(t, 1.0 - t), 0.0, 1.0);
}

std::array<double, 6> between(const std::array<double, 6>& a, const std::array<double, 6>& b, double s) {
  std::array<double, 6> q{};
  for (std::size_t i = 0; i < q.size(); ++i) {
    q[i] = a[i] + s * (b[i] - a[i]);
  }
  return q;
}

Sequence roam() {
  return {"roam", standardCell(2, 2), 24, [](Scene& scene, int k) {
            const double s = approach(k, 24);
            moveAnkurbot(scene, "ankurbot_1", 1.9 - 1.0 * s, 1.9, M_PI - 0.5 * s);
            moveAnkurbot(scene, "ankurbot_2", 1.9, -1.9 + 0.6 * s, M_PI - 0.8 * s);
            moveHc10(scene, "hc10_barc", between(hc10Storage(), hc10OverPart(), s));
          }};
}

Sequence robotsTouch() {
  return {"robots touch", standardCell(2, 1), 24, [](Scene& scene, int k) {
            const double s = approach(k, 24);
            // The tip of 2 comes up to the mast of 1 from below: they touch at s = 1.
            moveAnkurbot(scene, "ankurbot_2", 1.9, -1.9 + s * (1.9 + 1.9 - kTipToMast), M_PI / 2);
          }};
}

Sequence debrisTouch() {
  Sequence s{"debris touch", standardCell(1, 1), 24, {}};
  addBox(s.scene, "box_1", {0.3, 0.3, 0.85}, {0.9, 0.9, 0.425}, true);
  addDebris(s.scene, "debris_2", 0.9, 0.9, 0.4, 0.85);
  s.at = [](Scene& scene, int k) {
    moveAnkurbot(scene, "ankurbot_1", 0.9 + 1.30 + 0.035 + 0.3 * (1.0 - approach(k, 24)), 0.9, M_PI);
  };
  return s;
}

Sequence tableTouch() {
  return {"table touch", standardCell(1, 1), 24, [](Scene& scene, int k) {
            const double s = approach(k, 24);
            moveAnkurbot(scene, "ankurbot_1", 1.5 - s * (1.5 - 0.802), 0.3, M_PI - 0.4);
          }};
}

Sequence armTouch() {
  return {"stand and arm touch", standardCell(1, 1), 24, [](Scene& scene, int k) {
            const double s = approach(k, 24);
            moveAnkurbot(scene, "ankurbot_1", -1.05, -1.9 + s * (1.9 - 1.30 - 0.11), M_PI / 2);
            moveHc10(scene, "hc10_barc", between(hc10Storage(), hc10OverPart(), 0.3 * s));
          }};
}

Sequence sanding() {
  return {"sanding", standardCell(1, 2), 24, [](Scene& scene, int k) {
            const double s = approach(k, 24);
            moveAnkurbot(scene, "ankurbot_1", 1.9 - 0.55 * s, 0.75 - 0.5 * s, M_PI);
            std::array<double, 6> low = hc10OverPart();
            low[0] = 0.25 * std::sin(0.8 * k);
            low[1] = 0.78;
            low[2] = 0.95;
            moveHc10(scene, "hc10_barc", between(hc10Storage(), low, s));
          }};
}

Sequence firstInTouch() {
  Sequence s{"first seen in touch", standardCell(1, 0), 24, {}};
  s.at = [](Scene& scene, int k) {
    if (k == 0) {
      moveAnkurbot(scene, "ankurbot_1", 1.6, 0.9, M_PI);
    }
    if (k == 3) {  // its tip touches the first one's mast
      addAnkurbot(scene, "ankurbot_2", 1.6, 0.9 - kTipToMast, M_PI / 2);
    }
    if (k == 6) {  // under the first one's tip, on the part, and another beside it
      addDebris(scene, "debris_1", 0.3, 0.85, 0.0, 0.83);
      addDebris(scene, "debris_2", -0.1, 0.1, 0.7);
    }
    if (k > 12) {
      moveAnkurbot(scene, "ankurbot_2", 1.6, 0.9 - kTipToMast - 0.05 * (k - 12), M_PI / 2);
    }
  };
  return s;
}

}  // namespace

std::vector<Sequence> scoredSequences() {
  return {roam(), robotsTouch(), debrisTouch(), tableTouch(), armTouch(), sanding(), firstInTouch()};
}

}  // namespace yarm::test
