#include "codecs/csgvr/group_writer.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "shaders/shared/shared.hpp"

namespace cvr::codecs::csgvr {

namespace {

unsigned width(std::uint64_t most) { return static_cast<unsigned>(std::bit_width(most)); }

/// Where runs begin: as it is, or, of many runs, as what it is off a line. The first begins at 0 and has no sample.
class Samples {
 public:
  Samples(const std::vector<std::uint32_t>& numbers, unsigned plain_bits)
      : numbers_(numbers), linear_(numbers.size() > CVR_C_FEW_RUNS), bits_(plain_bits) {
    if (!linear_) return;
    slope_ = static_cast<std::uint32_t>((std::uint64_t{numbers.back()} << CVR_C_SLOPE_SHIFT) /
                                        (numbers.size() - 1));
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
    return static_cast<std::int64_t>(numbers_[run]) -
           static_cast<std::int64_t>(slope_ * run >> CVR_C_SLOPE_SHIFT);
  }

  const std::vector<std::uint32_t>& numbers_;
  bool linear_;
  unsigned bits_;
  std::uint32_t slope_ = 0;
};

}  // namespace

void GroupKeeper::add(const csgv::LabelGrid& grid) {
  Brick brick{
      indices_.note(grid.labels(0)[0]), blocks_.size(), 0, 0, masks_.size(), own_labels_.size()};
  keys_.clear();
  own_keys_.clear();
  finder_.run(
      grid, [&](bool finest, const BlockShape& shape, unsigned open, const std::uint32_t* labels) {
        keys_.push_back(shape_key(shape, finest));
        if (!finest) masks_.push_back(static_cast<std::uint8_t>(open));
        for (unsigned rest = shape.own() & ~shape.repeated(); rest != 0; rest &= rest - 1) {
          own_keys_.push_back(labels[std::countr_zero(rest)]);
        }
      });
  shapes_.note(keys_, blocks_);
  indices_.note(own_keys_, own_labels_);
  brick.fine_block = brick.first_block + masks_.size() - brick.first_mask;
  brick.end_block = blocks_.size();
  bricks_.push_back(brick);
}

std::size_t GroupKeeper::keep(csgv::SourceGroup& group) {
  while (const auto brick = group.next()) add(brick->grid);
  const Group before = groups_.empty() ? Group{} : groups_.back();
  for (const KeyCounts::Entry& entry : indices_.entries())
    dictionary_.push_back(static_cast<std::uint32_t>(entry.key));
  groups_.push_back({before.end_brick, bricks_.size(), before.end_entry, dictionary_.size()});
  indices_.clear();
  return groups_.size() - 1;
}

void GroupKeeper::count_widest(PatternCounts& patterns) const {
  for (const auto& [key, count] : shapes_.entries()) {
    const BlockShape shape = shape_of(key);
    patterns[is_fine(key)].note(shape.operations(shape.widest_first()), count);
  }
}

void GroupKeeper::choose(const PatternCounts& before, PatternCounts& chosen) {
  operations_.clear();
  for (const auto& [key, count] : shapes_.entries()) {
    operations_.push_back(most_frequent(shape_of(key), before[is_fine(key)]));
    chosen[is_fine(key)].note(operations_.back(), count);
  }
}

void GroupKeeper::encode(const BlockCode& code) {
  codes_.clear();
  for (std::size_t i = 0; i < operations_.size(); ++i)
    codes_.push_back(code.coded(operations_[i], is_fine(shapes_.entries()[i].key)));
}

BlockGroupWriter::Runs BlockGroupWriter::runs_of(std::size_t first, std::size_t end) const {
  Runs runs{};
  for (std::size_t i = first; i < end; ++i) {
    if ((i - first) % CVR_C_RUN == 0) runs.offsets.push_back(runs.bits);
    runs.bits += block(i).length + block(i).labels * index_bits_;
  }
  return runs;
}

void BlockGroupWriter::write_masks(const Brick& brick) {
  std::uint32_t opened = 0;
  for (std::size_t i = 0; i < brick.fine_block - brick.first_block; ++i) {
    if (i > 0 && i % CVR_C_MASKS == 0) streams_.append(opened, CVR_C_COUNT_BITS);
    const std::uint8_t mask = kept_->masks_[brick.first_mask + i];
    streams_.append(mask, 8);
    opened += static_cast<std::uint32_t>(std::popcount(mask));
  }
}

/// Writes the codes of each run and then its labels, the last first; `label` moves to the next run's.
void BlockGroupWriter::write_runs(std::size_t first, std::size_t end, std::size_t& label) {
  for (std::size_t run = first; run < end; run += CVR_C_RUN) {
    const std::size_t first_label = label;
    for (std::size_t i = run; i < std::min<std::size_t>(end, run + CVR_C_RUN); ++i) {
      streams_.append(block(i).bits, block(i).length);
      bits_.codes += block(i).length;
      label += block(i).labels;
    }
    for (std::size_t i = label; i-- > first_label;)
      streams_.append(kept_->own_labels_[i], index_bits_);
    bits_.labels += (label - first_label) * index_bits_;
  }
}

void BlockGroupWriter::write_brick(const Brick& brick, unsigned position_bits) {
  const Runs coarse = runs_of(brick.first_block, brick.fine_block);
  const Runs fine = runs_of(brick.fine_block, brick.end_block);
  const std::array samples{Samples(coarse.offsets, position_bits),
                           Samples(fine.offsets, position_bits)};
  std::uint32_t before = streams_.size();
  const auto count = [&](std::uint64_t& bits) {
    bits += streams_.size() - before;
    before = streams_.size();
  };
  streams_.append(brick.fine_block - brick.first_block, 3 * kept_->levels_ - 8);
  streams_.append(brick.end_block - brick.fine_block, 3 * kept_->levels_ - 5);
  streams_.append(brick.root, index_bits_);
  streams_.append(coarse.bits, position_bits);
  for (const Samples& s : samples) {
    if (!s.linear()) continue;
    streams_.append(s.bits(), 5);
    streams_.append(s.slope(), 17);
  }
  streams_.append(0, (8 - streams_.size() % 8) % 8);
  count(bits_.header);
  write_masks(brick);
  count(bits_.masks);
  masks_end_ = streams_.size();
  for (std::size_t run = 1; run < coarse.offsets.size(); ++run)
    streams_.append(samples[0].stored(run), samples[0].bits());
  for (std::size_t run = 1; run < fine.offsets.size(); ++run)
    streams_.append(samples[1].stored(run), samples[1].bits());
  count(bits_.samples);
  std::size_t label = brick.first_label;
  write_runs(brick.first_block, brick.fine_block, label);
  write_runs(brick.fine_block, brick.end_block, label);
}

/// The rest of the header with the table of the bricks; the bricks go to streams_.
void BlockGroupWriter::write_bricks(std::span<const Brick> bricks, std::size_t dictionary_size) {
  std::uint32_t longest = 0;
  for (const Brick& brick : bricks) {
    longest = std::max({longest, runs_of(brick.first_block, brick.fine_block).bits,
                        runs_of(brick.fine_block, brick.end_block).bits});
  }
  const unsigned position_bits = width(longest);
  std::vector<std::uint32_t> ends;
  for (const Brick& brick : bricks) {
    if (brick.constant()) continue;
    write_brick(brick, position_bits);
    ends.push_back(streams_.size());
  }
  const unsigned end_bits = width(streams_.size());
  group_.append(dictionary_size - 1, CVR_C_DICTIONARY_BITS);
  group_.append(bricks.size() - 1, 6);
  group_.append(end_bits, 5);
  group_.append(position_bits, 5);
  for (const Brick& brick : bricks) group_.append(brick.constant() ? 1 : 0, 1);
  for (const std::uint32_t end : ends) group_.append(end, end_bits);
  for (const Brick& brick : bricks) {
    if (brick.constant()) group_.append(brick.root, index_bits_);
  }
}

void BlockGroupWriter::write(const csgv::KeptGroup& which, std::vector<std::uint32_t>& words,
                             ByteBreakdown& bytes) {
  const GroupKeeper& kept = keepers_[which.worker];
  const GroupKeeper::Group& group = kept.groups_[which.number];
  const auto bricks =
      std::span(kept.bricks_).subspan(group.first_brick, group.end_brick - group.first_brick);
  const auto dictionary =
      std::span(kept.dictionary_).subspan(group.first_entry, group.end_entry - group.first_entry);
  kept_ = &kept;
  bits_ = {};
  masks_end_ = 0;
  group_.clear();
  streams_.clear();
  index_bits_ = width(dictionary.size() - 1);
  const unsigned label_bits = std::max(1u, width(std::ranges::max(dictionary)));
  group_.append(label_bits - 1, 5);
  group_.append(index_bits_, 5);
  if (index_bits_ > 0) write_bricks(bricks, dictionary.size());
  for (const std::uint32_t label : dictionary) group_.append(label, label_bits);
  if (index_bits_ > 0) group_.append(0, (8 - group_.size() % 8) % 8);
  masks_end_ += group_.size();
  bits_.labels += label_bits * dictionary.size();
  bits_.header += group_.size() - label_bits * dictionary.size();
  group_.append(streams_);
  append_group(words, bytes);
}

/// One word more than the bits need, since every read takes the word behind too; and 8 bytes from the last mask on.
void BlockGroupWriter::append_group(std::vector<std::uint32_t>& words, ByteBreakdown& bytes) {
  const std::size_t at = words.size();
  words.resize(at + std::max((group_.size() + 31) / 32 + 1, (masks_end_ + 56 + 31) / 32));
  for (std::size_t half = 0; half < words.size() - at; ++half) {
    const bool held = half / 2 < group_.words().size();
    words[at + half] =
        held ? static_cast<std::uint32_t>(group_.words()[half / 2] >> (32 * (half % 2))) : 0;
  }
  std::uint64_t rest = 4 * (words.size() - at);
  const auto add = [&](ByteClass byte_class, std::uint64_t bits) {
    bytes[byte_class] += bits / 8;
    rest -= bits / 8;
  };
  add(ByteClass::kHeader, bits_.header);
  add(ByteClass::kPalette, bits_.labels);
  add(ByteClass::kStopBits, bits_.masks);
  add(ByteClass::kRank, bits_.samples);
  add(ByteClass::kOperations, bits_.codes);
  bytes[ByteClass::kPadding] += rest;
}

}  // namespace cvr::codecs::csgvr
