#pragma once

#include <cstdint>
#include <string>

namespace arbox::training::internal {

/// The numerical address of this machine from which packets to `host` go out. Sends nothing. Throws
/// IoError for a name that cannot be resolved and a host that no route leads to.
std::string local_address(const std::string& host, std::uint16_t port);

}  // namespace arbox::training::internal
