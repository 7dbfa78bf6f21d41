// The decoding half of the brick frame: whole levels, single bricks and single voxels of an opened
// payload.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>

#include "codecs/csgv/brick_codec.hpp"
#include "codecs/csgv/brick_gpu.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs::csgv {

namespace {

using volumes::parallel_for;

/// Workspaces of single bricks, which are as large as what they are for: kept from call to call.
class WorkspacePool {
 public:
  class Lent {
   public:
    Lent(WorkspacePool& pool, std::unique_ptr<BrickWorkspace> workspace)
        : pool_(pool), workspace_(std::move(workspace)) {}
    Lent(const Lent&) = delete;
    Lent& operator=(const Lent&) = delete;
    ~Lent() {
      const std::scoped_lock lock(pool_.mutex_);
      pool_.free_.push_back(std::move(workspace_));
    }
    BrickWorkspace& operator*() const { return *workspace_; }

   private:
    WorkspacePool& pool_;
    std::unique_ptr<BrickWorkspace> workspace_;
  };

  Lent take(std::uint32_t brick) {
    const std::scoped_lock lock(mutex_);
    if (free_.empty()) return {*this, std::make_unique<BrickWorkspace>(brick)};
    auto workspace = std::move(free_.back());
    free_.pop_back();
    return {*this, std::move(workspace)};
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<BrickWorkspace>> free_;
};

class BrickDecoder final : public Decoder, public VoxelAccess, public BrickAccess {
 public:
  BrickDecoder(const VolumeInfo& info, BrickLayout layout, std::span<const std::uint64_t> remap,
               std::unique_ptr<const BrickReader> reader)
      : info_(info),
        layout_(layout),
        remap_(remap),
        reader_(std::move(reader)),
        voxels_(reader_->voxels()) {}

  unsigned levels() const override { return layout_.levels; }
  const VoxelAccess* voxel_access() const override { return voxels_ != nullptr ? this : nullptr; }
  const BrickAccess* brick_access() const override { return this; }
  Extent brick_size() const override { return {layout_.brick, layout_.brick, layout_.brick}; }
  Extent brick_grid() const override { return layout_.grid; }

  Expected<void> decode(unsigned lod, unsigned threads, SlabSink& sink) const override;
  Expected<void> decode_brick(const Coordinate& brick, unsigned lod, std::byte* out) const override;
  Expected<std::optional<std::uint64_t>> only_label(const Coordinate& brick) const override;
  Expected<void> at(std::span<const Coordinate> points, unsigned lod,
                    std::span<std::uint64_t> labels) const override;
  Expected<std::optional<std::uint64_t>> entropy_bytes(unsigned threads) const override;
  Expected<GpuEncoding> gpu_encoding(std::uint32_t brick, unsigned threads) const override {
    return csgv::gpu_encoding(layout_, remap_, *reader_, brick, threads);
  }

 private:
  BrickError decode_to(const Coordinate& brick, unsigned lod, std::byte* out, std::uint64_t row,
                       std::uint64_t plane, BrickWorkspace& workspace) const;
  Error malformed(std::uint64_t brick, BrickError what) const {
    const Extent& grid = layout_.grid;
    const Coordinate at = grid.coordinate(brick);
    const std::uint32_t word = layout_.starts[layout_.group_index(layout_.group_at(at))];
    return {ErrorCode::kMalformed, fmt::format("brick {} (word {}): {}", brick, word, what)};
  }
  Expected<void> check_lod(unsigned lod) const {
    if (lod < layout_.levels) return {};
    return fail(ErrorCode::kBadArgument,
                fmt::format("level of detail: expected 0..{}, found {}", layout_.levels - 1, lod));
  }

