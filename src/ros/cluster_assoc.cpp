#include "yarm/ros/cluster_assoc.hpp"

#include "yarm/ros/in_process.hpp"
#include "yarm/ros/side_object.hpp"

#include <algorithm>
#include <set>

namespace yarm {

namespace {

constexpr int kSetQueue = 32;
constexpr std::int64_t kStaleSeedsNs = 500'000'000;

perception::MergeParams mergeParamsOf(const ros::NodeHandle& handle, const std::string& node) {
  return loadParams<MergeCloudsParams>(ros::NodeHandle(handle, node)).mergeParams();
}

ros::TransportHints promptly() {
  return ros::TransportHints().tcpNoDelay();
}

}  // namespace

ClusterAssoc::ClusterAssoc(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle)
    : params_(loadParams<ClusterAssocParams>(private_handle)),
      handle_(handle),
      merge_(mergeParamsOf(handle, params_.merge_node)),
      backend_(perception::makeBackend(params_.backend, merge_, params_.cluster)),
      associator_(perception::makeAssociator(params_.association, params_.assoc)),
      tf_(TfSource::shared()),
      wait_ns_(static_cast<std::int64_t>((params_.sync ? kSyncWaitS : params_.seed_wait) * 1e9)),
      last_seed_ns_(steadyNow()),
      health_(handle, "cluster_assoc: inputs") {
  handle_.setCallbackQueue(&Executor::instance().queue());
  clusters_out_ = handle_.advertise<yarm::CloudVector>(names::CLOUD_CLUSTERS, 10);
  associated_out_ = handle_.advertise<yarm::AssociatedClusterVector>(names::ASSOCIATED_CLUSTERS, 10);
  registry_in_ = handle_.subscribe(names::OBJECT_REGISTRY, 10, &ClusterAssoc::onRegistry, this, promptly());
  switch_in_ = handle_.subscribe(names::STATIC_ASSOCIATION_SWITCH, 10, &ClusterAssoc::onSwitch, this, promptly());
  seeds_in_ = handle_.subscribe(names::SEED_TRANSFORMS, 50, &ClusterAssoc::onSeeds, this, promptly());
  points_in_ = handle_.subscribe(names::MERGED_POINTS, kSetQueue, &ClusterAssoc::onPoints, this, promptly());
  addInProcessReader(points_in_.getTopic());
  Executor::instance().add(*this);
}

ClusterAssoc::~ClusterAssoc() {
  removeInProcessReader(points_in_.getTopic());
  Executor::instance().remove(*this);
}

void ClusterAssoc::onPoints(const sensor_msgs::PointCloud2ConstPtr& message) {
  boost::shared_ptr<perception::MergedSet> set = sideOf<perception::MergedSet>(message);
  if (!set) {
    set = sets_.acquire();
    const Read<bool> read = readMergedPoints(*message, merge_, *set);
    if (!read.ok()) {
      warn_(names::MERGED_POINTS, points_in_.getTopic() + ": set dropped: " + read.reason);
      return;
    }
    backend_->voxelise(*set);
  }
  inbox_.push_back({set, steadyNow()});
}

void ClusterAssoc::onSeeds(const yarm::TransformStampedVectorConstPtr& message) {
  Read<std::vector<perception::Seed>> read = readSeeds(*message);
  if (!read.ok()) {
    warn_(names::SEED_TRANSFORMS, seeds_in_.getTopic() + ": seeds left out: " + read.reason);
  }
  seeds_.add(toNs(message->header.stamp), std::move(read.value));
  seeds_stalled_ = false;
  last_seed_ns_ = steadyNow();
}

void ClusterAssoc::onRegistry(const yarm::ObjectRegistryConstPtr& message) {
  Read<perception::Knowledge> read = readRegistry(*message);
  if (!read.ok()) {
    warn_(names::OBJECT_REGISTRY, registry_in_.getTopic() + ": shapes left out: " + read.reason);
  }
  knowledge_ = std::move(read.value);
  registered_ = true;
  std::set<std::string> frames;
  for (const auto& entry : knowledge_) {
    frames.insert(entry.second.link_frames.begin(), entry.second.link_frames.end());
    for (const perception::Solid& solid : entry.second.solids) {
      frames.insert(solid.frame);
    }
  }
  frames_.assign(frames.begin(), frames.end());
  links_stalled_ = false;
}

void ClusterAssoc::onSwitch(const std_msgs::Int8ConstPtr& message) {
  if (message->data != 0 && message->data != 1) {
    warn_(names::STATIC_ASSOCIATION_SWITCH,
          switch_in_.getTopic() + ": " + std::to_string(message->data) + " ignored; 0 is calibrating, 1 is running");
    return;
  }
  calibrating_ = message->data == 0;
}

void ClusterAssoc::poll() {
  while (!inbox_.empty() && ready(inbox_.front(), steadyNow())) {
    const Arrival arrival = std::move(inbox_.front());
    inbox_.pop_front();
    process(*arrival.set);
  }
  if (health_.due()) {
    diagnose();
  }
}

void ClusterAssoc::noticeRestart(perception::StampNs stamp_ns) {
  if (!sets_clock_.wentBack(stamp_ns)) {
    return;
  }
  ROS_WARN("cluster_assoc: time went back; starting afresh");
  associator_->reset();
  if (seeds_.newestNs() > stamp_ns + kStaleSeedsNs) {
    seeds_.clear();
  }
}

bool ClusterAssoc::ready(const Arrival& arrival, std::int64_t now_ns) {
  const perception::StampNs stamp_ns = arrival.set->stamp_ns;
  noticeRestart(stamp_ns);
  const bool waited = now_ns - arrival.arrived_ns >= wait_ns_;
  if (!seeds_.covers(stamp_ns) && !seeds_stalled_) {
    if (!waited) {
      return false;
    }
    seeds_stalled_ = true;
  }
  const bool linked = gatherLinks(stamp_ns);
  if (!linked && !links_stalled_ && !waited) {
    return false;
  }
  links_stalled_ = !linked;
  return true;
}

bool ClusterAssoc::gatherLinks(perception::StampNs stamp_ns) {
  bool complete = true;
  links_.clear();
  std::string reason;
  for (const std::string& frame : frames_) {
    auto pose = tf_->at(frame, stamp_ns, &reason);
    if (!pose) {
      complete = false;
      pose = tf_->newest(frame);
    }
    if (pose) {
      links_.emplace(frame, *pose);
    }
  }
  return complete;
}

void ClusterAssoc::process(perception::MergedSet& set) {
  const SeedLookup found = seeds_.lookup(set.stamp_ns);
  if (found.match != SeedMatch::exact) {
    ++with_newest_seeds_;
    worst_lag_s_ = std::max(worst_lag_s_, static_cast<double>(found.lag_ns) * 1e-9);
  }
  backend_->cluster(set);
  perception::AssociationInput input;
  input.set = &set;
  input.seeds = &found.seeds;
  input.knowledge = &knowledge_;
  input.links = &links_;
  input.calibrating = calibrating_;
  publishAssociated(associator_->associate(input));
  publishClusters(set);
  ++processed_;
}

void ClusterAssoc::publishClusters(const perception::MergedSet& set) {
  if (clusters_out_.getNumSubscribers() == 0) {
    return;
  }
  const auto message = boost::make_shared<yarm::CloudVector>();
  message->header.stamp = toTime(set.stamp_ns);
  message->header.frame_id = names::WORLD_FRAME;
  fillClusters(set, *message);
  clusters_out_.publish(message);
}

void ClusterAssoc::publishAssociated(const perception::AssociatedSet& set) {
  if (associated_out_.getNumSubscribers() == 0) {
    return;
  }
  auto message = std::make_unique<yarm::AssociatedClusterVector>();
  if (hasRemoteSubscribers(associated_out_)) {
    fillAssociated(set, params_.assoc.grid, *message);
  }
  const auto frame = frames_pool_.acquire();
  frame->set = set;
  frame->grid = params_.assoc.grid;
  associated_out_.publish(withSide(std::move(message), frame));
}

void ClusterAssoc::diagnose() {
  const double silent_s = static_cast<double>(steadyNow() - last_seed_ns_) * 1e-9;
  if (silent_s > 1.0) {
    health_.warn(seeds_in_.getTopic() + ": silent for " + std::to_string(silent_s) + " s");
  }
  if (with_newest_seeds_ > 0) {
    health_.warn(std::to_string(with_newest_seeds_) + " of " + std::to_string(processed_) +
                 " sets without seeds of their time; the newest were up to " + std::to_string(worst_lag_s_) +
                 " s older");
  }
  if (!registered_) {
    health_.warn(registry_in_.getTopic() + ": nothing heard yet");
  }
  if (links_stalled_) {
    health_.warn("no transform for every link of the registry at the capture time");
  }
  health_.value("sets", processed_);
  health_.value("calibrating", calibrating_ ? "yes" : "no");
  health_.value("seeds silent for, s", silent_s);
  health_.value("sets waiting", static_cast<double>(inbox_.size()));
  health_.send(std::to_string(processed_) + " sets");
  processed_ = 0;
  with_newest_seeds_ = 0;
  worst_lag_s_ = 0.0;
}

}  // namespace yarm
