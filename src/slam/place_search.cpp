#include "yarm/slam/place_search.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <set>
#include <utility>

namespace yarm::slam {

namespace {

constexpr double kEmptyMargin = 0.1;  // m: an empty place this near to something seen may lie on its blurred edge
constexpr double kNearFree = 0.3;     // m: the robot stands no farther than this from a cell known to be free
constexpr int kFullScore = 255;
constexpr double kRidge = 1.03;  // a place whose neighbour scores higher than this many times its own is no peak
constexpr std::size_t kMostPlaces = 20;

// Keeps the first of all points that fall into one cell.
class Thinner {
 public:
  explicit Thinner(double spacing) : spacing_(spacing) {}
  bool isNew(const Eigen::Vector2d& point) {
    return seen_.emplace(std::lround(point.x() / spacing_), std::lround(point.y() / spacing_)).second;
  }

 private:
  double spacing_;
  std::set<std::pair<long, long>> seen_;
};

template <class Value>
std::vector<Value> evenly(const std::vector<Value>& values, int most) {
  const double stride = std::max(1.0, static_cast<double>(values.size()) / most);
  std::vector<Value> chosen;
  for (double at = 0.5 * stride; at < static_cast<double>(values.size()); at += stride) {
    chosen.push_back(values[static_cast<std::size_t>(at)]);
  }
  return chosen;
}

// Likelihood of a surface in each cell, in 1/255, with a border that no point leaves.
class Raster {
 public:
  Raster(const DistanceField& field, double sigma, double farthest)
      : border_(static_cast<int>(std::ceil(farthest / field.resolution())) + 2),
        width_(field.width() + 2 * border_),
        cells_(static_cast<std::size_t>(width_) * (field.height() + 2 * border_), 0) {
    for (int row = 0; row < field.height(); ++row) {
      for (int column = 0; column < field.width(); ++column) {
        const double distance = field.cell(column, row);
        const double likelihood =
            distance < field.reach() ? std::exp(-0.5 * distance * distance / (sigma * sigma)) : 0.0;
        cells_[indexOf(column, row)] = static_cast<std::uint8_t>(std::lround(kFullScore * likelihood));
      }
    }
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] std::size_t indexOf(int column, int row) const {
    return static_cast<std::size_t>(row + border_) * width_ + column + border_;
  }
  [[nodiscard]] int sumAt(std::size_t index, const std::vector<int>& offsets) const {
    const std::uint8_t* at = cells_.data() + index;
    int sum = 0;
    for (const int offset : offsets) {
      sum += at[offset];
    }
    return sum;
  }

 private:
  int border_;
  int width_;
  std::vector<std::uint8_t> cells_;
};

// The positions and headings that are tried, and how well each does.
class Lattice {
 public:
  Lattice(const DistanceField& field, const std::optional<SearchWindow>& window, const SearchParams& params)
      : field_(field), stride_(std::max(1, static_cast<int>(std::lround(params.step / field.resolution())))) {
    const int all = static_cast<int>(std::ceil(2.0 * M_PI / params.angle_step));
    headings_ = all;
    double first = -M_PI;
    double step = 2.0 * M_PI / all;
    if (window && window->angle < M_PI) {
      const int half = static_cast<int>(std::ceil(window->angle / params.angle_step));
      headings_ = 2 * half + 1;
      step = params.angle_step;
      first = window->centre.yaw - half * step;
      turns_round_ = false;
    }
    for (int i = 0; i < headings_; ++i) {
      yaws_.push_back(wrapAngle(first + i * step));
    }
    columns_ = (field.width() + stride_ - 1) / stride_;
    rows_ = (field.height() + stride_ - 1) / stride_;
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        if (isOpen(column, row, window)) {
          open_.push_back(row * columns_ + column);
        }
      }
    }
    scores_.assign(static_cast<std::size_t>(headings_) * columns_ * rows_, 0);
  }

