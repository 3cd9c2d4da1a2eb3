#include "yarm/ros/cluster_assoc.hpp"

#include "yarm/ros/in_process.hpp"
#include "yarm/ros/side_object.hpp"

#include <yarm/GripperState.h>

#include <algorithm>
#include <cstdio>
#include <set>

namespace yarm {

namespace {

constexpr int kSetQueue = 32;
// Seeds may be this far ahead of the clock; in lock-step it may lag many ticks behind what it times.
constexpr std::int64_t kMostAheadNs = 500'000'000;
constexpr std::int64_t kMostAheadInLockStepNs = 5'000'000'000;
constexpr std::int64_t kWatchEvery = 5;  // sets of which one is looked at for cameras that are off

MergeCloudsParams mergeParamsOf(const ros::NodeHandle& handle, const std::string& node) {
  return loadParams<MergeCloudsParams>(ros::NodeHandle(handle, node));
}

ros::TransportHints promptly() {
  return ros::TransportHints().tcpNoDelay();
}

}  // namespace

ClusterAssoc::ClusterAssoc(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle)
    : params_(loadParams<ClusterAssocParams>(private_handle)),
      handle_(handle),
      merge_node_(mergeParamsOf(handle, params_.merge_node)),
      merge_(merge_node_.mergeParams()),
      backend_(perception::makeBackend(params_.backend, merge_, params_.cluster)),
      associator_(perception::makeAssociator(params_.association, params_.assoc)),
      tf_(TfSource::shared()),
      wait_ns_(static_cast<std::int64_t>((params_.sync ? kSyncWaitS : params_.seed_wait) * 1e9)),
      seeds_(params_.sync ? kMostAheadInLockStepNs : kMostAheadNs),
      last_seed_ns_(steadyNow()),
      tracks_(handle_),
      health_(handle, "cluster_assoc: inputs"),
      camera_poses_(handle, "cluster_assoc: camera poses") {
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

void ClusterAssoc::onSeeds(const ros::MessageEvent<const yarm::TransformStampedVector>& event) {
  const yarm::TransformStampedVector& message = *event.getConstMessage();
  Read<std::vector<perception::Seed>> read = readSeeds(message);
  if (!read.ok()) {
    refuseSeeds(event.getPublisherName(), "left out: " + read.reason);
    if (read.value.empty()) {
      return;
    }
  }
  const std::string fault = seeds_.add(toNs(message.header.stamp), std::move(read.value), toNs(ros::Time::now()));
  if (!fault.empty()) {
    refuseSeeds(event.getPublisherName(), fault);
    return;
  }
  seeds_stalled_ = false;
  last_seed_ns_ = steadyNow();
}

void ClusterAssoc::refuseSeeds(const std::string& sender, const std::string& reason) {
  ++refused_seeds_;
  last_refusal_ = "from " + sender + ": " + reason;
  warn_(names::SEED_TRANSFORMS + sender, seeds_in_.getTopic() + ": seeds refused " + last_refusal_);
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
  listenToHands(*message);
}

void ClusterAssoc::listenToHands(const yarm::ObjectRegistry& registry) {
  std::map<std::string, std::shared_ptr<Hand>> heard;
  for (const yarm::RegisteredObject& entry : registry.entries) {
    if (entry.object != toString(perception::ObjectKind::kMobile) || heard.count(entry.name) > 0) {
      continue;
    }
    const std::string robot = entry.name;
    std::string fault;
    if (!ros::names::validate(names::grasping(robot), fault)) {
      warn_(names::OBJECT_REGISTRY + robot, registry_in_.getTopic() + ": no topic can be called after robot '" + robot +
                                                "', its hand is not listened to: " + fault);
      continue;
    }
    const auto old = hands_.find(robot);
    if (old != hands_.end()) {
      heard[robot] = old->second;
      continue;
    }
    const auto hand = std::make_shared<Hand>();
    const boost::function<void(const std_msgs::BoolConstPtr&)> plain =
        [words = &hand->words](const std_msgs::BoolConstPtr& word) { words->say(word->data != 0); };
    hand->plain_in = handle_.subscribe<std_msgs::Bool>(names::grasping(robot), 10, plain, {}, promptly());
    if (params_.sync) {
      const boost::function<void(const yarm::GripperStateConstPtr&)> stamped =
          [words = &hand->words](const yarm::GripperStateConstPtr& word) {
            words->say(toNs(word->header.stamp), word->grasping != 0);
          };
      hand->stamped_in = handle_.subscribe<yarm::GripperState>(names::gripperState(robot), 50, stamped, {}, promptly());
    }
    heard[robot] = hand;
  }
  hands_ = std::move(heard);
}

bool ClusterAssoc::handsKnown(perception::StampNs stamp_ns) const {
  return std::all_of(hands_.begin(), hands_.end(),
                     [stamp_ns](const auto& entry) { return entry.second->words.covers(stamp_ns); });
}

std::set<std::string> ClusterAssoc::graspingAt(perception::StampNs stamp_ns) {
  std::set<std::string> grasping;
  for (const auto& [robot, hand] : hands_) {
    if (hand->words.holdsAt(stamp_ns)) {
      grasping.insert(robot);
    }
  }
  return grasping;
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
  seeds_.noticeClock(toNs(ros::Time::now()));
  while (!inbox_.empty() && ready(inbox_.front(), steadyNow())) {
    const Arrival arrival = std::move(inbox_.front());
    inbox_.pop_front();
    process(*arrival.set);
  }
  if (health_.due()) {
    diagnose();
    diagnoseCameras();
  }
}

void ClusterAssoc::noticeRestart(perception::StampNs stamp_ns) {
  if (!sets_clock_.wentBack(stamp_ns)) {
    return;
  }
  ROS_WARN("cluster_assoc: time went back; starting afresh");
  associator_->reset();
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
  if (!handsKnown(stamp_ns) && !waited) {
    return false;
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
  for (const std::string& frame : frames_) {
    Read<Eigen::Isometry3d> pose = tf_->at(frame, stamp_ns);
    if (!pose.ok()) {
      complete = false;
      pose = tf_->newest(frame);
    }
    if (pose.ok()) {
      links_.emplace(frame, pose.value);
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
  const std::set<std::string> grasping = graspingAt(set.stamp_ns);
  input.grasping = &grasping;
  input.timely = found.match == SeedMatch::exact && !links_stalled_;
  publishAssociated(associator_->associate(input));
  tracks_.publish(set.stamp_ns, associator_->tracks());
  publishClusters(set);
  if (sets_seen_++ % kWatchEvery == 0) {
    watch_.add(input);
  }
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

void ClusterAssoc::diagnoseCameras() {
  for (const perception::CameraFit& fit : watch_.take()) {
    const auto index = static_cast<std::size_t>(fit.camera);
    const std::vector<std::string>& topics = merge_node_.camera_topics;
    const std::string name = index < topics.size() ? topics[index] : "camera " + std::to_string(fit.camera);
    camera_poses_.value(name + " turned by, deg", fit.turned_deg);
    camera_poses_.value(name + " off known static surfaces by, m (median)", fit.off_m);
    if (fit.turned_deg < params_.watch.warn_deg) {
      continue;
    }
    const bool bad = fit.turned_deg >= params_.watch.error_deg;
    char text[160];
    std::snprintf(text, sizeof(text),
                  ": is off: turned by %.2f deg its points fit the known static surfaces, at most %.2f deg; "
                  "check its mounting and its transform",
                  fit.turned_deg, bad ? params_.watch.error_deg : params_.watch.warn_deg);
    warn_("off " + name, name + text);
    if (bad) {
      camera_poses_.error(name + text);
    } else {
      camera_poses_.warn(name + text);
    }
  }
  camera_poses_.send("no camera is off");
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
  if (refused_seeds_ > 0) {
    health_.warn(seeds_in_.getTopic() + ": seeds refused " + std::to_string(refused_seeds_) + " times, last " +
                 last_refusal_);
  }
  if (!registered_) {
    health_.warn(registry_in_.getTopic() + ": nothing heard yet");
  }
  if (links_stalled_) {
    health_.warn("no transform for every link of the registry at the capture time");
  }
  health_.value("sets", processed_);
  health_.value("calibrating", calibrating_ ? "yes" : "no");
  health_.value("registered objects", static_cast<double>(knowledge_.size()));
  const auto held = std::count_if(hands_.begin(), hands_.end(), [](const auto& e) { return e.second->words.holds(); });
  health_.value("hands that hold something", static_cast<double>(held));
  health_.value("seeds silent for, s", silent_s);
  health_.value("sets waiting", static_cast<double>(inbox_.size()));
  health_.send(std::to_string(processed_) + " sets");
  processed_ = 0;
  with_newest_seeds_ = 0;
  refused_seeds_ = 0;
  worst_lag_s_ = 0.0;
}

}  // namespace yarm
