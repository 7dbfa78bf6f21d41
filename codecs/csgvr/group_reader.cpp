#include "codecs/csgvr/group_reader.hpp"

#include <algorithm>

#include "codecs/csgvr/block_code.hpp"

namespace cvr::codecs::csgvr {

using csgv::BrickError;
using shaders::CsgvrcBrick;
using shaders::CsgvrcRuns;

namespace {

/// Words that the header of a group or brick may take behind its begin, whatever its fields say,
/// and the longest block.
constexpr std::size_t kHeaderWords = 160;
constexpr unsigned kMostPositionBits = 24;
constexpr std::uint64_t kMaskReadBits = 56;  ///< behind the last mask: masks are read by 8 bytes

}  // namespace

BrickError GroupCheck::run(std::span<const std::uint32_t> group, std::uint32_t members,
                           unsigned levels) {
  if (group.size() < 2) return "the group is shorter than its header";
  words_.assign(group.begin(), group.end());
  words_.resize(group.size() + kHeaderWords);
  group_ = {words_.data()};
  limit_ = 32 * (group.size() - 1);  // every read takes the word behind too
  const CsgvrcBrick head = shaders::cvr_c_open_group(group_, levels);
  if (head.index_bits == 0)
    return head.dictionary + head.label_bits <= limit_ ? nullptr
                                                       : "the group is shorter than its label";
  if (BrickError error = check_table(members, levels)) return error;
  for (std::uint32_t member = 0; member < members; ++member) {
    if (BrickError error = check_brick(member, levels)) return error;
  }
  return nullptr;
}

/// The bricks' ends: ascending, and within the group.
BrickError GroupCheck::check_table(std::uint32_t members, unsigned levels) {
  const CsgvrcBrick head = shaders::cvr_c_open_group(group_, levels);
  std::uint32_t at = head.begin;
  if (head.members != members)
    return "the group has more or fewer bricks than its place in the volume";
  std::uint32_t bricks = 0;
  for (std::uint32_t i = 0; i < members; ++i) bricks += cvr_c_take(group_, at, 1) ^ 1;
  const std::uint64_t dictionary = at + std::uint64_t{bricks} * head.end_bits +
                                   std::uint64_t{members - bricks} * head.index_bits;
  const std::uint64_t streams =
      (dictionary + std::uint64_t{head.dictionary_size} * head.label_bits + 7) / 8 * 8;
  if (streams > limit_ + 7) return "the group is shorter than its header";
  std::uint64_t before = 0;
  for (std::uint32_t i = 0; i < bricks; ++i) {
    const std::uint64_t end = cvr_c_take(group_, at, head.end_bits);
    if (end < before || streams + end > limit_)
      return "a brick ends before it begins, or behind its group";
    before = end;
  }
  return nullptr;
}

BrickError GroupCheck::check_header(const CsgvrcBrick& brick) const {
  if (brick.coarse_blocks == 0 ||
      brick.coarse_blocks > csgv::nodes_before_level(brick.levels - 2)) {
    return "the coarse blocks are none, or too many";
  }
  if (brick.fine_blocks > csgv::nodes_of_level(brick.levels - 2))
    return "the fine blocks are too many";
  if (std::max({brick.position_bits, brick.runs[0].sample_bits, brick.runs[1].sample_bits}) >
      kMostPositionBits) {
    return "the samples are wider than any position";
  }
  if (brick.runs[0].first > brick.end || brick.runs[1].first > brick.end)
    return "the runs begin behind their brick";
  if (brick.runs[0].samples + kMaskReadBits > limit_ + 32)
    return "the group ends too soon behind the masks of a brick";
  return nullptr;
}

BrickError GroupCheck::check_brick(std::uint32_t member, unsigned levels) {
  CsgvrcBrick brick = shaders::cvr_c_find(group_, member, levels);
  if (!brick.constant) {
    shaders::cvr_c_open_brick(group_, brick);
    if (BrickError error = check_header(brick)) return error;
  }
  if (brick.root >= brick.dictionary_size) return "the coarsest label leaves the dictionary";
  if (brick.constant) return nullptr;
  if (BrickError error = check_masks(brick)) return error;
  if (BrickError error = check_runs(brick, false)) return error;
  return check_runs(brick, true);
}

/// Each level has a block for each open node of the level before; the counts between the masks are
/// right.
BrickError GroupCheck::check_masks(const CsgvrcBrick& brick) const {
  std::uint32_t number = 0;
  std::uint32_t opened = 0;
  std::uint32_t blocks = 1;  // of the level
  for (unsigned level = 1; level + 1 < brick.levels; ++level) {
    if (blocks > brick.coarse_blocks - number)
      return "there are more open nodes than coarse blocks";
    const std::uint32_t before = opened;
    for (const std::uint32_t end = number + blocks; number < end; ++number) {
      const std::uint32_t record = brick.masks + number / CVR_C_MASKS * CVR_C_MASKS_BITS;
      if (number > 0 && number % CVR_C_MASKS == 0 &&
          cvr_c_bits(group_, record - CVR_C_COUNT_BITS, CVR_C_COUNT_BITS) != opened) {
        return "the open nodes before a mask are miscounted";
      }
      opened += shaders::cvr_popcount32(cvr_c_mask(group_, brick, number));
    }
    blocks = opened - before;
  }
  if (number != brick.coarse_blocks) return "there are fewer open nodes than coarse blocks";
  return blocks == brick.fine_blocks ? nullptr
                                     : "the fine blocks are not as many as the open nodes";
}

/// Every run is filled by codes of operations and by labels of the dictionary, and ends where the
/// next begins.
BrickError GroupCheck::check_runs(const CsgvrcBrick& brick, bool fine) const {
  const CsgvrcRuns& runs = brick.runs[fine ? 1 : 0];
  const std::uint32_t blocks = fine ? brick.fine_blocks : brick.coarse_blocks;
  std::uint32_t at = runs.first;
  for (std::uint32_t k = 0; k < blocks;) {
    const std::uint32_t end = cvr_c_run_end(group_, runs, k / CVR_C_RUN);
    if (end < at || end > runs.end) return "a run leaves its brick";
    std::uint32_t own = 0;
    for (const std::uint32_t run_end = std::min(blocks, k + CVR_C_RUN); k < run_end; ++k) {
      const BlockOperations operations = cvr_c_operations(group_, tables_, fine, at);
      if (at > end) return "the codes of a run are longer than the run";
      if (!valid_operations(operations)) return "an unknown operation";
      own += shaders::cvr_popcount32(shaders::cvr_c_own_labels(operations));
    }
    if (at + std::uint64_t{own} * brick.index_bits != end)
      return "the codes and labels of a run do not fill it";
    for (; at < end; at += brick.index_bits) {
      if (cvr_c_bits(group_, at, brick.index_bits) >= brick.dictionary_size)
        return "a label leaves the dictionary";
    }
  }
  return nullptr;
}

}  // namespace cvr::codecs::csgvr
