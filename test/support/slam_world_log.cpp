// Writes a tour of a simulated room to a file, for tests in other languages:
// slam_world_log ROOM SCANS FILE [boxes]; with boxes: a room with ten boxes.
// Text: the surfaces seen (points), the surfaces, then one line a scan: stamp ns, odometry x y yaw, truth x y yaw,
// ranges.
#include "slam_score.hpp"
#include "slam_world.hpp"

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

namespace {

constexpr int kSeenScans = 10;
constexpr double kSeenRange = 4.0;

void writePose(std::ostream& out, const yarm::slam::Pose2& pose) {
  out << ' ' << pose.x << ' ' << pose.y << ' ' << pose.yaw;
}

}  // namespace

int main(int argc, char** argv) {
  const bool boxes = argc == 5 && std::string(argv[4]) == "boxes";
  if (argc != 4 && !boxes) {
    std::cerr << "usage: slam_world_log ROOM SCANS FILE [boxes]\n";
    return 1;
  }
  const int room = std::atoi(argv[1]);
  const yarm::test::Arena arena = boxes ? yarm::test::Arena::withTenBoxes(room) : yarm::test::Arena(room);
  yarm::test::RunOptions options;
  options.angle_min = -0.52157;  // the lopsided limits of a depth image turned into a scan
  options.angle_max = 0.52428;
  yarm::test::Run run(arena, room, options);
  yarm::test::SeenSurfaces seen(arena);
  std::vector<yarm::test::Moment> moments;
  for (int i = 0; i < std::atoi(argv[2]); ++i) {
    moments.push_back(run.next());
    seen.add(moments.back(), kSeenRange);
  }
  std::ofstream out(argv[3]);
  out.precision(9);
  for (const auto& point : seen.seen(kSeenScans)) {
    out << point.x() << ' ' << point.y() << ' ';
  }
  out << '\n';
  for (const auto& surface : arena.surfaces()) {
    out << surface.a.x() << ' ' << surface.a.y() << ' ' << surface.b.x() << ' ' << surface.b.y() << ' ';
  }
  out << '\n';
  for (const auto& moment : moments) {
    out << moment.scan.stamp_ns;
    writePose(out, moment.scan.T_odom_base);
    writePose(out, moment.T_arena_base);
    for (const float range : moment.scan.ranges) {
      out << ' ' << range;
    }
    out << '\n';
  }
  return out.good() ? 0 : 1;
}
