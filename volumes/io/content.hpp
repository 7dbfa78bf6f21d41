// What bytes look like, for errors about files whose name promises something else.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace cvr::volumes {

/// "an HDF5 file", "gzip data", "a PNG image", ... by the first bytes; else "text that begins
/// 'abc'" or "other bytes".
std::string describe_content(std::span<const std::byte> bytes);

}  // namespace cvr::volumes
