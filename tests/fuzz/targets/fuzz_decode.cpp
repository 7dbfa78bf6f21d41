// libFuzzer: an encoded file. The envelope's checksums are made right, so that every byte of the payload
// reaches its codec. Seeds: tests/golden/data. Run: fuzz_decode -max_len=8192 -rss_limit_mb=512 CORPUS
// tests/golden/data
#include <xxhash.h>

#include <cstring>
#include <vector>

#include "tests/fuzz/exercise.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::byte> file(size);
  if (size > 0) std::memcpy(file.data(), data, size);
  std::uint32_t header_size = 0;
  if (size >= 96) std::memcpy(&header_size, data + 12, 4);
  if (header_size >= 96 && header_size <= size) {
    const std::uint64_t payload_size = size - header_size;
    std::memcpy(file.data() + 16, &payload_size, 8);
    const std::uint64_t payload_hash = XXH3_64bits(file.data() + header_size, payload_size);
    std::memcpy(file.data() + 24, &payload_hash, 8);
    std::memset(file.data() + 32, 0, 8);
    const std::uint64_t header_hash = XXH3_64bits(file.data(), header_size);
    std::memcpy(file.data() + 32, &header_hash, 8);
  }
  cvr::fuzz::exercise_file(file);
  return 0;
}
