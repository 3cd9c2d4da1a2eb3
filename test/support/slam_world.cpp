#include "slam_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

namespace yarm::test {

namespace {

using slam::Pose2;
using slam::wrapAngle;
using Vec2 = Eigen::Vector2d;

constexpr double kEdge = 6.0;          // m
constexpr double kRobotRadius = 0.25;  // m
constexpr double kPathCell = 0.1;      // m
constexpr int kPathCells = 60;
constexpr double kBetweenBoxes = 0.75;  // m: between the centres of two boxes
constexpr double kBesideWall = 0.35;    // m: between a box's centre and a wall
constexpr double kRangeMin = 0.45;
constexpr double kRangeMax = 5.0;
constexpr double kDropOut = 0.01;         // share of beams
constexpr double kDepthNoise = 0.001425;  // 1/m: sigma(z) = this z^2
constexpr double kDepthStep = 0.00285;    // 1/m: a step of the sensor is this z^2
constexpr int kRows = 10;                 // the nearest of so many rows is taken
constexpr double kRowShare = 0.305;       // of the noise's variance that differs from row to row
constexpr int kBeamSpread = 5;            // beams whose noise is averaged, so that neighbours err together

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

Vec2 turned(const Vec2& v, double yaw) {
  return {std::cos(yaw) * v.x() - std::sin(yaw) * v.y(), std::sin(yaw) * v.x() + std::cos(yaw) * v.y()};
}

Vec2 centreOf(int cell) {
  return {(cell % kPathCells + 0.5) * kPathCell, (cell / kPathCells + 0.5) * kPathCell};
}

int cellOf(const Vec2& point) {
  return static_cast<int>(point.y() / kPathCell) * kPathCells + static_cast<int>(point.x() / kPathCell);
}

// Shortest way over free cells, 8-connected (Dijkstra); empty when there is none.
std::deque<Vec2> shortestWay(const std::vector<bool>& free, int from, int to) {
  std::vector<double> cost(free.size(), std::numeric_limits<double>::infinity());
  std::vector<int> before(free.size(), -1);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  cost[to] = 0.0;
  open.emplace(0.0, to);
  while (!open.empty()) {
    const auto [spent, cell] = open.top();
    open.pop();
    if (spent > cost[cell]) {
      continue;
    }
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int x = cell % kPathCells + dx;
        const int y = cell / kPathCells + dy;
        const int next = y * kPathCells + x;
        if (x < 0 || y < 0 || x >= kPathCells || y >= kPathCells || !free[next]) {
          continue;
        }
        const double total = spent + std::hypot(dx, dy);
        if (total < cost[next]) {
          cost[next] = total;
          before[next] = cell;
          open.emplace(total, next);
        }
      }
    }
  }
  std::deque<Vec2> way;
  for (int cell = before[from]; cell >= 0; cell = before[cell]) {
    way.push_back(centreOf(cell));
  }
  return way;
}

}  // namespace

