#include "codecs/csgvr/group_reader.hpp"

#include <algorithm>

#include "codecs/csgvr/block_code.hpp"

namespace cvr::codecs::csgvr {

using csgv::BrickError;
using shaders::CsgvrcBrick;
using shaders::CsgvrcRuns;

namespace {

/// Words that the header of a group or brick may take behind its begin, whatever its fields say, and the longest block.
constexpr std::size_t kHeaderWords = 160;
constexpr std::uint64_t kMostDictionary = std::uint64_t{1} << 18;  ///< voxels of a group
constexpr unsigned kMostPositionBits = 24;

}  // namespace

BrickError GroupCheck::run(std::span<const std::uint32_t> group, std::uint32_t members, unsigned levels) {
  if (group.size() < 2) return "the group is shorter than its header";
  words_.assign(group.begin(), group.end());
  words_.resize(group.size() + kHeaderWords);
  group_ = {words_.data()};
  limit_ = 32 * (group.size() - 1);
  const CsgvrcBrick head = shaders::cvr_c_open_group(group_, levels);
  if (head.dictionary_size > kMostDictionary || head.dictionary + std::uint64_t{head.dictionary_size} * head.label_bits > limit_) {
    return "the dictionary is longer than the group";
  }
  if (head.index_bits == 0) return nullptr;
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
  if (cvr_c_take(group_, at, 6) + 1 != members) return "the group has more or fewer bricks than its place in the volume";
  const std::uint32_t end_bits = cvr_c_take(group_, at, 5);
  at += 5;
  std::uint32_t bricks = 0;
  for (std::uint32_t i = 0; i < members; ++i) bricks += cvr_c_take(group_, at, 1) ^ 1;
  const std::uint64_t streams = at + std::uint64_t{bricks} * end_bits + std::uint64_t{members - bricks} * head.index_bits;
  std::uint64_t before = 0;
  for (std::uint32_t i = 0; i < bricks; ++i) {
    const std::uint64_t end = cvr_c_take(group_, at, end_bits);
    if (end < before || streams + end > limit_) return "a brick ends before it begins, or behind its group";
    before = end;
  }
  return streams <= limit_ ? nullptr : "the group is shorter than the table of its bricks";
}

BrickError GroupCheck::check_header(const CsgvrcBrick& brick) const {
  const std::uint32_t most_fine = csgv::nodes_of_level(brick.levels - 2);
  if (brick.coarse_blocks == 0 || brick.coarse_blocks > csgv::nodes_before_level(brick.levels - 2)) return "the coarse blocks are none, or too many";
  if (brick.fine_blocks > most_fine) return "the fine blocks are too many";
  if (brick.position_bits > kMostPositionBits || brick.coarse.offset_bits > kMostPositionBits ||
      brick.fine.offset_bits > kMostPositionBits || brick.opened_bits > kMostPositionBits) {
    return "the samples are wider than any position";
  }
  if (brick.coarse.first > brick.end || brick.fine.first > brick.end) return "the runs begin behind their brick";
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
  level_ = 1;
  blocks_of_level_ = 1;
  blocks_of_next_ = 0;
  opened_ = 0;
  if (BrickError error = check_blocks(brick, false)) return error;
  if (level_ + 1 != brick.levels || blocks_of_level_ != brick.fine_blocks) return "the fine blocks are not as many as the open nodes";
  return check_blocks(brick, true);
}

BrickError GroupCheck::check_blocks(const CsgvrcBrick& brick, bool fine) {
  const CsgvrcRuns& runs = fine ? brick.fine : brick.coarse;
  for (std::uint32_t run = 0; run < runs.count; ++run) {
    if (cvr_c_run_end(group_, runs, run) > runs.end || cvr_c_run_begin(group_, runs, run) > runs.end) return "a run leaves its brick";
    if (!fine && cvr_c_opened_before(group_, brick, run) != opened_) return "a sample miscounts the open nodes";
    if (BrickError error = check_run(brick, fine, run)) return error;
  }
  return nullptr;
}

BrickError GroupCheck::check_run(const CsgvrcBrick& brick, bool fine, std::uint32_t run) {
  const unsigned shift = fine ? CVR_C_FINE_RUN_SHIFT : CVR_C_COARSE_RUN_SHIFT;
  const std::uint32_t blocks = fine ? brick.fine_blocks : brick.coarse_blocks;
  const std::uint32_t end = cvr_c_run_end(group_, fine ? brick.fine : brick.coarse, run);
  std::uint32_t at = cvr_c_run_begin(group_, fine ? brick.fine : brick.coarse, run);
  std::uint32_t own = 0;
  for (std::uint32_t k = run << shift; k < std::min(blocks, (run + 1) << shift); ++k) {
    const BlockContent content = cvr_c_content(group_, tables_, fine, at);
    if (at > end) return "the codes of a run are longer than the run";
    if (!valid_operations(content)) return "an unknown operation";
    own += shaders::cvr_popcount32(shaders::cvr_c_own_labels(content));
    if (fine) continue;
    if (blocks_of_level_ == 0) {
      if (blocks_of_next_ == 0) return "there are more coarse blocks than open nodes";
      blocks_of_level_ = blocks_of_next_;
      blocks_of_next_ = 0;
      ++level_;
    }
    if (level_ + 1 == brick.levels) return "there are coarse blocks on the finest level";
    --blocks_of_level_;
    const std::uint32_t open = shaders::cvr_popcount32(content >> 24);
    blocks_of_next_ += open;
    opened_ += open;
    // The last coarse block: its level must end with it.
    if (k + 1 == blocks && blocks_of_level_ == 0) {
      blocks_of_level_ = blocks_of_next_;
      ++level_;
    }
  }
  if (at + std::uint64_t{own} * brick.index_bits != end) return "the codes and labels of a run do not fill it";
  for (std::uint32_t i = 0; i < own; ++i, at += brick.index_bits) {
    if (cvr_c_bits(group_, at, brick.index_bits) >= brick.dictionary_size) return "a label leaves the dictionary";
  }
  return nullptr;
}

}  // namespace cvr::codecs::csgvr