  VolumeInfo info_;
  BrickLayout layout_;
  std::span<const std::uint64_t> remap_;
  std::unique_ptr<const BrickReader> reader_;
  const VoxelReader* voxels_;  ///< facet of the reader
  mutable WorkspacePool pool_;
};

/// Writes a brick's voxels of a level to `out`, rows and planes that many voxels apart.
BrickError BrickDecoder::decode_to(const Coordinate& brick, unsigned lod, std::byte* out,
                                   std::uint64_t row, std::uint64_t plane,
                                   BrickWorkspace& workspace) const {
  const unsigned level = layout_.levels - 1 - lod;
  const Validity validity(layout_.brick, layout_.brick_extent(brick));
  if (BrickError error = reader_->unpack(layout_.stored(brick), validity, level, workspace))
    return error;
  const BrickExtent& nodes = validity.nodes(level);
  volumes::with_label_type(info_.type, [&]<class T>() {
    workspace.grid.scatter(level, nodes, reinterpret_cast<T*>(out), row, plane);
  });
  if (remap_.empty()) return nullptr;
  auto* labels = reinterpret_cast<std::uint64_t*>(out);
  for (std::uint32_t z = 0; z < nodes.z; ++z) {
    for (std::uint32_t y = 0; y < nodes.y; ++y) {
      for (std::uint64_t *label = labels + y * row + z * plane, *end = label + nodes.x; label < end;
           ++label) {
        if (*label >= remap_.size()) return "a label leaves the remap table";
        *label = remap_[*label];
      }
    }
  }
  return nullptr;
}

Expected<void> BrickDecoder::decode(unsigned lod, unsigned threads, SlabSink& sink) const {
  if (auto ok = check_lod(lod); !ok) return ok;
  const Extent level = level_extent(layout_.extent, lod);
  const std::uint64_t side = layout_.brick >> lod;
  const std::size_t voxel = size_of(info_.type);
  const std::uint64_t layers_a_slab = std::max<std::uint64_t>(sink.preferred_depth() / side, 1);
  std::vector<std::unique_ptr<BrickWorkspace>> workspaces(std::max(1u, threads));
  std::mutex first_mutex;
  std::uint64_t first_bad = layout_.grid.voxels();
  BrickError first_error = nullptr;
  for (std::uint64_t layer = 0; layer < layout_.grid.z && first_error == nullptr;
       layer += layers_a_slab) {
    const std::uint64_t layers = std::min(layers_a_slab, layout_.grid.z - layer);
    const std::uint64_t z0 = layer * side;
    const std::uint64_t z1 = std::min((layer + layers) * side, level.z);
    std::byte* slab = sink.begin(z0, z1);
    parallel_for(
        threads, layout_.grid.x * layout_.grid.y * layers, [&](unsigned w, std::uint64_t i) {
          if (!workspaces[w]) workspaces[w] = std::make_unique<BrickWorkspace>(layout_.brick);
          const Coordinate brick{i % layout_.grid.x, i / layout_.grid.x % layout_.grid.y,
                                 layer + i / (layout_.grid.x * layout_.grid.y)};
          const std::uint64_t at =
              brick.x * side + level.x * (brick.y * side + level.y * (brick.z * side - z0));
          if (BrickError error = decode_to(brick, lod, slab + at * voxel, level.x,
                                           level.x * level.y, *workspaces[w])) {
            const std::scoped_lock lock(first_mutex);
            if (layout_.index(brick) < first_bad) {
              first_bad = layout_.index(brick);
              first_error = error;
            }
          }
        });
    sink.end(z0, z1);
  }
  if (first_error != nullptr) return tl::unexpected(malformed(first_bad, first_error));
  return {};
}

Expected<void> BrickDecoder::decode_brick(const Coordinate& brick, unsigned lod,
                                          std::byte* out) const {
  if (auto ok = check_lod(lod); !ok) return ok;
  if (!layout_.grid.contains(brick)) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("brick ({}, {}, {}): outside the grid of {}", brick.x, brick.y, brick.z,
                            to_string(layout_.grid)));
  }
  const WorkspacePool::Lent workspace = pool_.take(layout_.brick);
  const BrickExtent nodes =
      Validity(layout_.brick, layout_.brick_extent(brick)).nodes(layout_.levels - 1 - lod);
  if (BrickError error =
          decode_to(brick, lod, out, nodes.x, std::uint64_t{nodes.x} * nodes.y, *workspace)) {
    return tl::unexpected(malformed(layout_.index(brick), error));
  }
  return {};
}

/// A brick that is a group of its own says how many labels it has (append_level_starts): all that it
/// decodes to stand in its palette, so one entry is the label of every voxel.
Expected<std::optional<std::uint64_t>> BrickDecoder::only_label(const Coordinate& brick) const {
  if (!layout_.grid.contains(brick))
    return fail(ErrorCode::kBadArgument,
                fmt::format("brick ({}, {}, {}): outside the grid of {}", brick.x, brick.y, brick.z,
                            to_string(layout_.grid)));
  if (layout_.group > 1) return std::nullopt;
  const std::span<const std::uint32_t> words = layout_.stored(brick).words;
  if (words.size() <= layout_.levels + 1 || words[layout_.levels] != 1) return std::nullopt;
  const std::uint64_t label = words.back();
  if (remap_.empty()) return label;
  if (label >= remap_.size())
    return tl::unexpected(malformed(layout_.index(brick), "a label leaves the remap table"));
  return remap_[label];
}

Expected<void> BrickDecoder::at(std::span<const Coordinate> points, unsigned lod,
                                std::span<std::uint64_t> labels) const {
  if (auto ok = check_lod(lod); !ok) return ok;
  if (BrickError error = voxels_->at(layout_, points, layout_.levels - 1 - lod, labels)) {
    return fail(ErrorCode::kMalformed, error);
  }
  if (remap_.empty()) return {};
  for (std::uint64_t& label : labels) {
    if (label >= remap_.size())
      return fail(ErrorCode::kMalformed, "a label leaves the remap table");
    label = remap_[label];
  }
  return {};
}

