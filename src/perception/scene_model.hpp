// The known solids of one set at their present poses, and which of them explains a point.
#pragma once

#include "solid_math.hpp"

#include "yarm/perception/association.hpp"
#include "yarm/perception/solids.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace yarm::perception {

/// Why a point is where it is: a surface it lies on within the sensor's noise.
struct Explanation {
  int piece{-1};                                     ///< index of the solid, -1 = none explains the point
  int object{-1};                                    ///< its object
  float distance{0};                                 ///< to the surface, metres, negative inside
  Eigen::Vector3f normal{Eigen::Vector3f::UnitZ()};  ///< outward, world
};

/// Known solids of all objects. Buffers are kept between sets.
class SceneModel {
 public:
  explicit SceneModel(const AssociationParams& params);

  /// Starts a new set.
  void clear();
  /// Adds a solid of an object at its present pose.
  void add(int object, const Solid& solid, const Eigen::Isometry3d& T_world_solid);
  /// Finishes a set: lists the solids near each part of the volume.
  void index();

  /// For each point the surface it lies on within its noise. Noise moves a point along its ray only: where several
  /// objects are near, it is the one whose solid the ray meets first. Valid until the next call.
  const std::vector<Explanation>& explain(const std::vector<MergedPoint>& points);
  /// The nearest solid of all whose object `wanted` marks, within `reach` metres.
  [[nodiscard]] Explanation nearest(const Eigen::Vector3f& point, const std::vector<char>& wanted, float reach) const;
  /// How far (in sigmas of its noise) a point is above the surface that explains it; for telling low things on a table.
  [[nodiscard]] float sigmasAbove(const MergedPoint& point, const Explanation& why) const;
  /// Appends the centres of the grid's cells that lie inside a solid.
  void cellsInside(int piece, std::vector<Eigen::Vector3f>& out) const;

  [[nodiscard]] int pieces() const { return static_cast<int>(pieces_.size()); }
  [[nodiscard]] int objectOf(int piece) const { return pieces_[static_cast<std::size_t>(piece)].object; }

 private:
  struct Piece {
    int object;
    Solid::Shape shape;
    Eigen::Vector3f size;
    Eigen::Vector3f half;
    Eigen::Matrix3f R_solid_world;
    Eigen::Vector3f centre;  // of the solid, world
    Eigen::Vector3f extent;  // half extents in the world's axes
  };
  /// A solid near a point, while it is being decided.
  struct Candidate {
    std::int32_t piece;
    SurfaceDistance surface;  // in the solid's frame
  };
  [[nodiscard]] float slackOf(const MergedPoint& point) const { return tolerance_ + sigmas_ * point.sigma; }
  /// Distances of four points to a solid, and normals in the world.
  [[nodiscard]] static solid_math::Surface<solid_math::Four> surfaceOf(const Piece& piece,
                                                                       const solid_math::FourVectors& p);
  /// The way to a solid's surface (its own frame); empty when it does not explain the point.
  [[nodiscard]] std::optional<SurfaceDistance> nearTo(const Piece& piece, const MergedPoint& point) const;
  /// Chains the points of each site, so that a site's solids are looked up once.
  void bin(const std::vector<MergedPoint>& points);
  /// Explains a point by the solids near its site, of several objects.
  [[nodiscard]] Explanation among(std::size_t site, const MergedPoint& point);
  /// Explains all points of a site by the nearest of its solids, which are one object's: four points at once.
  void alike(std::size_t site, const std::vector<MergedPoint>& points);
  [[nodiscard]] std::size_t nearestCandidate() const;
  [[nodiscard]] std::size_t firstMet(const MergedPoint& point) const;
  [[nodiscard]] std::size_t likeliest(const MergedPoint& point) const;
  struct Range {
    int low[3];
    int high[3];
  };
  [[nodiscard]] Range sitesOf(const Piece& piece) const;
  [[nodiscard]] int siteOf(float x, float y, float z) const;
  template <typename Visit>
  void forSites(const Piece& piece, Visit visit) const;

  AssociationParams params_;
  float tolerance_;
  float sigmas_;
  float tau2_;
  Eigen::Vector3f low_;
  int n_[3]{};
  std::vector<Piece> pieces_;
  std::vector<std::int32_t> begin_;  // begin_[s + 1] = first entry of site s in list_, begin_[s + 2] = its end
  std::vector<std::int32_t> list_;   // solids near each site
  std::vector<std::int32_t> sole_;   // the one object near each site, or kMany
  std::vector<std::int32_t> head_;   // first point of each site, -1 = none, as it is between calls
  std::vector<std::int32_t> next_;   // next point in the same site
  std::vector<std::int32_t> taken_;  // sites with points
  std::vector<Candidate> candidates_;
  std::vector<Explanation> explained_;  // of each point
};

}  // namespace yarm::perception
