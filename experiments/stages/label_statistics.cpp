// Voxels and bounding box of every label, from the encoded form: what connectomics asks of a
// segmentation before anything else. A codec with bricks is asked for each brick whether it has one
// label alone, which needs no decoding; other bricks are decoded one at a time. A codec without
// bricks decodes the volume slab by slab. The check compares all statistics with a plain count of
// the original.
#include "volumes/metrics/label_statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "experiments/results/error_row.hpp"
#include "experiments/stages/costs.hpp"
#include "experiments/stages/encoded_volume.hpp"
#include "experiments/stages/stage_kind.hpp"
#include "volumes/parallel.hpp"
#include "volumes/slabs.hpp"

namespace cvr::experiments {

namespace {

using volumes::LabelCounter;
using volumes::LabelStatistics;

constexpr std::uint64_t kSlabPlanes = 64;

/// Counts the labels of decoded slabs, planes side by side.
class CountingSink final : public volumes::SlabSink {
 public:
  CountingSink(const volumes::VolumeInfo& info, unsigned threads)
      : info_(info), counters_(std::max(1u, threads)) {}
  std::uint64_t preferred_depth() const override { return kSlabPlanes; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
    slab_.resize((z1 - z0) * plane());
    return slab_.data();
  }
  void end(std::uint64_t z0, std::uint64_t z1) override {
    const auto threads = static_cast<unsigned>(counters_.size());
    volumes::parallel_for(threads, z1 - z0, [&](unsigned worker, std::uint64_t z) {
      counters_[worker].add_voxels({{0, 0, z0 + z}, {info_.extent.x, info_.extent.y, 1}},
                                   slab_.data() + z * plane(), info_.type);
    });
  }
  std::vector<LabelStatistics> result() {
    for (std::size_t i = 1; i < counters_.size(); ++i) counters_[0].merge(counters_[i]);
    return counters_[0].result();
  }

 private:
  std::uint64_t plane() const { return info_.extent.x * info_.extent.y * size_of(info_.type); }

  volumes::VolumeInfo info_;
  std::vector<LabelCounter> counters_;
  volumes::Buffer slab_;
};

/// What one worker has counted of the bricks.
struct BrickWorker {
  LabelCounter counter;
  std::vector<std::byte> voxels;
  std::uint64_t decoded = 0;
  std::optional<volumes::Error> error;
};

struct Counted {
  std::vector<LabelStatistics> labels;
  std::uint64_t bricks = 0, bricks_decoded = 0;  ///< 0 of a codec without bricks
};

void count_brick(const codecs::BrickAccess& bricks, const volumes::VolumeInfo& info,
                 std::uint64_t index, BrickWorker& worker) {
  const volumes::Extent grid = bricks.brick_grid(), size = bricks.brick_size();
  const volumes::Coordinate brick = grid.coordinate(index);
  const volumes::Coordinate origin{brick.x * size.x, brick.y * size.y, brick.z * size.z};
  const volumes::Box box{
      origin,
      {std::min(size.x, info.extent.x - origin.x), std::min(size.y, info.extent.y - origin.y),
       std::min(size.z, info.extent.z - origin.z)}};
  const auto only = bricks.only_label(brick);
  if (!only) {
    worker.error = only.error();
    return;
  }
  if (*only) {
    worker.counter.add_uniform(box, **only);
    return;
  }
  worker.voxels.resize(box.size.voxels() * size_of(info.type));
  if (const auto done = bricks.decode_brick(brick, 0, worker.voxels.data()); !done) {
    worker.error = done.error();
    return;
  }
  worker.counter.add_voxels(box, worker.voxels.data(), info.type);
  ++worker.decoded;
}

Counted count_bricks(const codecs::BrickAccess& bricks, const volumes::VolumeInfo& info,
                     unsigned threads) {
  std::vector<BrickWorker> workers(std::max(1u, threads));
  const std::uint64_t all = bricks.brick_grid().voxels();
  volumes::parallel_for(threads, all, [&](unsigned worker, std::uint64_t i) {
    if (!workers[worker].error) count_brick(bricks, info, i, workers[worker]);
  });
  Counted counted;
  counted.bricks = all;
  for (BrickWorker& worker : workers) {
    if (worker.error) fail_stage(*worker.error);
    counted.bricks_decoded += worker.decoded;
    if (&worker != &workers.front()) workers.front().counter.merge(worker.counter);
  }
  counted.labels = workers.front().counter.result();
  return counted;
}

class LabelStatisticsRun final : public StageRun {
 public:
  explicit LabelStatisticsRun(const StageInput& input)
      : spec_(input.spec), truth_(input.truth), source_(input.source) {}

