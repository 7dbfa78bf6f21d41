// Single voxels: ns per voxel for uniform, clustered and, of labels, one-label points, for each level
// of detail. A codec that decodes no single voxels answers by its bricks: a point decodes the brick
// it lies in, unless it is that of the point before.
//
// One thread: latency is what is asked. Each round times every series once. The number of points is
// the same for all series of a cell: 1000 by bricks, else 1e5, and more where a codec is so fast
// that a round would take less than about 50 ms. What is known of the codec decides, not a clock,
// so the points and the memory that they take are the same in every run. Voxels are checked before:
// level 0 of lossless codecs against the original, others against the decoded level.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>

#include "codecs/container.hpp"
#include "codecs/estimates.hpp"
#include "codecs/registry.hpp"
#include "experiments/results/statistics.hpp"
#include "experiments/stages/costs.hpp"
#include "experiments/stages/encoded_volume.hpp"
#include "experiments/stages/points.hpp"

namespace cvr::experiments {

namespace {

struct PointSet {
  std::string name;
  std::vector<volumes::Coordinate> points;
};

/// Single voxels of a codec that decodes whole bricks: the last brick is kept.
class ByBricks final : public codecs::VoxelAccess {
 public:
  ByBricks(const codecs::BrickAccess& bricks, const volumes::VolumeInfo& info)
      : bricks_(bricks), info_(info) {}

  volumes::Expected<void> at(std::span<const volumes::Coordinate> points, unsigned lod,
                             std::span<std::uint64_t> labels) const override {
    const volumes::Extent size = bricks_.brick_size();
    const volumes::Extent side = codecs::level_extent(size, lod);
    const volumes::Extent level = codecs::level_extent(info_.extent, lod);
    std::vector<std::byte> voxels(side.voxels() * size_of(info_.type));
    volumes::Coordinate held{~std::uint64_t{0}, 0, 0};
    for (std::size_t i = 0; i < points.size(); ++i) {
      const volumes::Coordinate& p = points[i];
      const volumes::Coordinate brick{p.x / size.x, p.y / size.y, p.z / size.z};
      if (brick != held) {
        if (auto ok = bricks_.decode_brick(brick, lod, voxels.data()); !ok) return ok;
        held = brick;
      }
      const volumes::Coordinate first{brick.x * side.x, brick.y * side.y, brick.z * side.z};
      const std::uint64_t row = std::min(side.x, level.x - first.x);
      const std::uint64_t plane = row * std::min(side.y, level.y - first.y);
      const std::uint64_t at = (p.x >> lod) - first.x + row * ((p.y >> lod) - first.y) +
                               plane * ((p.z >> lod) - first.z);
      labels[i] = 0;
      std::memcpy(&labels[i], voxels.data() + at * size_of(info_.type), size_of(info_.type));
    }
    return {};
  }

 private:
  const codecs::BrickAccess& bricks_;
  volumes::VolumeInfo info_;
};

class RandomAccessRun final : public StageRun {
 public:
  explicit RandomAccessRun(const StageInput& input)
      : spec_(input.spec), truth_(input.truth), source_(input.source) {}

  Parts prepare() override {
    bytes_ = obtain_encoded(spec_, source_);
    file_.emplace(checked(codecs::open_file(bytes_.bytes())));
    decoder_ = checked(codecs::open_decoder(*file_));
    access_ = decoder_->voxel_access();
    if (access_ == nullptr && decoder_->brick_access() != nullptr) {
      by_bricks_.emplace(*decoder_->brick_access(), truth_.info());
      access_ = &*by_bricks_;
    }
    if (access_ == nullptr)
      throw StageFailure(kUnsupported, "no access to single voxels or bricks");
    Parts parts;
    verify(bytes_.bytes(), truth_, spec_.threads, parts);
    parts.size = describe_size(*file_, bytes_.size(), spec_.bytes_per_voxel);
    for (unsigned lod = 0; lod < decoder_->levels(); ++lod) {
      if (spec_.lods.empty() || std::ranges::find(spec_.lods, lod) != spec_.lods.end())
        lods_.push_back(lod);
    }
    if (lods_.empty())
      throw StageFailure(kUnsupported, fmt::format("has {} levels of detail, none was asked for",
                                                   decoder_->levels()));
    make_points();
    parts.verification->points_compared = check_points();
    parts.points_per_series = labels_.size();
    parts.access_by = by_bricks_ ? "brick" : "voxel";
    return parts;
  }

  std::vector<Sample> round() override {
    std::vector<Sample> samples;
    for (const PointSet& set : sets_) {
      for (const unsigned lod : lods_) {
        const Stopwatch watch;
        const auto done = access_->at(set.points, lod, labels_);
        samples.push_back(watch.lap(fmt::format("{}/{}", set.name, lod), labels_.size()));
        if (!done) fail_stage(done.error());
      }
    }
    return samples;
  }

