// Workgroups of the kernels of scalars.
#pragma once

#include <cstdint>

namespace cvr::gpu {

inline constexpr std::uint32_t kScalarGroup = 256;  ///< invocations; CVR_GROUP in the kernels

inline std::uint32_t scalar_groups(std::uint64_t invocations) {
  return static_cast<std::uint32_t>((invocations + kScalarGroup - 1) / kScalarGroup);
}

}  // namespace cvr::gpu
