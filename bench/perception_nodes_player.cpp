// Plays recorded camera sets at a fixed rate and measures how long perception takes to answer.
//   perception_nodes_player FILE SETS RATE_HZ
// FILE is written by bench/perception_nodes.py. Prints one line of JSON: for each set that is measured the ms from the
// publication of its last cloud to the arrival of its planning_metadata, null when none came.
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include "yarm/ros/names.hpp"

#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Int8.h>
#include <tf2_msgs/TFMessage.h>
#include <yarm/MapMetaData.h>
#include <yarm/ObjectRegistry.h>

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

struct RecordedSet {
  std::vector<sensor_msgs::PointCloud2> clouds;
  tf2_msgs::TFMessage frames;
};

struct SetTimes {
  Clock::time_point sent;
  Clock::time_point answered{};  // the epoch: never
};

struct Recording {
  tf2_msgs::TFMessage fixed_frames;
  yarm::ObjectRegistry registry;
  std::vector<RecordedSet> sets;
};

template <class Message>
Message readMessage(std::ifstream& file) {
  std::uint32_t size = 0;
  file.read(reinterpret_cast<char*>(&size), sizeof(size));
  std::vector<std::uint8_t> bytes(size);
  file.read(reinterpret_cast<char*>(bytes.data()), size);
  if (!file) {
    throw std::runtime_error("the recording ends too early");
  }
  ros::serialization::IStream stream(bytes.data(), size);
  Message message;
  ros::serialization::deserialize(stream, message);
  return message;
}

Recording readRecording(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::uint32_t counts[2] = {0, 0};
  file.read(reinterpret_cast<char*>(counts), sizeof(counts));
  Recording recording;
  recording.fixed_frames = readMessage<tf2_msgs::TFMessage>(file);
  recording.registry = readMessage<yarm::ObjectRegistry>(file);
  recording.sets.resize(counts[0]);
  for (RecordedSet& set : recording.sets) {
    set.frames = readMessage<tf2_msgs::TFMessage>(file);
    for (std::uint32_t camera = 0; camera < counts[1]; ++camera) {
      set.clouds.push_back(readMessage<sensor_msgs::PointCloud2>(file));
    }
  }
  return recording;
}

class Player {
 public:
  explicit Player(Recording recording) : recording_(std::move(recording)) {
    handle_.setCallbackQueue(&queue_);
    clock_ = handle_.advertise<rosgraph_msgs::Clock>("/clock", 10);
    tf_ = handle_.advertise<tf2_msgs::TFMessage>("/tf", 10);
    tf_static_ = handle_.advertise<tf2_msgs::TFMessage>("/tf_static", 1, true);
    registry_ = handle_.advertise<yarm::ObjectRegistry>(yarm::names::OBJECT_REGISTRY, 1, true);
    switch_ = handle_.advertise<std_msgs::Int8>(yarm::names::STATIC_ASSOCIATION_SWITCH, 1, true);
    for (std::size_t camera = 1; camera <= recording_.sets.at(0).clouds.size(); ++camera) {
      clouds_.push_back(
          handle_.advertise<sensor_msgs::PointCloud2>(yarm::names::cameraPoints(static_cast<int>(camera)), 10));
    }
    metadata_ = handle_.subscribe(yarm::names::PLANNING_METADATA, 100, &Player::onMetadata, this,
                                  ros::TransportHints().tcpNoDelay());
  }

