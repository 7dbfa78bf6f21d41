// `csgvr-c`: random access like `csgvr-sb`, with whole 2x2x2 blocks under static prefix codes. See
// FORMAT.md.
//
// The groups are written by group_writer.cpp, checked and read by group_reader.cpp; single nodes go
// through the text that the GPU has, shaders/shared/csgvr_c.glsl.
#include <fmt/format.h>

#include <algorithm>

#include "codecs/csgv/brick_codec.hpp"
#include "codecs/csgvr/block_code.hpp"
#include "codecs/csgvr/csgvr.hpp"
#include "codecs/csgvr/group_reader.hpp"
#include "codecs/csgvr/group_writer.hpp"
#include "codecs/csgvr/voxel_walk.hpp"
#include "codecs/label_codes.hpp"

namespace cvr::codecs {

namespace {

using namespace csgv;
using csgvr::BlockCode;
using csgvr::BlockGroupWriter;
using csgvr::GroupKeeper;
using shaders::CsgvrcBrick;
using shaders::Words;

constexpr std::uint32_t kGroupVoxels = 64;  ///< a side

constexpr OperationOptions kOptions{.stop_bits = true, .keep_outside = true, .delta = false};

class CsgvrcVolume final : public KeptVolume {
 public:
  explicit CsgvrcVolume(std::vector<GroupKeeper> keepers) : keepers_(std::move(keepers)) {}
  std::unique_ptr<GroupWriter> writer() const override {
    return std::make_unique<BlockGroupWriter>(keepers_);
  }

 private:
  std::vector<GroupKeeper> keepers_;
};

class CsgvrcEncoder final : public TwoPassEncoder {
 public:
  CsgvrcEncoder(unsigned threads, std::uint32_t brick) : keepers_(threads, GroupKeeper(brick)) {}

  KeptGroup keep(unsigned worker, SourceGroup& group) override {
    return {worker, keepers_[worker].keep(group)};
  }
  Fitted<KeptVolume> fit() && override {
    csgvr::PatternCounts widest, chosen;
    for (const GroupKeeper& keeper : keepers_) keeper.count_widest(widest);
    for (GroupKeeper& keeper : keepers_) keeper.choose(widest, chosen);
    const BlockCode code(chosen);
    for (GroupKeeper& keeper : keepers_) keeper.encode(code);
    ByteWriter tables;
    code.write(tables);
    return {tables.take(), std::make_unique<const CsgvrcVolume>(std::move(keepers_))};
  }

 private:
  std::vector<GroupKeeper> keepers_;  ///< of each worker
};

class CsgvrcReader final : public BrickReader, public VoxelReader, public EntropyTally {
 public:
  explicit CsgvrcReader(BlockCode code) : code_(std::move(code)) {}

  BrickError check(std::span<const std::uint32_t> group, std::uint32_t bricks,
                   unsigned levels) const override {
    return csgvr::GroupCheck(code_.tables()).run(group, bricks, levels);
  }
  BrickError unpack(const StoredBrick& stored, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace) const override {
    return decode(stored, validity, target, workspace, nullptr);
  }
  const EntropyTally* entropy() const override { return this; }
  BrickError tally(const StoredBrick& stored, const Validity& validity, BrickWorkspace& workspace,
                   SymbolTally& tally) const override {
    return decode(stored, validity, workspace.grid.levels() - 1, workspace, &tally);
  }
  const VoxelReader* voxels() const override { return this; }
  BrickError at(const BrickLayout& layout, std::span<const Coordinate> points, unsigned level,
                std::span<std::uint64_t> labels) const override;
  Expected<void> describe_to_gpu(const BrickLayout& layout, unsigned threads,
                                 GpuEncoding& encoding) const override;

 private:
  Words tables() const { return {code_.tables().data()}; }
  BrickError decode(const StoredBrick& stored, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace, SymbolTally* tally) const;

