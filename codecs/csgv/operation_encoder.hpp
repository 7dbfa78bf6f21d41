// The streaming encoder of formats whose bricks are groups of their own and store their operations
// one by one; and what these bricks have in common.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "codecs/csgv/encoder_strategy.hpp"
#include "codecs/csgv/operations.hpp"

namespace cvr::codecs::csgv {

/// The layout that the formats share: L level starts, then the palette size.
inline void append_level_starts(const OperationStream& operations,
                                std::vector<std::uint32_t>& words) {
  for (unsigned l = 0; l < operations.levels(); ++l) words.push_back(operations.level_start(l));
  words.push_back(static_cast<std::uint32_t>(operations.palette().size()));
}

/// The palette ends a brick, newest entry first: entry k is the k-th word from the end.
inline void append_palette(const OperationStream& operations, std::vector<std::uint32_t>& words) {
  words.insert(words.end(), operations.palette().rbegin(), operations.palette().rend());
}

/// Append: append(operations, words, bytes) appends a brick; each worker has a copy of its own,
/// which may hold tables and scratch memory.
template <class Append>
class OperationEncoder final : public StreamingEncoder {
 public:
  OperationEncoder(std::uint32_t brick, const OperationOptions& options, Append append = {})
      : brick_(brick), options_(options), append_(std::move(append)) {}
  std::unique_ptr<GroupPacker> packer() const override { return std::make_unique<Packer>(*this); }

 private:
  class Packer final : public GroupPacker {
   public:
    explicit Packer(const OperationEncoder& encoder)
        : operations_(encoder.brick_), options_(encoder.options_), append_(encoder.append_) {}
    void pack(SourceGroup& group, std::vector<std::uint32_t>& words,
              ByteBreakdown& bytes) override {
      while (const auto brick = group.next()) {
        operations_.encode(brick->grid, brick->validity, options_);
        append_(operations_, words, bytes);
      }
    }

   private:
    OperationStream operations_;
    OperationOptions options_;
    Append append_;
  };

  std::uint32_t brick_;
  OperationOptions options_;
  Append append_;
};

}  // namespace cvr::codecs::csgv