  void waitForListeners() {
    tf_static_.publish(recording_.fixed_frames);
    registry_.publish(recording_.registry);
    const auto deadline = Clock::now() + std::chrono::seconds(30);
    const auto heard = [](const ros::Publisher& publisher) { return publisher.getNumSubscribers() > 0; };
    while (!std::all_of(clouds_.begin(), clouds_.end(), heard) || tf_.getNumSubscribers() < 2 ||
           metadata_.getNumPublishers() == 0) {
      if (Clock::now() > deadline) {
        throw std::runtime_error("perception did not come up within 30 s");
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  void play(std::size_t sets, double rate_hz) {
    std::thread receiver([this] {
      while (!done_) {
        queue_.callAvailable(ros::WallDuration(0.02));
      }
    });
    const std::chrono::duration<double> period(1.0 / rate_hz);
    const auto start = Clock::now();
    for (std::size_t k = 0; k < sets && ros::ok(); ++k) {
      std_msgs::Int8 running;
      running.data = k < kCalibrationSets ? 0 : 1;
      if (k == 0 || k == kCalibrationSets) {
        switch_.publish(running);
      }
      std::this_thread::sleep_until(start + std::chrono::duration_cast<Clock::duration>(period * k));
      publishTick(recording_.sets[order(k)], stampOf(2 * k, rate_hz));
      publishSet(recording_.sets[order(k)], stampOf(2 * k, rate_hz), k >= kCalibrationSets);
      std::this_thread::sleep_until(start + std::chrono::duration_cast<Clock::duration>(period * (k + 0.5)));
      publishTick(recording_.sets[order(k)], stampOf(2 * k + 1, rate_hz));
    }
    std::this_thread::sleep_for(std::chrono::seconds(2));
    done_ = true;
    receiver.join();
  }

  void report(double rate_hz) {
    std::printf("{\"rate_hz\": %.1f, \"out_of_order\": %d, \"each_ms\": [", rate_hz, out_of_order_);
    const char* separator = "";
    for (const auto& [stamp, times] : measured_) {
      if (times.answered == Clock::time_point{}) {
        std::printf("%snull", separator);
      } else {
        std::printf("%s%.2f", separator,
                    std::chrono::duration<double, std::milli>(times.answered - times.sent).count());
      }
      separator = ", ";
    }
    std::printf("]}\n");
  }

 private:
  static constexpr std::size_t kCalibrationSets = 30;

  // Forth and back through the recording, so that nothing jumps.
  std::size_t order(std::size_t k) const {
    const std::size_t last = recording_.sets.size() - 1;
    const std::size_t at = last == 0 ? 0 : k % (2 * last);
    return at <= last ? at : 2 * last - at;
  }

  static ros::Time stampOf(std::size_t tick, double rate_hz) {
    return ros::Time(100.0 + static_cast<double>(tick) / (2.0 * rate_hz));
  }

  void publishTick(RecordedSet& set, const ros::Time& stamp) {
    rosgraph_msgs::Clock clock;
    clock.clock = stamp;
    clock_.publish(clock);
    for (auto& transform : set.frames.transforms) {
      transform.header.stamp = stamp;
    }
    tf_.publish(set.frames);
  }

  void publishSet(RecordedSet& set, const ros::Time& stamp, bool measured) {
    for (std::size_t camera = 0; camera < clouds_.size(); ++camera) {
      set.clouds[camera].header.stamp = stamp;
      if (measured && camera + 1 == clouds_.size()) {
        const std::lock_guard<std::mutex> lock(mutex_);
        measured_[stamp.toNSec()].sent = Clock::now();
      }
      clouds_[camera].publish(set.clouds[camera]);
    }
  }

  void onMetadata(const yarm::MapMetaDataConstPtr& message) {
    const auto now = Clock::now();
    const std::uint64_t stamp = message->header.stamp.toNSec();
    const std::lock_guard<std::mutex> lock(mutex_);
    out_of_order_ += stamp <= newest_ ? 1 : 0;
    newest_ = std::max(newest_, stamp);
    const auto known = measured_.find(stamp);
    if (known != measured_.end() && known->second.answered == Clock::time_point{}) {
      known->second.answered = now;
    }
  }

  Recording recording_;
  ros::CallbackQueue queue_;
  ros::NodeHandle handle_;
  ros::Publisher clock_;
  ros::Publisher tf_;
  ros::Publisher tf_static_;
  ros::Publisher registry_;
  ros::Publisher switch_;
  std::vector<ros::Publisher> clouds_;
  ros::Subscriber metadata_;
  std::mutex mutex_;
  std::map<std::uint64_t, SetTimes> measured_;
  std::uint64_t newest_ = 0;
  int out_of_order_ = 0;
  std::atomic<bool> done_{false};
};

}  // namespace

int main(int argc, char** argv) {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
  ros::init(argc, argv, "perception_nodes_player");
  if (argc < 4) {
    std::fprintf(stderr, "usage: perception_nodes_player FILE SETS RATE_HZ\n");
    return 2;
  }
  try {
    Player player(readRecording(argv[1]));
    player.waitForListeners();
    player.play(std::stoul(argv[2]), std::stod(argv[3]));
    player.report(std::stod(argv[3]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "perception_nodes_player: %s\n", error.what());
    return 1;
  }
  return 0;
}
