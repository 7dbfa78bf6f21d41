// Voxels written as hexadecimal digits or as decimal numbers, the encodings `hex` and `ascii` of
// NRRD.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "volumes/io/format.hpp"

namespace cvr::volumes {

/// Throws InputError if `characters` cannot hold two digits for each of `bytes` bytes, so that
/// nothing is allocated for them.
void check_digits(const std::string& file, std::uint64_t characters, std::uint64_t bytes);
/// The same for `numbers` numbers of at least one digit with something between them.
void check_numbers(const std::string& file, std::uint64_t characters, std::uint64_t numbers);

/// Two digits for each byte of `out`, with any white space between digits, and nothing else. Throws
/// InputError.
void read_hex_voxels(const std::string& file, std::string_view text, std::span<std::byte> out);

/// Numbers separated by white space, as many as fit into `out`, and nothing else, in native byte
/// order. Throws InputError with the number's position for what the type does not hold.
void read_text_voxels(const std::string& file, std::string_view text, const StoredType& type,
                      std::span<std::byte> out);

}  // namespace cvr::volumes
