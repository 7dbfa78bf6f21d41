// The prelude of the shared decoder text: what GLSL and C++ name differently.
//
// Everything below shaders/shared is written in the common subset of GLSL 4.60 (with 64-bit
// integers and buffer references) and C++20. GLSL includes these files as they are; C++ includes
// them through shaders/shared/shared.hpp, inside the namespace cvr::shaders. Memory is an address
// of 32-bit words and is read through functions, so that one text serves every memory:
//
//   Words   what a decoder reads: device memory; where CVR_WORDS_SHARED is defined, the array `uint cvr_shared[]` that the
//           kernel has declared before this text, from word `base` on
//   Global  always device memory; the same type as Words where nothing is shared
//   Labels  an array of label codes in device memory that is written and read
//
//   CVR_FUNC        before every function (inline in C++)
//   CVR_UNROLL      before a loop of constant length: some drivers bound the iterations of all loops of an invocation
//   CVR_OUT(T)      an output parameter
//   CVR_INOUT(T)    a parameter that is read and written
//   uint, uint64_t  unsigned integers of 32 and 64 bits
#ifndef CVR_PORTABLE_GLSL
#define CVR_PORTABLE_GLSL

#ifdef __cplusplus

#define CVR_FUNC inline
#define CVR_UNROLL
#define CVR_OUT(T) T&
#define CVR_INOUT(T) T&
#define CVR_TOUCH_WORD()

using uint = std::uint32_t;
using std::uint64_t;

struct Words {
  const std::uint32_t* w;
};
using Global = Words;

struct Labels {
  std::uint32_t* w;
};

CVR_FUNC uint cvr_popcount(uint64_t bits) { return static_cast<uint>(std::popcount(bits)); }
CVR_FUNC uint cvr_popcount32(uint bits) { return static_cast<uint>(std::popcount(bits)); }
CVR_FUNC uint cvr_highest_bit(uint bits) { return static_cast<uint>(std::bit_width(bits)) - 1u; }

#else

#define CVR_FUNC
#define CVR_UNROLL [[unroll]]
#define CVR_OUT(T) out T
#define CVR_INOUT(T) inout T

layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Global { uint w[]; };
layout(buffer_reference, std430, buffer_reference_align = 4) buffer Labels { uint w[]; };

#ifndef CVR_TOUCH_WORD
#define CVR_TOUCH_WORD()  // counts words read from device memory
#endif

#ifdef CVR_WORDS_SHARED
struct Words {
  uint base;
};
CVR_FUNC uint cvr_read(Words words, uint i) { return cvr_shared[words.base + i]; }
#else
#define Words Global
#endif

CVR_FUNC uint cvr_popcount32(uint bits) { return uint(bitCount(bits)); }
CVR_FUNC uint cvr_popcount(uint64_t bits) {
  return uint(bitCount(uint(bits)) + bitCount(uint(bits >> 32)));
}
CVR_FUNC uint cvr_highest_bit(uint bits) { return uint(findMSB(bits)); }

#endif

#ifndef CVR_WORDS_SHARED
CVR_FUNC uint cvr_read(Words words, uint i) {
  CVR_TOUCH_WORD();
  return words.w[i];
}
#endif
CVR_FUNC uint cvr_read_global(Global words, uint i) {
  CVR_TOUCH_WORD();
  return words.w[i];
}
CVR_FUNC uint cvr_load(Labels labels, uint i) { return labels.w[i]; }
CVR_FUNC void cvr_store(Labels labels, uint i, uint value) { labels.w[i] = value; }

// The 64-bit word that starts at the 32-bit word `at`, low half first.
CVR_FUNC uint64_t cvr_word64(Words words, uint at) {
  return uint64_t(cvr_read(words, at)) | (uint64_t(cvr_read(words, at + 1u)) << 32);
}

CVR_FUNC uint64_t cvr_word64_global(Global words, uint at) {
  return uint64_t(cvr_read_global(words, at)) | (uint64_t(cvr_read_global(words, at + 1u)) << 32);
}

#endif
