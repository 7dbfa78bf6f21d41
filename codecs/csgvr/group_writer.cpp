#include "codecs/csgvr/group_writer.hpp"

#include <algorithm>
#include <bit>

#include "shaders/shared/shared.hpp"

namespace cvr::codecs::csgvr {

namespace {

unsigned width(std::uint64_t most) { return static_cast<unsigned>(std::bit_width(most)); }

std::uint32_t labels_of(BlockContent content) { return static_cast<std::uint32_t>(std::popcount(shaders::cvr_c_own_labels(content))); }

/// Numbers that grow about evenly, one for each run but the first, which has 0: as they are, or as what they are off a line.
class Samples {
 public:
  Samples(const std::vector<std::uint32_t>& numbers, unsigned plain_bits) : numbers_(numbers), linear_(numbers.size() > CVR_C_FEW_RUNS) {
    bits_ = numbers.size() > 1 ? plain_bits : 0;
    if (!linear_) return;
    slope_ = static_cast<std::uint32_t>((std::uint64_t{numbers.back()} << CVR_C_SLOPE_SHIFT) / (numbers.size() - 1));
    bits_ = 1;
    for (std::size_t i = 1; i < numbers.size(); ++i) {
      const std::int64_t off = off_line(i);
      bits_ = std::max(bits_, 1 + width(static_cast<std::uint64_t>(off < 0 ? -off - 1 : off)));
    }
  }
  bool linear() const { return linear_; }
  unsigned bits() const { return bits_; }
  std::uint32_t slope() const { return slope_; }
  std::uint64_t stored(std::size_t run) const {
    if (!linear_) return numbers_[run];
    return static_cast<std::uint64_t>(off_line(run) + (std::int64_t{1} << (bits_ - 1)));
  }

 private:
  std::int64_t off_line(std::size_t run) const {
    return static_cast<std::int64_t>(numbers_[run]) - static_cast<std::int64_t>(slope_ * run >> CVR_C_SLOPE_SHIFT);
  }

