// Copies of raw voxels that worker processes map and so share: CACHE/IDENTITY.raw with its sidecar,
// and IDENTITY.raw.hash, which says what both held when they were made.
//
// A copy is believed for what it holds, not for its name: each run hashes it before it is used, and
// makes it anew where voxels or sidecar are other than they were. A copy appears under its name
// when it is whole; of several processes that need it one makes it (CACHE/IDENTITY.lock) while the
// others wait.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>

#include "experiments/config/datasets.hpp"

namespace cvr::experiments {

struct RawCopy {
  std::string
      path;  ///< empty: streamed from the location, since the copy would take more than half of the free disk
  std::string content_hash;  ///< XXH3-64 of the voxels; empty if streamed
  std::uint64_t labels = 0;  ///< distinct labels; 0 if streamed or scalars
};

/// The user has asked for an end.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// Makes the copy unless it is there and sound. `interrupted` is asked between pieces of a few MiB.
/// Throws InputError where the volume cannot be read, OutputError where the copy cannot be written,
/// Interrupted.
RawCopy materialise(const Location& location, const Places& places, unsigned threads,
                    const std::function<bool()>& interrupted = {});

}  // namespace cvr::experiments