 private:
  void make_points() {
    const volumes::Extent& extent = truth_.info().extent;
    const codecs::MemoryEstimate known = codecs::estimate_memory(
        *file_->codec, truth_.info(), file_->stream.parameters, spec_.threads);
    const std::uint64_t count =
        points_a_series(known.access_ns, static_cast<double>(lods_.size()), by_bricks_.has_value());
    sets_.push_back({"uniform", uniform_points(extent, spec_.seed, count)});
    sets_.push_back({"clustered", clustered_points(extent, spec_.seed, count)});
    if (truth_.info().kind == volumes::VolumeKind::kLabels)
      sets_.push_back({"one-label", one_label_points(truth_, spec_.seed, count)});
    labels_.resize(count);
  }

  /// Returns the number of compared voxels.
  std::uint64_t check_points() {
    std::uint64_t compared = 0, mismatches = 0;
    for (const unsigned lod : lods_) {
      std::optional<volumes::Volume> level;
      const bool original = lod == 0 && file_->codec->traits().lossless;
      if (!original) {
        volumes::VolumeSink sink(codecs::level_info(truth_.info(), lod));
        checked(decoder_->decode(lod, spec_.threads, sink));
        level = sink.take();
      }
      for (const PointSet& set : sets_) {
        checked(access_->at(set.points, lod, labels_));
        const auto expected =
            original ? labels_at(truth_, set.points) : labels_of_level(*level, lod, set.points);
        for (std::size_t i = 0; i < expected.size(); ++i)
          mismatches += expected[i] != labels_[i] ? 1 : 0;
        compared += expected.size();
      }
    }
    if (mismatches > 0)
      throw StageFailure(kFailed,
                         fmt::format("{} of {} single voxels are wrong", mismatches, compared));
    return compared;
  }

  static std::vector<std::uint64_t> labels_of_level(
      const volumes::Volume& level, unsigned lod, const std::vector<volumes::Coordinate>& points) {
    std::vector<volumes::Coordinate> nodes;
    for (const auto& p : points) nodes.push_back({p.x >> lod, p.y >> lod, p.z >> lod});
    return labels_at(volumes::MemorySource(level), nodes);
  }

  WorkerSpec spec_;
  const volumes::VolumeSource& truth_;
  const volumes::VolumeSource& source_;
  codecs::Buffer bytes_;
  std::optional<codecs::OpenedFile> file_;
  std::unique_ptr<codecs::Decoder> decoder_;
  std::optional<ByBricks> by_bricks_;
  const codecs::VoxelAccess* access_ = nullptr;
  std::vector<unsigned> lods_;
  std::vector<PointSet> sets_;
  std::vector<std::uint64_t> labels_;
};

class RandomAccessStage final : public StageKind {
 public:
  const StageTraits& traits() const override {
    static constexpr StageTraits kTraits{
        .id = "random-access",
        .sentence =
            "Single voxels: uniform, clustered and one-label points at each level of detail",
        .version = 2};  // points from what is known of the codec
    return kTraits;
  }
  std::string unsupported_reason(const Cell&, const codecs::Traits& codec,
                                 const volumes::VolumeInfo&) const override {
    return codec.access == codecs::Granularity::kVolume ? "no access to single voxels" : "";
  }
  double expected_seconds(const Cell& cell, const volumes::VolumeInfo& info,
                          double rounds) const override {
    constexpr double kRound = 0.5;
    return 4 * pass_seconds(cell, info) + kRound * rounds;
  }
  double expected_memory(const Cell& cell, const volumes::VolumeInfo& info,
                         const MemoryChoices& choices) const override {
    const codecs::MemoryEstimate need = estimate_of(cell, info);
    const bool labels = info.kind == volumes::VolumeKind::kLabels;
    const double levels = choices.lods.empty()
                              ? need.levels
                              : std::min(need.levels, static_cast<double>(choices.lods.size()));
    const bool by_bricks =
        codecs::find_codec(cell.codec)->traits().access == codecs::Granularity::kBrick;
    const auto points = static_cast<double>(points_a_series(need.access_ns, levels, by_bricks));
    return process_memory(cell) + need.file + need.open +
           points * ((labels ? 3 : 2) * sizeof(volumes::Coordinate) + sizeof(std::uint64_t));
  }
  std::unique_ptr<StageRun> make_run(const StageInput& input) const override {
    return std::make_unique<RandomAccessRun>(input);
  }

  void add_times(const Measured& measured, const volumes::VolumeInfo&,
                 Parts& parts) const override {
    parts.access.emplace();
    for (const Measured::Series& series : measured.series) {
      const std::size_t slash = series.name.rfind('/');
      const auto per_voxel = [&](const std::vector<double>& seconds) {
        std::vector<double> ns;
        for (const double s : seconds) ns.push_back(1e9 * s / static_cast<double>(series.count));
        return ns;
      };
      parts.access->push_back(
          {.points = series.name.substr(0, slash),
           .lod = std::stoul(series.name.substr(slash + 1)),
           .count = series.count,
           .ns_per_voxel = describe_samples(per_voxel(series.wall_seconds)),
           .cpu_ns_per_voxel = summarize(per_voxel(series.cpu_seconds)).median});
    }
  }
  std::string headline(const Parts& parts) const override {
    if (parts.access->empty()) return "";
    return fmt::format("{:.4g} ns per voxel", parts.access->front().ns_per_voxel->median);
  }
};

}  // namespace

const StageKind& random_access_stage() {
  static const RandomAccessStage kStage;
  return kStage;
}

}  // namespace cvr::experiments