  const std::vector<std::uint32_t>& numbers_;
  bool linear_;
  unsigned bits_;
  std::uint32_t slope_ = 0;
};

}  // namespace

std::uint32_t GroupWriter::index_of(std::uint32_t label) {
  const auto [place, added] = indices_.try_emplace(label, static_cast<std::uint32_t>(dictionary_.size()));
  if (added) dictionary_.push_back(label);
  return place->second;
}

const CodedBlock& GroupWriter::coded(const BlockShape& shape, bool fine, const BlockCode& code) {
  const std::uint64_t key = shape.bits() << 1 | (fine ? 1 : 0);
  Chosen& chosen = chosen_[key * 0x9e3779b97f4a7c15u >> 53];
  if (chosen.shape != key) chosen = {key, code.shortest(shape, fine)};
  return chosen.code;
}

void GroupWriter::add(const csgv::LabelGrid& grid, const BlockCode& code) {
  Brick brick{index_of(grid.labels(0)[0]), blocks_.size(), blocks_.size(), 0, own_labels_.size()};
  std::size_t coarse = 0;
  finder_.run(grid, [&](bool finest, const BlockShape& shape, const std::uint32_t* labels) {
    blocks_.push_back(coded(shape, finest, code));
    coarse += finest ? 0 : 1;
    for (unsigned rest = shape.own() & ~shape.repeated(); rest != 0; rest &= rest - 1) {
      own_labels_.push_back(index_of(labels[std::countr_zero(rest)]));
    }
  });
  brick.fine_block = brick.first_block + coarse;
  brick.end_block = blocks_.size();
  bricks_.push_back(brick);
}

GroupWriter::Runs GroupWriter::runs_of(std::size_t first, std::size_t end, unsigned run_shift) const {
  Runs runs{};
  std::uint32_t opened = 0;
  for (std::size_t i = first; i < end; ++i) {
    if (((i - first) & ((1u << run_shift) - 1)) == 0) {
      runs.offsets.push_back(runs.bits);
      runs.opened.push_back(opened);
    }
    runs.bits += blocks_[i].length + labels_of(blocks_[i].content) * index_bits_;
    opened += static_cast<std::uint32_t>(std::popcount(blocks_[i].content >> 24));
  }
  return runs;
}

void GroupWriter::write_samples(const Runs& coarse, const Runs& fine, unsigned position_bits) {
  const Samples coarse_offsets(coarse.offsets, position_bits);
  const Samples opened(coarse.opened, 3 * levels_ - 5);
  const Samples fine_offsets(fine.offsets, position_bits);
  const auto describe = [&](const Samples& samples, unsigned slope_bits) {
    if (!samples.linear()) return;
    streams_.append(samples.bits(), 5);
    streams_.append(samples.slope(), slope_bits);
  };
  describe(coarse_offsets, 17);
  describe(opened, 12);
  describe(fine_offsets, 17);
  for (std::size_t run = 1; run < coarse.offsets.size(); ++run) {
    streams_.append(coarse_offsets.stored(run), coarse_offsets.bits());
    streams_.append(opened.stored(run), opened.bits());
  }
  for (std::size_t run = 1; run < fine.offsets.size(); ++run) streams_.append(fine_offsets.stored(run), fine_offsets.bits());
}

/// Writes the codes of each run and then its labels, the last first; `label` moves to the next run's.
void GroupWriter::write_runs(std::size_t first, std::size_t end, unsigned run_shift, std::size_t& label) {
  for (std::size_t run = first; run < end; run += std::size_t{1} << run_shift) {
    const std::size_t run_end = std::min(end, run + (std::size_t{1} << run_shift));
    const std::size_t first_label = label;
    for (std::size_t i = run; i < run_end; ++i) {
      streams_.append(blocks_[i].bits, blocks_[i].length);
      bits_.codes += blocks_[i].length;
      label += labels_of(blocks_[i].content);
    }
    for (std::size_t i = label; i-- > first_label;) streams_.append(own_labels_[i], index_bits_);
    bits_.labels += (label - first_label) * index_bits_;
  }
}

void GroupWriter::write_brick(const Brick& brick, unsigned position_bits) {
  const Runs coarse = runs_of(brick.first_block, brick.fine_block, CVR_C_COARSE_RUN_SHIFT);
  const Runs fine = runs_of(brick.fine_block, brick.end_block, CVR_C_FINE_RUN_SHIFT);
  const std::uint32_t begin = streams_.size();
  streams_.append(brick.fine_block - brick.first_block, 3 * levels_ - 8);
  streams_.append(brick.end_block - brick.fine_block - 1, 3 * levels_ - 6);
  streams_.append(brick.root, index_bits_);
  streams_.append(coarse.bits, position_bits);
  bits_.header += streams_.size() - begin;
  const std::uint32_t samples = streams_.size();
  write_samples(coarse, fine, position_bits);
  bits_.samples += streams_.size() - samples;
  std::size_t label = brick.first_label;
  write_runs(brick.first_block, brick.fine_block, CVR_C_COARSE_RUN_SHIFT, label);
  write_runs(brick.fine_block, brick.end_block, CVR_C_FINE_RUN_SHIFT, label);
}

void GroupWriter::finish(std::vector<std::uint32_t>& words, ByteBreakdown& bytes) {
  bits_ = {};
  group_.clear();
  streams_.clear();
  index_bits_ = width(dictionary_.size() - 1);
  const unsigned label_bits = std::max(1u, width(std::ranges::max(dictionary_)));
  group_.append(label_bits - 1, 5);
  group_.append(index_bits_, 5);
  group_.append(dictionary_.size() - 1, index_bits_);
  for (const std::uint32_t label : dictionary_) group_.append(label, label_bits);
  bits_.labels += label_bits * dictionary_.size();
  if (index_bits_ > 0) {
    std::uint32_t longest = 0;
    for (const Brick& brick : bricks_) {
      longest = std::max(longest, runs_of(brick.first_block, brick.fine_block, CVR_C_COARSE_RUN_SHIFT).bits);
      longest = std::max(longest, runs_of(brick.fine_block, brick.end_block, CVR_C_FINE_RUN_SHIFT).bits);
    }
    const unsigned position_bits = width(longest);
    std::vector<std::uint32_t> ends;
    for (const Brick& brick : bricks_) {
      if (brick.constant()) continue;
      write_brick(brick, position_bits);
      ends.push_back(streams_.size());
    }
    const unsigned end_bits = width(streams_.size());
    group_.append(bricks_.size() - 1, 6);
    group_.append(end_bits, 5);
    group_.append(position_bits, 5);
    for (const Brick& brick : bricks_) group_.append(brick.constant() ? 1 : 0, 1);
    for (const std::uint32_t end : ends) group_.append(end, end_bits);
    for (const Brick& brick : bricks_) {
      if (brick.constant()) group_.append(brick.root, index_bits_);
    }
  }
  bits_.header += group_.size() - label_bits * dictionary_.size();
  group_.append(streams_);
  // One word more than the bits need: every read takes the word behind too.
  const std::size_t at = words.size();
  words.resize(at + (group_.size() + 31) / 32 + 1);
  for (std::size_t i = at; i < words.size(); ++i) {
    const std::size_t half = i - at;
    words[i] = half / 2 < group_.words().size() ? static_cast<std::uint32_t>(group_.words()[half / 2] >> (32 * (half % 2))) : 0;
  }
  const std::uint64_t whole = 4 * (words.size() - at);
  bytes[ByteClass::kHeader] += bits_.header / 8;
  bytes[ByteClass::kPalette] += bits_.labels / 8;
  bytes[ByteClass::kRank] += bits_.samples / 8;
  bytes[ByteClass::kOperations] += bits_.codes / 8;
  bytes[ByteClass::kPadding] += whole - bits_.header / 8 - bits_.labels / 8 - bits_.samples / 8 - bits_.codes / 8;
  bricks_.clear();
  blocks_.clear();
  own_labels_.clear();
  dictionary_.clear();
  indices_.clear();
}

}  // namespace cvr::codecs::csgvr
