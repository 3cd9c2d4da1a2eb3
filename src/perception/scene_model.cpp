#include "scene_model.hpp"

#include "safe_cast.hpp"
#include "solid_math.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace yarm::perception {

namespace {
constexpr float kSite = 0.125F;          // edge of a site of the index, metres
constexpr float kLargestMargin = 0.12F;  // no surface explains a point farther away, metres
constexpr float kHiddenFace = 4.F;       // added cost of a face that looks away from the camera
constexpr float kAwayCosine = 0.05F;
constexpr std::int32_t kNone = -1;
constexpr std::int32_t kMany = -2;
constexpr float kLookBack = 0.3F;  // rays are followed from this far before a point, metres

using solid_math::Four;
using solid_math::FourBits;
using solid_math::FourVectors;
constexpr int kLanes = 4;

/// What is needed of four points.
struct FourPoints {
  FourVectors position;
  FourVectors ray;
  Four sigma;
};

FourPoints pick(const std::vector<MergedPoint>& points, const std::size_t (&at)[kLanes]) {
  const MergedPoint& a = points[at[0]];
  const MergedPoint& b = points[at[1]];
  const MergedPoint& c = points[at[2]];
  const MergedPoint& d = points[at[3]];
  return {FourVectors{Four{a.x, b.x, c.x, d.x}, Four{a.y, b.y, c.y, d.y}, Four{a.z, b.z, c.z, d.z}},
          FourVectors{Four{a.ux, b.ux, c.ux, d.ux}, Four{a.uy, b.uy, c.uy, d.uy}, Four{a.uz, b.uz, c.uz, d.uz}},
          Four{a.sigma, b.sigma, c.sigma, d.sigma}};
}

FourVectors times(const Eigen::Matrix3f& m, const FourVectors& v) {
  return {m(0, 0) * v.x + m(0, 1) * v.y + m(0, 2) * v.z, m(1, 0) * v.x + m(1, 1) * v.y + m(1, 2) * v.z,
          m(2, 0) * v.x + m(2, 1) * v.y + m(2, 2) * v.z};
}

}  // namespace

SceneModel::SceneModel(const AssociationParams& params) : params_(params) {
  tolerance_ = static_cast<float>(params.shape_tolerance);
  sigmas_ = static_cast<float>(params.noise_sigmas);
  tau2_ = tolerance_ * tolerance_ / 9.F;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    low_[a] = static_cast<float>(params.grid.min[i]);
    n_[a] = std::max(1, static_cast<int>(std::ceil((params.grid.max[i] - params.grid.min[i]) / kSite)));
  }
}

void SceneModel::clear() {
  pieces_.clear();
}

void SceneModel::add(int object, const Solid& solid, const Eigen::Isometry3d& T_world_solid) {
  Piece piece{object,
              solid.shape,
              solid.size.cast<float>(),
              {},
              T_world_solid.linear().transpose().cast<float>(),
              T_world_solid.translation().cast<float>(),
              {}};
  piece.half = halfExtents(piece.shape, piece.size);
  piece.extent = piece.R_solid_world.transpose().cwiseAbs() * piece.half;
  pieces_.push_back(piece);
}

SceneModel::Range SceneModel::sitesOf(const Piece& piece) const {
  Range range{};
  for (int a = 0; a < 3; ++a) {
    const float reach = piece.extent[a] + kLargestMargin;
    range.low[a] = intWithin(std::floor((piece.centre[a] - reach - low_[a]) / kSite), 0, n_[a]);
    range.high[a] = intWithin(std::floor((piece.centre[a] + reach - low_[a]) / kSite), -1, n_[a] - 1);
  }
  return range;
}

int SceneModel::siteOf(float x, float y, float z) const {
  const auto along = [&](float value, int axis) {
    return intWithin((value - low_[axis]) * (1.F / kSite), 0, n_[axis] - 1);
  };
  return (along(x, 0) * n_[1] + along(y, 1)) * n_[2] + along(z, 2);
}

template <typename Visit>
void SceneModel::forSites(const Piece& piece, Visit visit) const {
  const Range r = sitesOf(piece);
  for (int x = r.low[0]; x <= r.high[0]; ++x) {
    for (int y = r.low[1]; y <= r.high[1]; ++y) {
      const int row = (x * n_[1] + y) * n_[2];
      for (int z = r.low[2]; z <= r.high[2]; ++z) {
        visit(static_cast<std::size_t>(row + z));
      }
    }
  }
}

void SceneModel::index() {
  const auto sites =
      static_cast<std::size_t>(n_[0]) * static_cast<std::size_t>(n_[1]) * static_cast<std::size_t>(n_[2]);
  begin_.assign(sites + 2, 0);
  sole_.assign(sites, kNone);
  head_.resize(sites, -1);
  for (const Piece& piece : pieces_) {
    forSites(piece, [&](std::size_t site) {
      ++begin_[site + 1];
      sole_[site] = sole_[site] == kNone || sole_[site] == piece.object ? piece.object : kMany;
    });
  }
  for (std::size_t s = 0; s < sites; ++s) {
    begin_[s + 1] += begin_[s];
  }
  list_.resize(static_cast<std::size_t>(begin_[sites]));
  for (std::size_t i = pieces_.size(); i-- > 0;) {
    forSites(pieces_[i],
             [&](std::size_t site) { list_[static_cast<std::size_t>(--begin_[site + 1])] = static_cast<int>(i); });
  }
  // Filling walked each site's end back to its beginning: site s now begins at begin_[s + 1] and ends at begin_[s + 2].
  begin_[sites + 1] = static_cast<std::int32_t>(list_.size());
}

