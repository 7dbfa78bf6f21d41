// Makes sizes and checksums of a damaged envelope right (offsets: codecs/container.hpp), so that
// the damage reaches the codec. Damage to the header's own fields remains.
#pragma once

#include <xxhash.h>

#include <cstdint>
#include <cstring>
#include <vector>

namespace cvr::fuzz {

inline void repair_envelope(std::vector<std::byte>& file) {
  std::uint32_t header_size = 0;
  if (file.size() < 96) return;
  std::memcpy(&header_size, file.data() + 12, 4);
  if (header_size > file.size() || header_size < 96) return;
  const std::uint64_t payload_size = file.size() - header_size;
  std::memcpy(file.data() + 16, &payload_size, 8);
  const std::uint64_t payload_hash = XXH3_64bits(file.data() + header_size, payload_size);
  std::memcpy(file.data() + 24, &payload_hash, 8);
  std::memset(file.data() + 32, 0, 8);
  const std::uint64_t header_hash = XXH3_64bits(file.data(), header_size);
  std::memcpy(file.data() + 32, &header_hash, 8);
}

}  // namespace cvr::fuzz
