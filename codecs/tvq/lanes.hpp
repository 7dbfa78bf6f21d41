// Eight floats at once, in the vector extension that GCC and Clang share: one text for every
// machine, and the same sums whether it becomes AVX2, SSE2 or plain code, since each lane adds in
// its own order.
#pragma once

#include <cstdint>
#include <cstring>

namespace cvr::codecs::tvq {

inline constexpr unsigned kLanes = 8;
typedef float Lanes __attribute__((vector_size(kLanes * sizeof(float))));
typedef std::int32_t LaneIndices __attribute__((vector_size(kLanes * sizeof(std::int32_t))));

inline void load(Lanes& lanes, const float* from) { std::memcpy(&lanes, from, sizeof lanes); }

}  // namespace cvr::codecs::tvq