Expected<std::optional<std::uint64_t>> BrickDecoder::entropy_bytes(unsigned threads) const {
  const EntropyTally* entropy = reader_->entropy();
  if (entropy == nullptr) return std::nullopt;
  threads = std::max(1u, threads);
  std::vector<std::unique_ptr<BrickWorkspace>> workspaces(threads);
  std::vector<SymbolTally> tallies(threads);
  std::atomic<BrickError> wrong = nullptr;
  const Extent& grid = layout_.grid;
  parallel_for(threads, grid.voxels(), [&](unsigned w, std::uint64_t i) {
    if (!workspaces[w]) workspaces[w] = std::make_unique<BrickWorkspace>(layout_.brick);
    const Coordinate brick = grid.coordinate(i);
    const Validity validity(layout_.brick, layout_.brick_extent(brick));
    if (BrickError error =
            entropy->tally(layout_.stored(brick), validity, *workspaces[w], tallies[w]))
      wrong = error;
  });
  if (wrong != nullptr) return fail(ErrorCode::kMalformed, wrong.load());
  for (unsigned w = 1; w < threads; ++w) tallies[0].merge(tallies[w]);
  return static_cast<std::uint64_t>(tallies[0].entropy_bits() / 8);
}

template <class T>
std::span<const T> view(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}

}  // namespace

Expected<std::unique_ptr<Decoder>> BrickCodec::open(const Stream& stream) const {
  const auto format = make_format_(stream.parameters);
  BrickLayout layout(stream.info.extent, format->brick, format->group);
  const std::uint64_t groups = layout.groups.voxels();

  ByteReader in(stream.payload);
  const auto truncated = [&](std::string_view what) {
    return fail(ErrorCode::kTruncated,
                fmt::format("payload offset {}: the payload ends within {}", in.position(), what));
  };
  const auto remapped = in.get<std::uint64_t>();
  if (remapped > in.remaining() / 8) return truncated("the label table");
  const auto remap = view<std::uint64_t>(in.take(remapped * 8));
  if (!remap.empty() && stream.info.type != VoxelType::kU64) {
    return fail(ErrorCode::kMalformed,
                "payload offset 0: a label table belongs to volumes of u64 alone");
  }
  const auto table_bytes = in.get<std::uint32_t>();
  in.get<std::uint32_t>();
  ByteReader tables(in.take(table_bytes));
  if (in.failed()) return truncated("the frequency tables");
  auto reader = format->reader(tables);
  if (!reader) return tl::unexpected(reader.error());
  in.take((4 - in.position() % 4) % 4);
  if (groups >= in.remaining() / 4) return truncated("the start table");
  const auto starts = view<std::uint32_t>(in.take((groups + 1) * 4));
  const auto words = view<std::uint32_t>(in.take(in.remaining()));
  layout.starts = starts.data();
  layout.words = words.data();
  for (std::uint64_t i = 0; i < groups; ++i) {
    const std::string_view unit = layout.group == 1 ? "brick" : "group";
    if (starts[i] > starts[i + 1] || starts[i + 1] > words.size()) {
      return fail(ErrorCode::kMalformed,
                  fmt::format("start table: {} {} begins at word {} and ends at {} of {}", unit, i,
                              starts[i], starts[i + 1], words.size()));
    }
    const Extent& grid = layout.groups;
    const Extent bricks = layout.bricks_of_group(grid.coordinate(i));
    if (BrickError error = (*reader)->check(
            layout.group_words(i), static_cast<std::uint32_t>(bricks.voxels()), layout.levels)) {
      return fail(ErrorCode::kMalformed,
                  fmt::format("{} {} (word {}): {}", unit, i, starts[i], error));
    }
  }
  if (starts[0] != 0 || starts[groups] != words.size()) {
    return fail(ErrorCode::kMalformed, "start table: the bricks do not fill the payload");
  }
  return std::make_unique<BrickDecoder>(stream.info, layout, remap, *std::move(reader));
}

std::uint32_t brick_edge(const Parameters& parameters) {
  return static_cast<std::uint32_t>(parameters.integer("brick"));
}

ParameterSpec brick_parameter() {
  return {.name = "brick",
          .type = ParameterType::kInteger,
          .default_value = "32",
          .choices = {16, 32, 64},
          .description = "voxels per side of a brick"};
}

ParameterSpec delta_parameter() {
  return {.name = "delta",
          .type = ParameterType::kInteger,
          .default_value = "0",
          .minimum = 0,
          .maximum = 1,
          .description = "refer to older palette entries (operation 'palette delta')"};
}

Traits brick_traits(std::string_view id, std::string_view family, std::string_view summary,
                    Granularity access) {
  return {.id = id,
          .version = 1,
          .family = family,
          .summary = summary,
          .lossless = true,
          .types = volumes::kLabelTypes,
          .access = access,
          .levels_of_detail = true,
          .stored_compressed = false,
          .gpu_decodable = true,
          .front = {{ByteClass::kHeader, 16}, {ByteClass::kTables}, {ByteClass::kIndex, 0, 4}}};
}

}  // namespace cvr::codecs::csgv