  Parts prepare() override {
    bytes_ = obtain_encoded(spec_, source_);
    file_.emplace(checked(codecs::open_file(bytes_.bytes())));
    Parts parts;
    parts.size = describe_size(*file_, bytes_.size(), spec_.bytes_per_voxel);
    const Counted counted = count();
    require_equal(counted.labels);
    parts.verification.emplace().labels_compared = counted.labels.size();
    parts.label_statistics = {.labels = counted.labels.size(),
                              .by = counted.bricks > 0 ? "bricks" : "volume",
                              .bricks = counted.bricks,
                              .bricks_decoded = counted.bricks_decoded,
                              .ns_per_voxel = {}};
    return parts;
  }

  std::vector<Sample> round() override {
    const Stopwatch watch;
    const Counted counted = count();
    return {watch.lap("label-statistics", truth_.info().extent.voxels())};
  }

 private:
  Counted count() const {
    const auto decoder = checked(codecs::open_decoder(*file_));
    if (const codecs::BrickAccess* bricks = decoder->brick_access())
      return count_bricks(*bricks, truth_.info(), spec_.threads);
    CountingSink sink(truth_.info(), spec_.threads);
    checked(decoder->decode(0, spec_.threads, sink));
    return {sink.result()};
  }

  /// A plain count of the original.
  void require_equal(const std::vector<LabelStatistics>& found) const {
    const volumes::Extent& e = truth_.info().extent;
    LabelCounter counter;
    volumes::for_each_slab(
        truth_, kSlabPlanes, [&](std::uint64_t z, std::span<const std::byte> voxels) {
          const std::uint64_t planes = voxels.size() / volumes::plane_bytes(truth_.info());
          counter.add_voxels({{0, 0, z}, {e.x, e.y, planes}}, voxels.data(), truth_.info().type);
        });
    const auto expected = counter.result();
    if (found.size() != expected.size())
      throw StageFailure(kFailed, fmt::format("expected {} labels, the encoded volume has {}",
                                              expected.size(), found.size()));
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (found[i] != expected[i])
        throw StageFailure(kFailed,
                           fmt::format("label {}: expected {} voxels, found {}, or "
                                       "another bounding box",
                                       expected[i].label, expected[i].voxels, found[i].voxels));
    }
  }

  WorkerSpec spec_;
  const volumes::VolumeSource& truth_;
  const volumes::VolumeSource& source_;
  codecs::Buffer bytes_;
  std::optional<codecs::OpenedFile> file_;
};

class LabelStatisticsStage final : public StageKind {
 public:
  const StageTraits& traits() const override {
    static constexpr StageTraits kTraits{
        .id = "label-statistics",
        .sentence = "Voxels and bounding box of every label, from the encoded form"};
    return kTraits;
  }
  std::string unsupported_reason(const Cell&, const codecs::Traits& codec,
                                 const volumes::VolumeInfo& info) const override {
    if (info.kind != volumes::VolumeKind::kLabels) return "scalars have no labels";
    return codec.lossless ? "" : "a lossy codec keeps no labels";
  }
  double expected_seconds(const Cell& cell, const volumes::VolumeInfo& info,
                          double rounds) const override {
    return seconds_by_passes(cell, info, rounds);
  }
  double expected_memory(const Cell& cell, const volumes::VolumeInfo& info,
                         const MemoryChoices&) const override {
    const codecs::MemoryEstimate need = estimate_of(cell, info);
    const std::uint64_t planes = std::min(info.extent.z, kSlabPlanes);
    const auto slab =
        static_cast<double>(info.extent.x * info.extent.y * planes * size_of(info.type));
    return process_memory(cell) + need.file + need.decode + slab;
  }
  std::unique_ptr<StageRun> make_run(const StageInput& input) const override {
    return std::make_unique<LabelStatisticsRun>(input);
  }
  void add_times(const Measured& measured, const volumes::VolumeInfo& info,
                 Parts& parts) const override {
    StageKind::add_times(measured, info, parts);
    parts.label_statistics.value().ns_per_voxel =
        1e9 * parts.time->seconds->median / static_cast<double>(info.extent.voxels());
  }
};

}  // namespace

const StageKind& label_statistics_stage() {
  static const LabelStatisticsStage kStage;
  return kStage;
}

}  // namespace cvr::experiments
