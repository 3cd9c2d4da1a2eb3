#include "associators.hpp"

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace yarm::perception {

namespace {

using Points = std::vector<Eigen::Vector3f>;

/// A cloud and the seed's transform it was seen with.
struct View {
  Points points;
  Eigen::Isometry3d T_world_seed{Eigen::Isometry3d::Identity()};
  bool valid{false};
};

struct Memory {
  Seed seed;
  View initial;
  View recent;
  Points now;
  bool shared{false};  // `now` is a cluster kept aside for subtraction
};

/// The published algorithm, step by step, on voxel centroids and whole clusters; kept to be measured against.
class OriginalAssociator : public Associator {
 public:
  explicit OriginalAssociator(const AssociationParams& params) : radius_(static_cast<float>(params.search_radius)) {}

  const AssociatedSet& associate(const AssociationInput& input) override {
    set_ = input.set;
    seeds_ = input.seeds;
    forgetLeft();
    for (const Seed& seed : *seeds_) {
      if (seed.object == ObjectKind::kTarget) {
        memory_[seed.name].seed = seed;
      } else if (input.calibrating) {
        calibrate(seed);
      } else if (seed.is_static) {
        runStatic(seed);
      } else {
        runDynamic(seed);
      }
    }
    if (!input.calibrating) {
      subtract();
    }
    writeResult();
    return result_;
  }

  [[nodiscard]] const std::vector<TrackedObject>& tracks() const override { return none_; }

  void reset() override {
    memory_.clear();
    result_ = {};
  }

 private:
  [[nodiscard]] bool hits(const Eigen::Isometry3d& T_world_seed, const std::vector<std::int32_t>& cluster) const {
    const Eigen::Vector3f p = T_world_seed.translation().cast<float>();
    return std::any_of(cluster.begin(), cluster.end(), [&](std::int32_t v) {
      return (set_->centroids[static_cast<std::size_t>(v)] - p).squaredNorm() <= radius_ * radius_;
    });
  }

  /// The cluster a seed hits; of several the last, which is the smallest. -1 = none.
  [[nodiscard]] int clusterHit(const Seed& seed) const {
    int hit = -1;
    for (std::size_t c = 0; c < set_->clusters.size(); ++c) {
      hit = hits(seed.T_world_seed, set_->clusters[c]) ? static_cast<int>(c) : hit;
    }
    return hit;
  }

  [[nodiscard]] Points pointsOf(int cluster) const {
    Points points;
    for (const std::int32_t v : set_->clusters[static_cast<std::size_t>(cluster)]) {
      points.push_back(set_->centroids[static_cast<std::size_t>(v)]);
    }
    return points;
  }

  static Points carried(const View& view, const Eigen::Isometry3d& T_world_seed) {
    const Eigen::Isometry3f T = (T_world_seed * view.T_world_seed.inverse()).cast<float>();
    Points points;
    for (const Eigen::Vector3f& p : view.points) {
      points.push_back(T * p);
    }
    return points;
  }

  void calibrate(const Seed& seed) {
    Memory& m = memory_[seed.name];
    m.seed = seed;
    m.shared = false;
    const int cluster = clusterHit(seed);
    if (cluster >= 0) {
      m.now = pointsOf(cluster);
      m.initial = m.recent = {m.now, seed.T_world_seed, true};
    }
  }

  void runStatic(const Seed& seed) {
    Memory& m = memory_[seed.name];
    if (m.initial.valid) {
      m.now = carried(m.initial, m.seed.T_world_seed);
      return;
    }
    calibrate(seed);
  }

  void runDynamic(const Seed& seed) {
    Memory& m = memory_[seed.name];
    m.seed = seed;
    m.shared = false;
    const int cluster = clusterHit(seed);
    if (cluster < 0) {
      carry(m);
      return;
    }
    if (!sharedByOthers(seed, cluster)) {
      m.now = pointsOf(cluster);
      m.recent = {m.now, seed.T_world_seed, true};
      m.initial = m.initial.valid ? m.initial : m.recent;
    } else if (m.recent.valid || m.initial.valid) {
      carry(m);
    } else {
      m.now = pointsOf(cluster);
      m.shared = true;
    }
  }

  static void carry(Memory& m) {
    m.now.clear();
    if (m.recent.valid || m.initial.valid) {
      m.now = carried(m.recent.valid ? m.recent : m.initial, m.seed.T_world_seed);
    }
  }

  [[nodiscard]] bool sharedByOthers(const Seed& seed, int cluster) const {
    return std::any_of(seeds_->begin(), seeds_->end(), [&](const Seed& other) {
      return other.name != seed.name && hits(other.T_world_seed, set_->clusters[static_cast<std::size_t>(cluster)]);
    });
  }

  void subtract() {
    for (auto& [name, m] : memory_) {
      if (!m.shared) {
        continue;
      }
      for (const auto& [other_name, other] : memory_) {
        if (other_name != name) {
          dropNear(m.now, other.now);
        }
      }
      m.recent = m.initial = {m.now, m.seed.T_world_seed, true};
    }
  }

  void dropNear(Points& points, const Points& others) const {
    const auto near = [&](const Eigen::Vector3f& p) {
      return std::any_of(others.begin(), others.end(),
                         [&](const Eigen::Vector3f& q) { return (p - q).squaredNorm() <= radius_ * radius_; });
    };
    points.erase(std::remove_if(points.begin(), points.end(), near), points.end());
  }

  /// Dynamic objects no longer among the seeds are forgotten; static ones stay.
  void forgetLeft() {
    for (auto it = memory_.begin(); it != memory_.end();) {
      const bool present =
          std::any_of(seeds_->begin(), seeds_->end(), [&](const Seed& s) { return s.name == it->first; });
      it = present || it->second.seed.is_static ? std::next(it) : memory_.erase(it);
    }
  }

  void writeResult() {
    result_.stamp_ns = set_->stamp_ns;
    result_.objects.clear();
    for (const auto& [name, m] : memory_) {
      AssociatedObject out;
      out.name = name;
      out.object = m.seed.object;
      out.is_static = m.seed.is_static;
      out.T_world_seed = m.seed.T_world_seed;
      out.stamp_ns = m.seed.stamp_ns;
      out.points = m.now;
      result_.objects.push_back(std::move(out));
    }
  }

  float radius_;
  const MergedSet* set_{nullptr};
  const std::vector<Seed>* seeds_{nullptr};
  std::map<std::string, Memory> memory_;
  AssociatedSet result_;
  std::vector<TrackedObject> none_;
};

}  // namespace

std::unique_ptr<Associator> makeOriginalAssociator(const AssociationParams& params) {
  return std::make_unique<OriginalAssociator>(params);
}

}  // namespace yarm::perception
