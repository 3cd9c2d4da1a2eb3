// A C++ object that travels with a message between nodelets of one process, so that the next stage need not build it
// again from the message. A message that came over the wire has none.
#pragma once

#include <boost/shared_ptr.hpp>
#include <boost/smart_ptr/shared_ptr.hpp>

#include <memory>

namespace yarm {

namespace detail {
template <class Message, class Side>
struct SideDeleter {
  boost::shared_ptr<Side> side;
  void operator()(const Message* message) const { delete message; }
};
}  // namespace detail

/// A message with the object that is to travel with it.
template <class Message, class Side>
boost::shared_ptr<Message> withSide(std::unique_ptr<Message> message, boost::shared_ptr<Side> side) {
  return boost::shared_ptr<Message>(message.release(), detail::SideDeleter<Message, Side>{std::move(side)});
}

/// The object that travels with the message; empty when there is none.
template <class Side, class Message>
boost::shared_ptr<Side> sideOf(const boost::shared_ptr<const Message>& message) {
  const auto* deleter = boost::get_deleter<detail::SideDeleter<Message, Side>>(message);
  return deleter != nullptr ? deleter->side : boost::shared_ptr<Side>();
}

}  // namespace yarm
