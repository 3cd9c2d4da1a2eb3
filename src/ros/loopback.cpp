// Takes the place of the C library's bind() in our nodes: roscpp's XML-RPC server listens on every interface even where
// ROS_HOSTNAME says loopback (its topic connections do not), so that other machines could end a node or feed it
// (docs/security.md). The symbol of an executable comes before that of any library it loads.
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace {

/// Whether this node shall be reached from this machine only; the rule is roscpp's own for its topic connections.
bool loopbackOnly() {
  const char* host = std::getenv("ROS_HOSTNAME");
  if (host == nullptr) {
    host = std::getenv("ROS_IP");
  }
  return host != nullptr &&
         (std::strcmp(host, "localhost") == 0 || std::strcmp(host, "::1") == 0 || std::strncmp(host, "127.", 4) == 0);
}

int bindUnchanged(int socket, const void* address, socklen_t size) {
  return static_cast<int>(syscall(SYS_bind, socket, address, size));
}

}  // namespace

/// As bind(2), but what asks for every interface gets loopback where the node is meant for this machine.
extern "C" int bind(int socket, const sockaddr* address, socklen_t size) noexcept {
  if (address == nullptr || !loopbackOnly()) {
    return bindUnchanged(socket, address, size);
  }
  if (address->sa_family == AF_INET && size >= sizeof(sockaddr_in)) {
    sockaddr_in inside{};
    std::memcpy(&inside, address, sizeof(inside));
    if (inside.sin_addr.s_addr == htonl(INADDR_ANY)) {
      inside.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    }
    return bindUnchanged(socket, &inside, sizeof(inside));
  }
  if (address->sa_family == AF_INET6 && size >= sizeof(sockaddr_in6)) {
    sockaddr_in6 inside{};
    std::memcpy(&inside, address, sizeof(inside));
    if (std::memcmp(&inside.sin6_addr, &in6addr_any, sizeof(in6addr_any)) == 0) {
      inside.sin6_addr = in6addr_loopback;
    }
    return bindUnchanged(socket, &inside, sizeof(inside));
  }
  return bindUnchanged(socket, address, size);
}