std::optional<SurfaceDistance> SceneModel::nearTo(const Piece& piece, const MergedPoint& point) const {
  const float slack = slackOf(point);
  const Eigen::Vector3f local = piece.R_solid_world * (Eigen::Vector3f(point.x, point.y, point.z) - piece.centre);
  if ((local.cwiseAbs() - piece.half).maxCoeff() > std::min(kLargestMargin, slack)) {
    return std::nullopt;
  }
  const SurfaceDistance near = solid_math::distance(piece.shape, piece.size, local);
  if (near.distance <= tolerance_) {
    return near;
  }
  const Eigen::Vector3f ray = piece.R_solid_world * Eigen::Vector3f(point.ux, point.uy, point.uz);
  const float margin = tolerance_ + sigmas_ * point.sigma * std::abs(ray.dot(near.normal));
  return near.distance <= std::min(kLargestMargin, margin) ? std::optional<SurfaceDistance>(near) : std::nullopt;
}

inline solid_math::Surface<Four> SceneModel::surfaceOf(const Piece& piece, const FourVectors& p) {
  const Eigen::Matrix3f& R = piece.R_solid_world;
  const FourVectors from{p.x - piece.centre.x(), p.y - piece.centre.y(), p.z - piece.centre.z()};
  const solid_math::Surface<Four> s = solid_math::distance(piece.shape, piece.size, times(R, from));
  return {s.distance, times(R.transpose(), s.normal)};
}

std::size_t SceneModel::nearestCandidate() const {
  std::size_t best = 0;
  for (std::size_t i = 1; i < candidates_.size(); ++i) {
    best = std::abs(candidates_[i].surface.distance) < std::abs(candidates_[best].surface.distance) ? i : best;
  }
  return best;
}

std::size_t SceneModel::firstMet(const MergedPoint& point) const {
  std::size_t best = candidates_.size();
  float first = std::numeric_limits<float>::infinity();
  const Eigen::Vector3f ray(point.ux, point.uy, point.uz);
  const Eigen::Vector3f start = Eigen::Vector3f(point.x, point.y, point.z) - kLookBack * ray;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const Piece& piece = pieces_[static_cast<std::size_t>(candidates_[i].piece)];
    const float entry =
        rayEntry(piece.shape, piece.size, piece.R_solid_world * (start - piece.centre), piece.R_solid_world * ray);
    if (entry < first && std::abs(entry - kLookBack) <= slackOf(point)) {
      first = entry;
      best = i;
    }
  }
  return best;
}

std::size_t SceneModel::likeliest(const MergedPoint& point) const {
  std::size_t best = 0;
  float least = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const SurfaceDistance& s = candidates_[i].surface;
    const Piece& piece = pieces_[static_cast<std::size_t>(candidates_[i].piece)];
    const float cosine = (piece.R_solid_world * Eigen::Vector3f(point.ux, point.uy, point.uz)).dot(s.normal);
    const float variance = point.sigma * point.sigma * cosine * cosine + tau2_;
    const float cost =
        s.distance * s.distance / variance + std::log(variance) + (cosine > kAwayCosine ? kHiddenFace : 0.F);
    if (cost < least) {
      least = cost;
      best = i;
    }
  }
  return best;
}

void SceneModel::bin(const std::vector<MergedPoint>& points) {
  next_.resize(points.size());
  taken_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int site = siteOf(points[i].x, points[i].y, points[i].z);
    std::int32_t& head = head_[static_cast<std::size_t>(site)];
    if (head < 0) {
      taken_.push_back(site);
    }
    next_[i] = head;
    head = static_cast<std::int32_t>(i);
  }
}

const std::vector<Explanation>& SceneModel::explain(const std::vector<MergedPoint>& points) {
  bin(points);
  explained_.assign(points.size(), {});
  for (const std::int32_t taken : taken_) {
    const auto site = static_cast<std::size_t>(taken);
    if (sole_[site] >= 0) {
      alike(site, points);
    } else if (sole_[site] == kMany) {
      for (std::int32_t i = head_[site]; i >= 0; i = next_[static_cast<std::size_t>(i)]) {
        explained_[static_cast<std::size_t>(i)] = among(site, points[static_cast<std::size_t>(i)]);
      }
    }
    head_[site] = -1;
  }
  return explained_;
}

