// The prelude of the shared decoder text: what GLSL and C++ name differently.
//
// Everything below shaders/shared is written in the common subset of GLSL 4.60 (with 64-bit integers and buffer references)
// and C++20. GLSL includes these files as they are; C++ includes them through shaders/shared/shared.hpp, inside the namespace
// cvr::shaders. Memory is read through Words: an address of 32-bit words, `words.w[i]` in both languages.
//
//   CVR_FUNC        before every function (inline in C++)
//   CVR_OUT(T)      an output parameter
//   CVR_INOUT(T)    a parameter that is read and written
//   uint, uint64_t  unsigned integers of 32 and 64 bits
#ifndef CVR_PORTABLE_GLSL
#define CVR_PORTABLE_GLSL

#ifdef __cplusplus

#define CVR_FUNC inline
#define CVR_OUT(T) T&
#define CVR_INOUT(T) T&

using uint = std::uint32_t;
using std::uint64_t;

struct Words {
  const std::uint32_t* w;
};

CVR_FUNC uint cvr_popcount(uint64_t bits) { return static_cast<uint>(std::popcount(bits)); }

#else

#define CVR_FUNC
#define CVR_OUT(T) out T
#define CVR_INOUT(T) inout T

layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Words { uint w[]; };

CVR_FUNC uint cvr_popcount(uint64_t bits) { return uint(bitCount(uint(bits)) + bitCount(uint(bits >> 32))); }

#endif

// The 64-bit word that starts at the 32-bit word `at`, low half first.
CVR_FUNC uint64_t cvr_word64(Words words, uint at) {
  return uint64_t(words.w[at]) | (uint64_t(words.w[at + 1u]) << 32);
}

#endif