  BlockCode code_;
};

BrickError CsgvrcReader::decode(const StoredBrick& stored, const Validity& validity,
                                unsigned target, BrickWorkspace& workspace,
                                SymbolTally* tally) const {
  const Words group{stored.words.data()};
  const CsgvrcBrick brick = shaders::cvr_c_open(group, stored.member, workspace.grid.levels());
  csgvr::BlockReader reader(group, tables(), brick, tally);
  return rebuild(reader, reader.labels(), validity, kOptions, target, workspace);
}

BrickError CsgvrcReader::at(const BrickLayout& layout, std::span<const Coordinate> points,
                            unsigned level, std::span<std::uint64_t> labels) const {
  return csgvr::for_each_point(
      layout, points, level, labels,
      [&, tables = tables()](std::span<const std::uint32_t> words, std::uint32_t member,
                             std::uint32_t n, std::uint64_t& label) {
        const Words group{words.data()};
        const CsgvrcBrick brick = shaders::cvr_c_open(group, member, layout.levels);
        std::uint32_t index = 0;
        std::uint32_t hops = 0;
        if (!cvr_c_index(group, tables, brick, n, level, index, hops)) return false;
        label = cvr_c_label(group, brick, index);
        return true;
      });
}

Expected<void> CsgvrcReader::describe_to_gpu(const BrickLayout& layout, unsigned threads,
                                             GpuEncoding& encoding) const {
  DistinctLabels distinct(threads);
  std::vector<std::uint32_t> labels;
  std::uint32_t largest = 0;  // words of a brick
  for (std::uint64_t i = 0; i < layout.groups.voxels(); ++i) {
    const Words group{layout.group_words(i).data()};
    const CsgvrcBrick head = shaders::cvr_c_find(group, 0, layout.levels);
    labels.clear();
    for (std::uint32_t k = 0; k < head.dictionary_size; ++k)
      labels.push_back(cvr_c_label(group, head, k));
    distinct.add(0, std::span<const std::uint32_t>(labels));
    const Coordinate at = layout.groups.coordinate(i);
    const auto members = static_cast<std::uint32_t>(layout.bricks_of_group(at).voxels());
    for (std::uint32_t member = 0; member < members; ++member) {
      largest = std::max(largest, cvr_c_words(shaders::cvr_c_find(group, member, layout.levels)));
    }
  }
  const std::vector<std::uint64_t> all = distinct.take();
  encoding.codes.assign(all.begin(), all.end());
  encoding.decoder = "csgvr_c";
  encoding.shared_words = largest;
  encoding.cell_loops =
      8 * (layout.levels + CVR_C_RUN);  // hops, each down some levels and past half a run
  encoding.buffers.push_back({"tables", std::as_bytes(std::span(code_.tables())), nullptr});
  return {};
}

class CsgvrcFormat final : public BrickFormat {
 public:
  explicit CsgvrcFormat(const Parameters& parameters)
      : BrickFormat(brick_edge(parameters), kOptions, kGroupVoxels / brick_edge(parameters)) {}
  EncoderStrategy encoder(unsigned threads, const StoredLabels&) const override {
    return std::make_unique<CsgvrcEncoder>(threads, brick);
  }
  Expected<std::unique_ptr<const BrickReader>> reader(ByteReader& tables) const override {
    return BlockCode::read(tables).map([](BlockCode&& code) -> std::unique_ptr<const BrickReader> {
      return std::make_unique<const CsgvrcReader>(std::move(code));
    });
  }
};

}  // namespace

const Codec& csgvr_c_codec() {
  static const BrickCodec kCodec(
      brick_traits("csgvr-c", "csgvr",
                   "CSGV-R with codes for blocks of eight operations, sampled pointers",
                   Granularity::kVoxel),
      {brick_parameter()},
      [](const Parameters& parameters) { return std::make_unique<CsgvrcFormat>(parameters); });
  return kCodec;
}

}  // namespace cvr::codecs
