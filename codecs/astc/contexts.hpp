// astcenc's contexts. One is expensive to make (partition tables of the block size), serves one
// thread at a time, and depends on edge and effort alone, so those that are not in use are kept for
// the next who asks: decoding single voxels could not be timed otherwise.
#pragma once

#include <memory>

struct astcenc_context;

namespace cvr::codecs::astc {

/// `effort` of kDecodeOnly: it cannot encode, and is smaller.
inline constexpr int kDecodeOnly = -1;

struct ContextKind {
  unsigned edge;  ///< of a block, 3..6
  int effort;     ///< of the encoder's search, 0..100 as astcenc counts it
  auto operator<=>(const ContextKind&) const = default;
};

struct GiveBack {
  ContextKind kind;
  void operator()(astcenc_context* context) const;
};
using Context = std::unique_ptr<astcenc_context, GiveBack>;

/// A context that nobody else uses until it is destroyed. Throws std::bad_alloc.
Context take_context(const ContextKind& kind);

}  // namespace cvr::codecs::astc
