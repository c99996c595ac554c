#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// \file
/// The LZF compression of PCD's binary_compressed, in Marc Lehmann's stream format: a control byte
/// below 32 copies that many + 1 bytes; others repeat 3 to 264 bytes from at most 8192 back.

namespace arbox::io::internal {

/// The most bytes that one byte of a stream can stand for.
inline constexpr std::size_t kLzfHighestRatio = 88;

/// Decompresses into exactly `size` bytes at `to`; false if the stream is damaged or gives another
/// number of bytes. Never reads or writes outside of its memory.
bool lzf_decompress(std::string_view stream, char* to, std::size_t size);

/// Never fails; data without repetition grows by a 32nd.
std::string lzf_compress(std::string_view data);

}  // namespace arbox::io::internal