  void score(const std::vector<SeenPoint>& points, const Raster& raster) {
    std::vector<int> offsets(points.size());
    for (int heading = 0; heading < headings_; ++heading) {
      const Pose2 turn{0.0, 0.0, yaws_[heading]};
      std::transform(points.begin(), points.end(), offsets.begin(), [&](const SeenPoint& point) {
        const Eigen::Vector2d at = turn * point.at / field_.resolution();
        return static_cast<int>(std::lround(at.y())) * raster.width() + static_cast<int>(std::lround(at.x()));
      });
      for (const int position : open_) {
        const std::size_t index = raster.indexOf(position % columns_ * stride_, position / columns_ * stride_);
        scores_[indexOf(heading, position)] = static_cast<std::uint16_t>(raster.sumAt(index, offsets));
      }
    }
  }

  // The poses that no neighbour surpasses by much, best first: along a wall all are alike, and none may be left out.
  [[nodiscard]] std::vector<Pose2> best(int most) const {
    std::vector<std::pair<int, std::size_t>> peaks;
    for (int heading = 0; heading < headings_; ++heading) {
      for (const int position : open_) {
        const std::size_t index = indexOf(heading, position);
        if (scores_[index] > 0 && isPeak(heading, position)) {
          peaks.emplace_back(-static_cast<int>(scores_[index]), index);
        }
      }
    }
    std::sort(peaks.begin(), peaks.end());
    std::vector<Pose2> poses;
    for (const auto& [score, index] : peaks) {
      if (static_cast<int>(poses.size()) == most) {
        break;
      }
      const int position = static_cast<int>(index % (static_cast<std::size_t>(columns_) * rows_));
      const Eigen::Vector2d at = field_.centre(position % columns_ * stride_, position / columns_ * stride_);
      poses.push_back({at.x(), at.y(), yaws_[index / (static_cast<std::size_t>(columns_) * rows_)]});
    }
    return poses;
  }

 private:
  [[nodiscard]] std::size_t indexOf(int heading, int position) const {
    return static_cast<std::size_t>(heading) * columns_ * rows_ + position;
  }

  [[nodiscard]] bool isOpen(int column, int row, const std::optional<SearchWindow>& window) const {
    const Eigen::Vector2d at = field_.centre(column * stride_, row * stride_);
    if (window && (std::abs(at.x() - window->centre.x) > window->distance ||
                   std::abs(at.y() - window->centre.y) > window->distance)) {
      return false;
    }
    bool open = field_.isFree(at);
    for (int corner = 0; corner < 4 && !open; ++corner) {
      const Eigen::Vector2d away{corner % 2 == 0 ? kNearFree : -kNearFree, corner < 2 ? kNearFree : -kNearFree};
      open = field_.isFree(at + away);
    }
    return open;
  }

  [[nodiscard]] bool isPeak(int heading, int position) const {
    const double own = scores_[indexOf(heading, position)];
    for (int turn = -1; turn <= 1; ++turn) {
      const int other = turns_round_ ? (heading + turn + headings_) % headings_ : heading + turn;
      if (other < 0 || other >= headings_) {
        continue;
      }
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int column = position % columns_ + dx;
          const int row = position / columns_ + dy;
          if (column < 0 || row < 0 || column >= columns_ || row >= rows_) {
            continue;
          }
          if (scores_[indexOf(other, row * columns_ + column)] > kRidge * own) {
            return false;
          }
        }
      }
    }
    return true;
  }

  const DistanceField& field_;
  int stride_;
  int headings_;
  bool turns_round_{true};
  int columns_{0};
  int rows_{0};
  std::vector<double> yaws_;
  std::vector<int> open_;  // positions, row-major
  std::vector<std::uint16_t> scores_;
};

double scoreOf(const Pose2& pose, const std::vector<SeenPoint>& points, const std::vector<Eigen::Vector2d>& empty,
               const DistanceField& field, double sigma) {
  double likelihood = 0.0;
  for (const SeenPoint& point : points) {
    const double distance = field.at(pose * point.at).distance;
    likelihood += distance < field.reach() ? std::exp(-0.5 * distance * distance / (sigma * sigma)) : 0.0;
  }
  int filled = 0;
  for (const Eigen::Vector2d& place : empty) {
    filled += field.isFree(pose * place) ? 0 : 1;
  }
  return likelihood / static_cast<double>(points.size()) -
         static_cast<double>(filled) / static_cast<double>(std::max<std::size_t>(1, empty.size()));
}

bool areApart(const Pose2& a, const Pose2& b, const SearchParams& params) {
  return a.distanceTo(b) > params.apart_m || std::abs(wrapAngle(a.yaw - b.yaw)) > params.apart_rad;
}