double Segment::distanceTo(const Vec2& point) const {
  const Vec2 along = b - a;
  const double share = std::clamp((point - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (a + share * along - point).norm();
}

Arena::Arena(std::uint64_t seed) {
  std::mt19937_64 random(seed * 7919 + 17);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  addRoom();
  addWalls(3 + static_cast<int>(random() % 3), random);
  const int boxes = 4 + static_cast<int>(random() % 4);
  for (int i = 0; i < boxes; ++i) {
    const Vec2 centre{uniform(0.5, kEdge - 0.5), uniform(0.5, kEdge - 0.5)};
    addBlock({centre, {uniform(0.1, 0.3), uniform(0.1, 0.3)}, uniform(0.0, M_PI / 2)});
  }
}

Arena Arena::withTenBoxes(std::uint64_t seed, int walls) {
  std::mt19937_64 random(seed * 6151 + 29);
  std::uniform_real_distribution<double> place(0.4, kEdge - 0.4);
  Arena arena{std::vector<Segment>{}};
  arena.addRoom();
  arena.addWalls(walls, random);
  std::vector<Vec2> centres;
  while (centres.size() < 10) {
    const Vec2 centre{place(random), place(random)};
    const bool is_clear = std::all_of(centres.begin(), centres.end(),
                                      [&](const Vec2& other) { return (other - centre).norm() > kBetweenBoxes; });
    if (is_clear && arena.isFree(centre, kBesideWall)) {
      centres.push_back(centre);
    }
  }
  for (const Vec2& centre : centres) {
    arena.addBlock({centre, {0.25, 0.16}, std::uniform_real_distribution<double>(0.0, M_PI)(random)});
  }
  return arena;
}

void Arena::addRoom() {
  const std::array<Vec2, 4> corners{Vec2{0, 0}, Vec2{kEdge, 0}, Vec2{kEdge, kEdge}, Vec2{0, kEdge}};
  for (int i = 0; i < 4; ++i) {
    surfaces_.push_back({corners[i], corners[(i + 1) % 4]});
  }
}

void Arena::addWalls(int count, std::mt19937_64& random) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < count; ++i) {
    const double length = uniform(1.2, 2.6);
    const bool upright = random() % 2 == 0;
    const bool attached = random() % 2 == 0;
    const double along = attached ? (random() % 2 == 0 ? length / 2 : kEdge - length / 2) : uniform(1.5, kEdge - 1.5);
    const double across = uniform(1.0, kEdge - 1.0);
    const Vec2 half{length / 2, 0.05};
    addBlock(upright ? Block{{across, along}, {half.y(), half.x()}, 0.0} : Block{{along, across}, half, 0.0});
  }
}

void Arena::addBlock(const Block& block) {
  std::array<Vec2, 4> corners;
  const std::array<Vec2, 4> signs{Vec2{-1, -1}, Vec2{1, -1}, Vec2{1, 1}, Vec2{-1, 1}};
  for (int i = 0; i < 4; ++i) {
    corners[i] = block.centre + turned(signs[i].cwiseProduct(block.half), block.yaw);
  }
  for (int i = 0; i < 4; ++i) {
    surfaces_.push_back({corners[i], corners[(i + 1) % 4]});
  }
  blocks_.push_back(block);
}

double Arena::cast(const Vec2& from, double bearing, int* hit) const {
  const Vec2 ray{std::cos(bearing), std::sin(bearing)};
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const Vec2 along = surfaces_[i].b - surfaces_[i].a;
    const Vec2 to = surfaces_[i].a - from;
    const double parallel = cross(ray, along);
    if (std::abs(parallel) < 1e-12) {
      continue;
    }
    const double range = cross(to, along) / parallel;
    const double share = cross(to, ray) / parallel;
    if (range > 0.0 && share >= 0.0 && share <= 1.0 && range < nearest) {
      nearest = range;
      if (hit != nullptr) {
        *hit = static_cast<int>(i);
      }
    }
  }
  return nearest;
}

double Arena::clearance(const Vec2& point) const {
  double least = std::numeric_limits<double>::infinity();
  for (const Segment& surface : surfaces_) {
    least = std::min(least, surface.distanceTo(point));
  }
  return least;
}

bool Arena::isFree(const Vec2& point, double radius) const {
  for (const Block& block : blocks_) {
    const Vec2 inside = turned(point - block.centre, -block.yaw).cwiseAbs() - block.half;
    if (inside.maxCoeff() < 0.0) {
      return false;
    }
  }
  const bool in_room = point.minCoeff() > 0.0 && point.maxCoeff() < kEdge;
  return in_room && clearance(point) >= radius;
}

Pose2 sensorMount() {
  return {-0.087, 0.0125, 0.0};
}

