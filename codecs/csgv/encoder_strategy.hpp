// How bricks of the CSGV kind become words. A format has one of three strategies:
//   streaming   groups become words one after the other; no tables
//   sampled     some bricks are counted, tables fitted to the counts, then groups are streamed
//   two-pass    all bricks are kept, tables fitted to all of them, then groups are written
// The frame (brick_encoder.cpp) finds the bricks and has the threads: `worker` is below the number
// of threads that the strategy was made for, and each worker is used by one thread at a time.
// Which worker is shown which bricks, and in which order, must not show in the result. A fitted
// object is new and never changes; fit() comes last and may take what was counted or kept along.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "codecs/codec.hpp"
#include "codecs/csgv/label_grid.hpp"

namespace cvr::codecs::csgv {

/// A brick of the volume that is encoded. The nodes outside the volume are filled where the
/// format's operations keep them.
struct SourceBrick {
  const LabelGrid& grid;
  const Validity& validity;
};

/// Hands out the bricks of a group, x fastest.
class SourceGroup {
 public:
  virtual ~SourceGroup() = default;
  /// The next brick, until the next call; nothing after the last.
  virtual std::optional<SourceBrick> next() = 0;
};

/// Packs groups for one worker, with scratch memory of its own.
class GroupPacker {
 public:
  virtual ~GroupPacker() = default;
  /// Appends a group to `words`, which hold earlier ones.
  virtual void pack(SourceGroup& group, std::vector<std::uint32_t>& words,
                    ByteBreakdown& bytes) = 0;
};

class StreamingEncoder {
 public:
  virtual ~StreamingEncoder() = default;
  /// A packer for one more worker; the encoder outlives it.
  virtual std::unique_ptr<GroupPacker> packer() const = 0;
};

/// What makes the groups' words, and the bytes of the tables that their reader is made from.
template <class Result>
struct Fitted {
  Buffer tables;
  std::unique_ptr<const Result> result;
};

/// Which bricks are counted: every `stride`-th an axis, halved while fewer than `few` are seen,
/// doubled while more than `most` are.
struct Sampling {
  unsigned stride;
  std::uint64_t few = 0, most = ~std::uint64_t{0};
};

class SampledEncoder {
 public:
  virtual ~SampledEncoder() = default;
  virtual Sampling sampling() const = 0;
  virtual void count(unsigned worker, const SourceBrick& brick) = 0;
  virtual Fitted<StreamingEncoder> fit() && = 0;
};

/// A group that has been kept: by which worker, and as which of its groups.
struct KeptGroup {
  unsigned worker;
  std::size_t number;
};

/// Writes kept groups for one worker, with scratch memory of its own.
class GroupWriter {
 public:
  virtual ~GroupWriter() = default;
  /// Appends a group to `words`, which hold earlier ones.
  virtual void write(const KeptGroup& group, std::vector<std::uint32_t>& words,
                     ByteBreakdown& bytes) = 0;
};

/// All groups of a volume, with the tables that were fitted to them.
class KeptVolume {
 public:
  virtual ~KeptVolume() = default;
  /// A writer for one more worker; the volume outlives it.
  virtual std::unique_ptr<GroupWriter> writer() const = 0;
};

class TwoPassEncoder {
 public:
  virtual ~TwoPassEncoder() = default;
  virtual KeptGroup keep(unsigned worker, SourceGroup& group) = 0;
  virtual Fitted<KeptVolume> fit() && = 0;
};

using EncoderStrategy =
    std::variant<std::unique_ptr<const StreamingEncoder>, std::unique_ptr<SampledEncoder>,
                 std::unique_ptr<TwoPassEncoder>>;

}  // namespace cvr::codecs::csgv
