// Objects that are used again instead of freed: their buffers stay mapped, so a cloud costs no page faults.
#pragma once

#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace yarm {

/// Hands out objects that come back by themselves when their last owner lets go. Thread-safe; owners may outlive it.
template <class T>
class Pool {
 public:
  explicit Pool(std::size_t keep = 32) : store_(boost::make_shared<Store>()) { store_->keep = keep; }

  /// An object in the state its last owner left it in, or a new one.
  boost::shared_ptr<T> acquire() const {
    std::unique_ptr<T> object = store_->take();
    auto store = store_;
    return boost::shared_ptr<T>(object.release(), [store](T* done) { store->give(std::unique_ptr<T>(done)); });
  }

 private:
  struct Store {
    std::unique_ptr<T> take() {
      const std::lock_guard<std::mutex> lock(mutex);
      if (free.empty()) {
        return std::make_unique<T>();
      }
      std::unique_ptr<T> object = std::move(free.back());
      free.pop_back();
      return object;
    }
    void give(std::unique_ptr<T> object) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (free.size() < keep) {
        free.push_back(std::move(object));
      }
    }
    std::mutex mutex;
    std::vector<std::unique_ptr<T>> free;
    std::size_t keep = 0;
  };

  boost::shared_ptr<Store> store_;
};

}  // namespace yarm
