#pragma once

#include <string>
#include <string_view>

namespace arbox::io::internal {

/// A MATLAB 5 file with its compressed variables unpacked, every size in it compared with the bytes
/// that are there. libmatio believes what such a file says of itself, so it sees these bytes and no
/// others. Variables of numbers, text, cells and structs pass.
///
/// Throws FormatError that begins with `name` for what is no such file, for sizes, counts and types
/// that do not fit each other, for files of big-endian machines, for objects, functions and sparse
/// matrices, and for variables that unpack to more than 64 times the file and 4 MiB.
std::string unpacked_mat(std::string_view file, const std::string& name);

}  // namespace arbox::io::internal