// The places that differ from every better one.
std::vector<Place> distinct(std::vector<Place> places, const SearchParams& params) {
  std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.score > b.score; });
  std::vector<Place> kept;
  for (const Place& place : places) {
    const bool is_new = std::all_of(kept.begin(), kept.end(),
                                    [&](const Place& better) { return areApart(place.pose, better.pose, params); });
    if (is_new && kept.size() < kMostPlaces) {
      kept.push_back(place);
    }
  }
  return kept;
}

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.0f %%", 100.0 * share);
  return text;
}

void judge(const SearchParams& params, PlaceSearch& result) {
  const double score = result.places.front().score;
  const double second = result.places.size() > 1 ? std::max(0.0, result.places[1].score) : 0.0;
  result.margin = score - second;
  if (score < params.least_score) {
    result.reason = "the best place fits what was seen to " + percent(score) + ", at least " +
                    percent(params.least_score) + " are needed";
  } else if (result.margin < params.least_margin) {
    result.reason = "two places fit what was seen nearly alike, to " + percent(score) + " and " + percent(second) +
                    "; " + percent(params.least_margin) + " must lie between them";
  }
  result.found = result.reason.empty();
}

}  // namespace

Surroundings surroundingsOf(Mapper& submap, const Pose2& T_submap_base, const SearchParams& params) {
  Surroundings seen;
  const Pose2 T_base_submap = T_submap_base.inverse();
  const Keyframes& keyframes = submap.keyframes();
  Thinner thin_points(params.point_spacing);
  for (int i = keyframes.size() - 1; i >= 0; --i) {  // where the newest ones look they count
    const Pose2 T_base_sensor = T_base_submap * keyframes.pose(i);
    for (const SurfacePoint& point : keyframes.points(i).points()) {
      const Eigen::Vector2d at = T_base_sensor * Eigen::Vector2d{point.x, point.y};
      if (thin_points.isNew(at)) {
        seen.points.push_back({at, point.sigma});
      }
    }
  }
  submap.requestMap();
  const auto map = submap.map();
  if (!map || map->cells.empty()) {  // a slip takes back the scans since the last match: it may have been all of them
    return seen;
  }
  FieldParams drawn;
  drawn.free_at_most = 0;
  const DistanceField field(*map, drawn);
  Thinner thin_places(params.free_spacing);
  for (int row = 0; row < map->height; ++row) {
    for (int column = 0; column < map->width; ++column) {
      const Eigen::Vector2d at = map->centre(column, row);
      if (field.isFreeCell(column, row) && field.cell(column, row) > kEmptyMargin && thin_places.isNew(at)) {
        seen.empty.push_back(T_base_submap * at);
      }
    }
  }
  return seen;
}

PlaceSearch searchPlace(const Surroundings& seen, const DistanceField& field, const std::optional<SearchWindow>& window,
                        const LocaliserParams& params) {
  PlaceSearch result;
  const SearchParams& search = params.search;
  if (static_cast<int>(seen.points.size()) < search.least_points) {
    result.reason = "only " + std::to_string(seen.points.size()) + " points of surfaces were seen, at least " +
                    std::to_string(search.least_points) + " are needed";
    return result;
  }
  const auto first = evenly(seen.points, search.points_first);
  const auto last = evenly(seen.points, search.points_last);
  const auto empty = evenly(seen.empty, search.free_samples);
  double farthest = 0.0;
  for (const SeenPoint& point : first) {
    farthest = std::max(farthest, point.at.norm());
  }
  Lattice lattice(field, window, search);
  lattice.score(first, Raster(field, search.sigma_first, farthest));
  std::vector<Place> places;
  for (const Pose2& pose : lattice.best(search.candidates)) {
    const Pose2 fitted = fitToField(first, pose, field, std::nullopt, params.fit).pose;
    places.push_back({fitted, scoreOf(fitted, last, empty, field, search.sigma_last)});
  }
  if (places.empty()) {
    result.reason = window ? "no place in the window around the pose given is free" : "no place of the map is free";
    return result;
  }
  result.places = distinct(std::move(places), search);
  result.best = fitToField(last, result.places.front().pose, field, std::nullopt, params.fit);
  judge(search, result);
  return result;
}

}  // namespace yarm::slam