Run::Run(const Arena& arena, std::uint64_t seed, const RunOptions& options)
    : arena_(arena), options_(options), random_(seed * 104729 + 71) {
  std::uniform_real_distribution<double> even(-1.0, 1.0);
  odometer_ = {1.0 + 0.02 * options.odometry * even(random_), 1.0 + 0.02 * options.odometry * even(random_),
               0.01 * options.odometry * even(random_)};
  Vec2 start;
  do {
    start = 0.5 * kEdge * Vec2{1.0 + even(random_), 1.0 + even(random_)};
  } while (!arena.isFree(start, kRobotRadius + kPathCell));
  truth_ = {start.x(), start.y(), M_PI * even(random_)};
  spin_left_ = 2.0 * M_PI * options.first_turns;
}

void Run::planTour() {
  std::vector<bool> free(kPathCells * kPathCells);
  for (std::size_t i = 0; i < free.size(); ++i) {
    free[i] = arena_.isFree(centreOf(static_cast<int>(i)), kRobotRadius);
  }
  const int from = cellOf({truth_.x, truth_.y});
  free[from] = true;
  while (path_.size() < 8) {
    const int to = static_cast<int>(random_() % free.size());
    if (free[to]) {
      path_ = shortestWay(free, from, to);
    }
  }
  spin_left_ = random_() % 2 == 0 ? 2.0 * M_PI : 0.0;
}

void Run::drive() {
  const double dt = 1.0 / options_.rate_hz;
  while (!path_.empty() && std::hypot(path_.front().x() - truth_.x, path_.front().y() - truth_.y) < 0.15) {
    path_.pop_front();
  }
  if (path_.empty() && spin_left_ <= 0.0) {
    planTour();
  }
  double way = 0.0;
  double turn = options_.turn_rate * dt;
  if (path_.empty()) {
    spin_left_ -= turn;
  } else {
    const double bearing = std::atan2(path_.front().y() - truth_.y, path_.front().x() - truth_.x);
    const double error = wrapAngle(bearing - truth_.yaw);
    turn = std::clamp(error, -turn, turn);
    way = std::abs(error) < 0.4 ? options_.speed * dt : 0.0;
  }
  truth_ = truth_ * Pose2{way, 0.0, turn};
  driven_m_ += way;
  turned_rad_ += std::abs(turn);
  measureMotion(way, turn);
}

void Run::measureMotion(double way, double turn) {
  const double scale = options_.odometry;
  double dx = way * odometer_.distance_scale + 0.03 * scale * std::sqrt(way) * gauss();
  double dy = 0.0;
  double dyaw =
      turn * odometer_.turn_scale + way * odometer_.turn_per_m + 0.02 * scale * std::sqrt(std::abs(turn)) * gauss();
  if (std::uniform_real_distribution<double>(0.0, 30.0 * options_.rate_hz)(random_) < 1.0) {
    dx += 0.02 * options_.slip * gauss();
    dy += 0.02 * options_.slip * gauss();
    dyaw += 0.02 * options_.slip * gauss();
  }
  odometry_ = odometry_ * Pose2{dx, dy, dyaw};
}

void Run::scanInto(Moment& moment) {
  slam::Scan& scan = moment.scan;
  const Pose2 sensor = moment.T_arena_base * sensorMount();
  std::vector<double> white(static_cast<std::size_t>(scan.ranges.size()) + kBeamSpread);
  std::generate(white.begin(), white.end(), [this] { return gauss(); });
  const double common_scale = std::sqrt((1.0 - kRowShare) / kBeamSpread);
  const double row_scale = std::sqrt(kRowShare);
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const double bearing = scan.angle_min + static_cast<double>(beam) * scan.angle_increment;
    const double range = arena_.cast({sensor.x, sensor.y}, sensor.yaw + bearing, &moment.surface[beam]);
    moment.exact[beam] = static_cast<float>(range);
    double measured = range;
    if (options_.noise > 0.0) {
      const double depth = range * std::cos(bearing);
      double common = 0.0;
      for (int i = 0; i < kBeamSpread; ++i) {
        common += white[beam + i];
      }
      double least = std::numeric_limits<double>::infinity();
      for (int row = 0; row < kRows; ++row) {
        const double noise = common_scale * common + row_scale * gauss();
        const double noisy = depth + options_.noise * kDepthNoise * depth * depth * noise;
        const double step = options_.noise * kDepthStep;
        least = std::min(least, 1.0 / (std::max(1.0, std::round(1.0 / (noisy * step))) * step));
      }
      measured = least / std::cos(bearing);
    }
    const bool lost = options_.noise > 0.0 && std::uniform_real_distribution<double>()(random_) < kDropOut;
    const bool seen = !lost && measured >= kRangeMin && measured <= kRangeMax;
    scan.ranges[beam] = seen ? static_cast<float>(measured) : std::numeric_limits<float>::quiet_NaN();
  }
}

