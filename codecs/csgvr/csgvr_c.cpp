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
using csgvr::GroupWriter;
using csgvr::KeptGroups;
using shaders::CsgvrcBrick;
using shaders::Words;

constexpr std::uint32_t kGroupVoxels = 64;  ///< a side

class CsgvrcFormat final : public BrickFormat {
 public:
  explicit CsgvrcFormat(std::uint32_t b) : brick_(b) {}

  OperationOptions options() const override {
    return {.stop_bits = true, .keep_outside = true, .delta = false};
  }
  bool wants_operations() const override { return false; }
  std::uint32_t group() const override { return kGroupVoxels / brick_; }

  bool keeps_bricks() const override { return true; }
  void fit_kept(std::span<PackWorkspace* const> workspaces) override {
    const auto for_each = [&](auto&& body) {
      for (PackWorkspace* workspace : workspaces) body(static_cast<KeptGroups&>(*workspace));
    };
    csgvr::PatternCounts widest, chosen;
    for_each([&](const KeptGroups& kept) { kept.count_widest(widest); });
    for_each([&](KeptGroups& kept) { kept.choose(widest, chosen); });
    code_.fit(chosen);
    for_each([&](KeptGroups& kept) { kept.encode(code_); });
  }
  void write_tables(ByteWriter& out) const override { code_.write(out); }
  Expected<void> read_tables(ByteReader& in) override { return code_.read(in); }

  std::unique_ptr<PackWorkspace> pack_workspace() const override {
    return std::make_unique<KeptGroups>(brick_);
  }
  void pack(const SourceBrick& brick, PackWorkspace& workspace, std::vector<std::uint32_t>&,
            ByteBreakdown&) const override {
    static_cast<KeptGroups&>(workspace).add(brick.grid);
  }
  void finish_group(PackWorkspace& workspace, std::vector<std::uint32_t>&,
                    ByteBreakdown&) const override {
    static_cast<KeptGroups&>(workspace).finish_group();
  }
  std::unique_ptr<PackWorkspace> write_workspace() const override {
    return std::make_unique<GroupWriter>();
  }
  void write_kept(const PackWorkspace& kept, std::size_t n, PackWorkspace& scratch,
                  std::vector<std::uint32_t>& words, ByteBreakdown& bytes) const override {
    static_cast<GroupWriter&>(scratch).write(static_cast<const KeptGroups&>(kept), n, words, bytes);
  }

  BrickError check(std::span<const std::uint32_t> group, std::uint32_t bricks,
                   unsigned levels) const override {
    return csgvr::GroupCheck(code_.tables()).run(group, bricks, levels);
  }
  BrickError unpack(const StoredBrick& stored, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace) const override {
    return decode(stored, validity, target, workspace, nullptr);
  }
  bool has_entropy() const override { return true; }
  BrickError tally(const StoredBrick& stored, const Validity& validity, BrickWorkspace& workspace,
                   SymbolTally& tally) const override {
    return decode(stored, validity, workspace.grid.levels() - 1, workspace, &tally);
  }
  bool has_voxel_access() const override { return true; }
  BrickError at(const BrickLayout& layout, std::span<const Coordinate> points, unsigned level,
                std::span<std::uint64_t> labels) const override;
  Expected<void> describe_to_gpu(const BrickLayout& layout, unsigned threads,
                                 GpuEncoding& encoding) const override;

 private:
  Words tables() const { return {code_.tables().data()}; }
  BrickError decode(const StoredBrick& stored, const Validity& validity, unsigned target,
                    BrickWorkspace& workspace, SymbolTally* tally) const;

  std::uint32_t brick_;
  BlockCode code_;
};

BrickError CsgvrcFormat::decode(const StoredBrick& stored, const Validity& validity,
                                unsigned target, BrickWorkspace& workspace,
                                SymbolTally* tally) const {
  const Words group{stored.words.data()};
  const CsgvrcBrick brick = shaders::cvr_c_open(group, stored.member, workspace.grid.levels());
  csgvr::BlockReader reader(group, tables(), brick, tally);
  Reconstruction reconstruction(reader, reader.labels(), workspace.grid, validity, options());
  return reconstruction.run(target, workspace.active[0].data(), workspace.active[1].data());
}

BrickError CsgvrcFormat::at(const BrickLayout& layout, std::span<const Coordinate> points,
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

Expected<void> CsgvrcFormat::describe_to_gpu(const BrickLayout& layout, unsigned threads,
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

}  // namespace

const Codec& csgvr_c_codec() {
  static const BrickCodec kCodec(
      brick_traits("csgvr-c", "csgvr",
                   "CSGV-R with codes for blocks of eight operations, sampled pointers",
                   Granularity::kVoxel),
      {brick_parameter()}, [](const Parameters& parameters) {
        return std::make_unique<CsgvrcFormat>(
            static_cast<std::uint32_t>(parameters.integer("brick")));
      });
  return kCodec;
}

}  // namespace cvr::codecs