void SceneModel::alike(std::size_t site, const std::vector<MergedPoint>& points) {
  for (std::int32_t i = head_[site]; i >= 0;) {
    std::size_t at[kLanes];
    int count = 0;
    for (; count < kLanes && i >= 0; i = next_[static_cast<std::size_t>(i)]) {
      at[count++] = static_cast<std::size_t>(i);
    }
    std::fill(at + count, at + kLanes, at[0]);
    const FourPoints four = pick(points, at);
    Four best = Four{} + std::numeric_limits<float>::infinity();  // distance without sign
    solid_math::Surface<Four> surface{};
    FourBits piece = FourBits{} + kNone;
    for (std::int32_t e = begin_[site + 1]; e < begin_[site + 2]; ++e) {
      const std::int32_t index = list_[static_cast<std::size_t>(e)];
      const solid_math::Surface<Four> s = surfaceOf(pieces_[static_cast<std::size_t>(index)], four.position);
      const Four cosine = solid_math::magnitude(solid_math::dot(four.ray, s.normal));
      const Four off = solid_math::magnitude(s.distance);
      const Four limit = solid_math::smaller(tolerance_ + sigmas_ * four.sigma * cosine, Four{} + kLargestMargin);
      const auto nearer = (s.distance <= limit) & (off < best);
      best = nearer ? off : best;
      surface.distance = nearer ? s.distance : surface.distance;
      surface.normal.x = nearer ? s.normal.x : surface.normal.x;
      surface.normal.y = nearer ? s.normal.y : surface.normal.y;
      surface.normal.z = nearer ? s.normal.z : surface.normal.z;
      piece = nearer ? FourBits{} + index : piece;
    }
    for (int k = 0; k < count; ++k) {
      if (piece[k] >= 0) {
        explained_[at[k]] = {piece[k],
                             sole_[site],
                             surface.distance[k],
                             {surface.normal.x[k], surface.normal.y[k], surface.normal.z[k]}};
      }
    }
  }
}

Explanation SceneModel::among(std::size_t site, const MergedPoint& point) {
  candidates_.clear();
  bool several = false;
  for (std::int32_t e = begin_[site + 1]; e < begin_[site + 2]; ++e) {
    const std::int32_t i = list_[static_cast<std::size_t>(e)];
    if (const auto surface = nearTo(pieces_[static_cast<std::size_t>(i)], point)) {
      candidates_.push_back({i, *surface});
      several = several || objectOf(i) != objectOf(candidates_.front().piece);
    }
  }
  if (candidates_.empty()) {
    return {};
  }
  std::size_t chosen = several ? firstMet(point) : nearestCandidate();
  chosen = chosen < candidates_.size() ? chosen : likeliest(point);
  const Candidate& best = candidates_[chosen];
  const Piece& piece = pieces_[static_cast<std::size_t>(best.piece)];
  return {best.piece, piece.object, best.surface.distance, piece.R_solid_world.transpose() * best.surface.normal};
}

Explanation SceneModel::nearest(const Eigen::Vector3f& point, const std::vector<char>& wanted, float reach) const {
  Explanation best;
  best.distance = reach;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    if (wanted[static_cast<std::size_t>(piece.object)] == 0) {
      continue;
    }
    const Eigen::Vector3f local = piece.R_solid_world * (point - piece.centre);
    if ((local.cwiseAbs() - piece.half).maxCoeff() >= best.distance) {
      continue;
    }
    const SurfaceDistance s = solid_math::distance(piece.shape, piece.size, local);
    if (s.distance < best.distance) {
      best = {static_cast<int>(i), piece.object, s.distance, piece.R_solid_world.transpose() * s.normal};
    }
  }
  return best;
}

float SceneModel::sigmasAbove(const MergedPoint& point, const Explanation& why) const {
  const float noise = point.sigma * std::abs(Eigen::Vector3f(point.ux, point.uy, point.uz).dot(why.normal));
  return why.distance / std::sqrt(noise * noise + tau2_);
}

void SceneModel::cellsInside(int index, std::vector<Eigen::Vector3f>& out) const {
  const Piece& piece = pieces_[static_cast<std::size_t>(index)];
  const GridSpec& grid = params_.grid;
  Eigen::Vector3f edge;
  int low[3];
  int high[3];
  for (int a = 0; a < 3; ++a) {
    edge[a] = static_cast<float>(grid.resolution(a));
    const int cells = grid.size[static_cast<std::size_t>(a)];
    low[a] = intWithin(std::ceil((piece.centre[a] - piece.extent[a] - low_[a]) / edge[a] - 0.5F), 0, cells);
    high[a] = intWithin(std::floor((piece.centre[a] + piece.extent[a] - low_[a]) / edge[a] - 0.5F), -1, cells - 1);
  }
  for (int x = low[0]; x <= high[0]; ++x) {
    for (int y = low[1]; y <= high[1]; ++y) {
      for (int z = low[2]; z <= high[2]; ++z) {
        const Eigen::Vector3f c =
            low_ + edge.cwiseProduct(Eigen::Vector3i(x, y, z).cast<float>() + Eigen::Vector3f::Constant(0.5F));
        const Eigen::Vector3f local = piece.R_solid_world * (c - piece.centre);
        if ((local.cwiseAbs() - piece.half).maxCoeff() < 0.F &&
            solid_math::distance(piece.shape, piece.size, local).distance < 0.F) {
          out.push_back(c);
        }
      }
    }
  }
}

}  // namespace yarm::perception