Moment Run::next() {
  if (tick_ > 0) {
    drive();
  }
  Moment moment;
  moment.T_arena_base = truth_;
  slam::Scan& scan = moment.scan;
  scan.stamp_ns = 1'000'000'000 + static_cast<std::int64_t>(static_cast<double>(tick_) * 1e9 / options_.rate_hz);
  ++tick_;
  scan.angle_min = options_.angle_min;
  scan.angle_increment = (options_.angle_max - options_.angle_min) / (options_.beams - 1);
  scan.range_min = kRangeMin;
  scan.range_max = kRangeMax;
  scan.T_base_sensor = sensorMount();
  scan.T_odom_base = odometry_;
  scan.ranges.resize(options_.beams);
  moment.exact.resize(options_.beams);
  moment.surface.resize(options_.beams);
  scanInto(moment);
  return moment;
}

slam::GridMap drawnMap(const Arena& arena, std::uint64_t seed, double resolution) {
  constexpr int kMargin = 5;  // cells around the room
  std::mt19937_64 random(seed * 389 + 3);
  std::uniform_real_distribution<double> part(0.0, resolution);
  slam::GridMap map;
  map.resolution = resolution;
  map.width = map.height = static_cast<int>(std::ceil(kEdge / resolution)) + 2 * kMargin;
  map.origin_x = -kMargin * resolution + part(random);
  map.origin_y = -kMargin * resolution + part(random);
  map.cells.assign(static_cast<std::size_t>(map.width) * map.height, -1);
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      const Vec2 at = map.centre(column, row);
      if (at.minCoeff() > 0.0 && at.maxCoeff() < kEdge) {
        map.cells[static_cast<std::size_t>(row) * map.width + column] = arena.isFree(at, 0.0) ? 0 : 100;
      }
    }
  }
  for (const Segment& surface : arena.surfaces()) {
    const int steps = static_cast<int>(std::ceil((surface.b - surface.a).norm() / (0.1 * resolution)));
    for (int i = 0; i <= steps; ++i) {
      const Vec2 at = surface.a + (surface.b - surface.a) * i / steps;
      const int column = static_cast<int>(std::floor((at.x() - map.origin_x) / resolution));
      const int row = static_cast<int>(std::floor((at.y() - map.origin_y) / resolution));
      if (column >= 0 && row >= 0 && column < map.width && row < map.height) {
        map.cells[static_cast<std::size_t>(row) * map.width + column] = 100;
      }
    }
  }
  return map;
}

slam::Scan exactScan(const Arena& arena, const Pose2& T_arena_sensor, const RunOptions& options) {
  slam::Scan scan;
  scan.stamp_ns = 1'000'000'000;
  scan.angle_min = options.angle_min;
  scan.angle_increment = (options.angle_max - options.angle_min) / (options.beams - 1);
  scan.range_min = kRangeMin;
  scan.range_max = kRangeMax;
  for (int beam = 0; beam < options.beams; ++beam) {
    const double bearing = T_arena_sensor.yaw + scan.angle_min + beam * scan.angle_increment;
    const double range = arena.cast({T_arena_sensor.x, T_arena_sensor.y}, bearing);
    scan.ranges.push_back(range >= kRangeMin && range <= kRangeMax ? static_cast<float>(range)
                                                                   : std::numeric_limits<float>::quiet_NaN());
  }
  return scan;
}

}  // namespace yarm::test
