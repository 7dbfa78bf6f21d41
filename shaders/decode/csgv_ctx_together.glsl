// Bricks of `csgv-ctx` by subgroups: the stream has one reader, so all invocations read it alike;
// what a symbol's context is made of is found by one invocation for each of the eight children, and
// labels are stored by all. Only the first 32 invocations take part.
#include "shaders/shared/brick_limits.glsl"
#include "shaders/shared/csgv_ctx.glsl"
#include "shaders/shared/morton.glsl"
#include "shaders/shared/operations.glsl"
#include "shaders/shared/portable.glsl"

// What one invocation has stored the others may read.
void cvr_ctx_meet() {
  subgroupMemoryBarrierBuffer();
  subgroupBarrier();
}

// Hands the labels of stopped nodes down and links the open ones; gives the first of these.
uint cvr_ctx_link(Labels labels, CtxLevel level) {
  uint lane = gl_SubgroupInvocationID;
  uint lanes = min(gl_SubgroupSize, 32u);
  uint open = level.parents;
  for (uint end = (level.parents + lanes - 1u) / lanes; end > 0u; --end) {
    uint first = (end - 1u) * lanes;
    uint n = first + lane;
    bool counts = lane < lanes && n < level.parents;
    bool is_open = false;
    if (counts) is_open = cvr_ctx_is_open(labels, level, n);
    uint all = subgroupBallot(is_open).x;
    uint later = all & ~((2u << lane) - 1u);
    if (is_open)
      cvr_store(labels, (n << (level.shift + 3u)) + 1u,
                later != 0u ? first + uint(findLSB(later)) : open);
    else if (counts)
      cvr_ctx_hand_down(labels, level, n);
    if (all != 0u) open = first + uint(findLSB(all));
  }
  return open;
}

// As cvr_ctx_block, but all children at once as far as they do not wait for each other.
void cvr_ctx_block_together(Words words, Global volume_labels, Global tables, CtxDecoding d,
                            Labels labels, CtxLevel level, uint n, uint parent,
                            inout CtxPalette palette, inout CtxStream stream) {
  uint c = gl_SubgroupInvocationID & 7u;
  CtxChild mine;
  mine.none = 0u;
  CVR_UNROLL for (uint a = 0u; a < 3u; ++a) {
    bool exists;
    uint above = cvr_ctx_above(labels, level, n, a, parent, exists);
    uint beside = cvr_ctx_near(labels, level, 8u * n + (c & ~(1u << a)), a, parent);
    bool high = ((c >> a) & 1u) == 1u;
    mine.candidates[a] = high ? above : beside;
    mine.across[a] = high ? beside : above;
    mine.none |= (high ? !exists : (n & (CVR_MORTON_X << a)) == 0u) ? 1u << a : 0u;
  }
  uint static_bits = cvr_ctx_static_bits(mine, c, parent, level.depth);
  uint label = parent;
  uint stop = 0u;
  CtxSiblings siblings;
  siblings.other = 0u;
  siblings.newest = 0u;
  CVR_UNROLL for (uint k = 0u; k < 8u; ++k) {
    if (cvr_serial_is_inside(level.limits, 8u * n + k)) {
      uint dynamic_bits = cvr_ctx_dynamic_bits(mine, c, parent, siblings, palette, d.brick.labels);
      uint distribution =
          subgroupBroadcast(cvr_ctx_distribution(tables, d.tables, static_bits, dynamic_bits), k);
      uint symbol = cvr_ctx_symbol(words, tables, d.tables, distribution, stream);
      uint decoded = subgroupBroadcast(cvr_ctx_copied(mine, symbol & 7u, parent), k);
      if ((symbol & 7u) >= CVR_OP_ADVANCE)
        decoded =
            cvr_ctx_from_palette(words, volume_labels, tables, d, symbol & 7u, palette, stream);
      if (decoded != parent) {
        siblings.other |= 1u << k;
        siblings.newest = decoded;
      }
      label = c == k ? decoded : label;
      stop = c == k ? symbol >> 3 : stop;
    }
  }
  cvr_ctx_meet();  // all have read what is now written over
  if (gl_SubgroupInvocationID < 8u) cvr_ctx_put(labels, level, 8u * n + c, label, stop);
  cvr_ctx_meet();
}

// As cvr_ctx_decode.
void cvr_decode_brick_together(uvec3 brick, uint lod, Labels labels) {
  CtxPlace place = cvr_ctx_place(brick);
  CtxDecoding d = cvr_ctx_decoding(place, brick, lod);
  CtxPalette palette;
  palette.last = cvr_ctx_label(place.words, CVR_BUFFER(2), d, 0u);
  palette.in_use = 1u;
  if (gl_SubgroupInvocationID == 0u) {
    cvr_store(labels, 0u, palette.last);
    if (d.target > 0u) cvr_store(labels, 1u, d.brick.labels == 1u ? 1u : 0u);
  }
  cvr_ctx_meet();
  CtxStream stream = cvr_ctx_begin(place.words, d.brick.stream_at, d.brick.bytes);
  for (uint l = 1u; l <= d.target; ++l) {
    CtxLevel level = cvr_ctx_level(d, l);
    uint n = cvr_ctx_link(labels, level);
    cvr_ctx_meet();
    while (n < level.parents) {
      uint at = n << (level.shift + 3u);
      uint next = cvr_load(labels, at + 1u);
      cvr_ctx_block_together(place.words, CVR_BUFFER(2), CVR_BUFFER(3), d, labels, level, n,
                             cvr_load(labels, at), palette, stream);
      n = next;
    }
  }
}
