#include "arbox/training/internal/local_address.h"

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

#include "arbox/base/error.h"

namespace arbox::training::internal {
namespace {

/// The address that a UDP socket gets when it is connected; empty with errno on failure.
std::string address_towards(const addrinfo& target) {
  const int handle = ::socket(target.ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (handle < 0) return {};
  sockaddr_storage own{};
  socklen_t length = sizeof own;
  std::array<char, 128> text{};
  const bool found = ::connect(handle, target.ai_addr, target.ai_addrlen) == 0 &&
                     ::getsockname(handle, reinterpret_cast<sockaddr*>(&own), &length) == 0 &&
                     ::getnameinfo(reinterpret_cast<sockaddr*>(&own), length, text.data(),
                                   text.size(), nullptr, 0, NI_NUMERICHOST) == 0;
  const int reason = errno;
  ::close(handle);
  errno = reason;
  return found ? text.data() : "";
}

}  // namespace

std::string local_address(const std::string& host, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* list = nullptr;
  const int failure = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &list);
  if (failure != 0) throw IoError("host '" + host + "': " + ::gai_strerror(failure));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(list, &::freeaddrinfo);
  for (const addrinfo* target = list; target != nullptr; target = target->ai_next) {
    const std::string address = address_towards(*target);
    if (!address.empty()) return address;
  }
  throw IoError("host '" + host + "' cannot be reached: " + std::strerror(errno));
}

}  // namespace arbox::training::internal
