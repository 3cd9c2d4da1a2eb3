// A perception node as a nodelet: the same class as the standalone node's.
#pragma once

#include "yarm/ros/executor.hpp"

#include <nodelet/nodelet.h>

#include <memory>

namespace yarm {

/// Holds a node that lives on the process's executor, under the nodelet's name.
template <class Node>
class NodeletOf : public nodelet::Nodelet {
 public:
  ~NodeletOf() override {
    const auto paused = Executor::instance().pause();
    node_.reset();
  }

 private:
  void onInit() override {
    keepBuffers();
    const auto paused = Executor::instance().pause();
    node_ = std::make_unique<Node>(getNodeHandle(), getPrivateNodeHandle());
  }

  std::unique_ptr<Node> node_;
};

}  // namespace yarm
