// The decoder: windows in order, then components, ids and locations of a batch of slices side by
// side.
//
// The counts of components and locations of a slice follow from its boundary bits, so where its ids
// and locations begin is known before any label is. open() checks the list of windows and their
// words completely; whether ids, locations and boundary bits agree shows while decoding.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <deque>
#include <limits>
#include <mutex>
#include <new>
#include <optional>

#include "codecs/compresso/format.hpp"
#include "codecs/compresso/slice.hpp"
#include "codecs/compresso/windows.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs::compresso {

namespace {

constexpr std::uint64_t kBatchSlices = 32;

/// The parts of a payload, their sizes checked.
struct Parts {
  VolumeInfo info;
  WindowSize window;
  std::uint64_t id_count, window_count, location_count, word_count, word_size;
  const std::byte *windows, *ids, *locations, *words;

  std::uint64_t window_value(std::uint64_t index) const {
    return load_unsigned(windows, index, window.bytes());
  }
  std::uint64_t word(std::uint64_t index) const { return load_unsigned(words, index, word_size); }
};

struct Slice {
  BitPlane boundary;
  Components components;
  std::uint64_t first_id = 0;
  std::uint64_t location_voxels = 0;  ///< boundary voxels that need a location
};

/// Where the labels of a slice stand in the locations, and how many entries are its own.
struct LocationRange {
  std::uint64_t begin, end;
};

template <class T>
class Resolver {
 public:
  Resolver(const Parts& parts, const Slice& slice, const Slice* below, const Slice* above,
           LocationRange range, T* out)
      : parts_(parts),
        slice_(slice),
        below_(below),
        above_(above),
        next_(range.begin),
        end_(range.end),
        out_(out) {}

  Expected<void> resolve() {
    const BitPlane& boundary = slice_.boundary;
    const std::uint64_t width = boundary.width();
    for (std::uint64_t y = 0; y < boundary.height(); ++y) {
      T* row = out_ + y * width;
      for (const Run* run = slice_.components.begin(y); run != slice_.components.end(y); ++run) {
        std::fill(row + run->begin, row + run->end, id(slice_, run->component));
      }
    }
    for (std::uint64_t y = 0; y < boundary.height(); ++y) {
      T* row = out_ + y * width;
      const std::uint64_t* bits = boundary.row(y);
      for (std::uint64_t word = 0; word < boundary.row_words(); ++word) {
        const std::uint64_t open = unresolved_bits(boundary, word, y);
        const std::uint64_t left = (bits[word] << 1) | (word == 0 ? 1 : bits[word - 1] >> 63);
        for (std::uint64_t rest = bits[word]; rest != 0; rest &= rest - 1) {
          const std::uint64_t bit = rest & -rest;
          const std::uint64_t x = word * 64 + static_cast<std::uint64_t>(std::countr_zero(rest));
          if ((open & bit) != 0) {
            const auto label = locate(x, y);
            if (!label) return tl::unexpected(label.error());
            row[x] = *label;
          } else {
            row[x] = (left & bit) == 0 ? row[x - 1] : (row - width)[x];
          }
        }
      }
    }
    return {};
  }

 private:
  T id(const Slice& slice, std::uint64_t component) const {
    return load<T>(parts_.ids, slice.first_id + component);
  }
  T next() { return load<T>(parts_.locations, next_++); }

  Expected<T> locate(std::uint64_t x, std::uint64_t y) {
    const std::uint64_t width = slice_.boundary.width();
    const T* here = out_ + x + width * y;
    const T location = next();
    switch (location) {
      case Location::kRight:
        if (x + 1 < width && !slice_.boundary.test(x + 1, y)) return here[1];
        break;
      case Location::kLeft:
      case Location::kUp:
        break;
      case Location::kDown:
        if (y + 1 < slice_.boundary.height() && !slice_.boundary.test(x, y + 1)) return here[width];
        break;
      case Location::kBelow:
      case Location::kAbove: {
        const Slice* other = location == Location::kBelow ? below_ : above_;
        if (other != nullptr && !other->boundary.test(x, y))
          return id(*other, other->components.component_of(x, y));
        break;
      }
      case Location::kEscape:
        if (next_ < end_) return next();
        break;
      default:
        return static_cast<T>(location - Location::kExplicit);
    }
    return fail(ErrorCode::kMalformed,
                fmt::format("location {}: voxel {},{} has no such neighbour", next_ - 1, x, y));
  }

  const Parts& parts_;
  const Slice& slice_;
  const Slice* below_;
  const Slice* above_;
  std::uint64_t next_, end_;
  T* out_;
};

/// Decodes slices in ascending z.
template <class T>
class VolumeDecoder {
 public:
  VolumeDecoder(const Parts& parts, unsigned threads)
      : parts_(parts),
        extent_(parts.info.extent),
        grid_(window_grid(extent_, parts.window)),
        threads_(std::max(threads, 1u)) {}

  /// The slices [z0, z1): z0 is where the call before ended.
  Expected<void> decode(std::uint64_t z0, std::uint64_t z1, T* out) {
    if (auto ok = read_slices(std::min(z1 + 1, extent_.z)); !ok) return ok;
    std::vector<LocationRange> ranges;
    for (std::uint64_t z = z0; z < z1; ++z) {
      const auto range = next_locations(z);
      if (!range) return tl::unexpected(range.error());
      ranges.push_back(*range);
    }
    std::mutex mutex;
    std::optional<std::pair<std::uint64_t, Error>> first;
    volumes::parallel_for(threads_, z1 - z0, [&](unsigned, std::uint64_t i) {
      const std::uint64_t z = z0 + i;
      const auto done = Resolver<T>(parts_, slice(z), z > 0 ? &slice(z - 1) : nullptr,
                                    z + 1 < extent_.z ? &slice(z + 1) : nullptr, ranges[i],
                                    out + i * extent_.x * extent_.y)
                            .resolve();
      if (done) return;
      const std::scoped_lock lock(mutex);
      if (!first || first->first > i) first.emplace(i, done.error());
    });
    if (first)
      return fail(first->second.code,
                  fmt::format("slice {}: {}", z0 + first->first, first->second.message));
    while (base_ + 1 < z1) {
      spare_.push_back(std::move(slices_.front()));
      slices_.pop_front();
      ++base_;
    }
    return {};
  }

  Expected<void> finish() const {
    if (next_id_ == parts_.id_count && next_location_ == parts_.location_count) return {};
    return fail(ErrorCode::kMalformed,
                fmt::format("{} of {} ids and {} of {} locations are used", next_id_,
                            parts_.id_count, next_location_, parts_.location_count));
  }

 private:
  Slice& slice(std::uint64_t z) { return slices_[z - base_]; }

  /// Reads layers of windows until all slices below `end` are there, with their components.
  Expected<void> read_slices(std::uint64_t end) {
    const std::uint64_t first = base_ + slices_.size();
    while (base_ + slices_.size() < end) read_layer();
    const std::uint64_t last = base_ + slices_.size();
    volumes::parallel_for(threads_, last - first, [&](unsigned, std::uint64_t i) {
      Slice& s = slice(first + i);
      s.components.find(s.boundary);
      s.location_voxels = 0;
      for (std::uint64_t y = 0; y < extent_.y; ++y) {
        for (std::uint64_t word = 0; word < s.boundary.row_words(); ++word) {
          s.location_voxels +=
              static_cast<std::uint64_t>(std::popcount(unresolved_bits(s.boundary, word, y)));
        }
      }
    });
    for (std::uint64_t z = first; z < last; ++z) {
      Slice& s = slice(z);
      s.first_id = next_id_;
      if (s.components.count() > parts_.id_count - next_id_) {
        return fail(ErrorCode::kMalformed,
                    fmt::format("slice {}: {} components, {} ids are left", z, s.components.count(),
                                parts_.id_count - next_id_));
      }
      next_id_ += s.components.count();
    }
    return {};
  }

  void read_layer() {
    const std::uint64_t z0 = base_ + slices_.size();
    const std::uint64_t depth = std::min<std::uint64_t>(parts_.window.z, extent_.z - z0);
    layer_.resize(depth);
    for (std::uint64_t i = 0; i < depth; ++i) {
      if (!spare_.empty()) {
        slices_.push_back(std::move(spare_.back()));
        spare_.pop_back();
      } else {
        slices_.emplace_back();
      }
      layer_[i] = std::move(slices_.back().boundary);
      layer_[i].reset(extent_.x, extent_.y);
    }
    const std::uint64_t windows = grid_.x * grid_.y;
    for (std::uint64_t i = 0; i < windows;) {
      if (run_ == 0) {
        const std::uint64_t word = parts_.word(next_word_++);
        if ((word & 1) == 0) {
          scatter_window(parts_.window_value(word / 2), parts_.window, i % grid_.x, i / grid_.x,
                         layer_);
          ++i;
          continue;
        }
        run_ = word / 2;
      }
      const std::uint64_t skipped = std::min(run_, windows - i);
      run_ -= skipped;
      i += skipped;
    }
    for (std::uint64_t i = 0; i < depth; ++i) slice(z0 + i).boundary = std::move(layer_[i]);
  }

  /// An escape takes two entries, so the entries have to be walked.
  Expected<LocationRange> next_locations(std::uint64_t z) {
    LocationRange range{next_location_, next_location_};
    for (std::uint64_t i = 0; i < slice(z).location_voxels; ++i) {
      if (range.end >= parts_.location_count) {
        return fail(
            ErrorCode::kMalformed,
            fmt::format("slice {}: expected {} locations, found the end of the list after {}", z,
                        slice(z).location_voxels, i));
      }
      range.end += load<T>(parts_.locations, range.end) == Location::kEscape ? 2 : 1;
    }
    range.end = std::min(range.end, parts_.location_count);
    next_location_ = range.end;
    return range;
  }

  const Parts& parts_;
  Extent extent_;
  Extent grid_;
  unsigned threads_;
  std::deque<Slice> slices_;  ///< from slice base_ on
  std::vector<Slice> spare_;
  std::vector<BitPlane> layer_;
  std::uint64_t base_ = 0;
  std::uint64_t next_word_ = 0, run_ = 0;
  std::uint64_t next_id_ = 0, next_location_ = 0;
};

class CompressoDecoder final : public Decoder {
 public:
  explicit CompressoDecoder(const Parts& parts) : parts_(parts) {}

  Expected<void> decode(unsigned, unsigned threads, SlabSink& sink) const override {
    try {
      return volumes::with_label_type(parts_.info.type,
                                      [&]<class T>() { return decode_as<T>(threads, sink); });
    } catch (const std::bad_alloc&) {
      return fail(ErrorCode::kOutOfMemory,
                  "not enough memory for slices of " + to_string(parts_.info.extent));
    }
  }

 private:
  template <class T>
  Expected<void> decode_as(unsigned threads, SlabSink& sink) const {
    const Extent& extent = parts_.info.extent;
    VolumeDecoder<T> decoder(parts_, threads);
    const std::uint64_t depth = std::max<std::uint64_t>(1, sink.preferred_depth());
    for (std::uint64_t z0 = 0; z0 < extent.z;) {
      const std::uint64_t z1 = z0 + std::min(depth, extent.z - z0);
      auto* out = reinterpret_cast<T*>(sink.begin(z0, z1));
      for (std::uint64_t z = z0; z < z1; z += std::min(kBatchSlices, z1 - z)) {
        const std::uint64_t end = z + std::min(kBatchSlices, z1 - z);
        if (auto ok = decoder.decode(z, end, out + (z - z0) * extent.x * extent.y); !ok) return ok;
      }
      sink.end(z0, z1);
      z0 = z1;
    }
    return decoder.finish();
  }

  Parts parts_;
};

Expected<void> check_windows(const Parts& parts) {
  const std::uint32_t bits = parts.window.bits();
  for (std::uint64_t i = 0; i < parts.window_count; ++i) {
    const std::uint64_t value = parts.window_value(i);
    if ((bits < 64 && value >> bits != 0) || (i > 0 && value <= parts.window_value(i - 1))) {
      return fail(
          ErrorCode::kMalformed,
          fmt::format("window {}: expected {} bits, more than the window before, found {:#x}", i,
                      bits, value));
    }
  }
  const bool has_empty = parts.window_count > 0 && parts.window_value(0) == 0;
  const Extent grid = window_grid(parts.info.extent, parts.window);
  std::uint64_t left = grid.voxels();
  for (std::uint64_t i = 0; i < parts.word_count; ++i) {
    const std::uint64_t word = parts.word(i);
    const bool is_run = (word & 1) != 0;
    const std::uint64_t covered = is_run ? word / 2 : 1;
    if (covered == 0 || covered > left || (is_run ? !has_empty : word / 2 >= parts.window_count)) {
      return fail(
          ErrorCode::kMalformed,
          fmt::format("word {}: {:#x} is no window and no run of at most {}", i, word, left));
    }
    left -= covered;
  }
  if (left != 0)
    return fail(ErrorCode::kTruncated,
                fmt::format("expected {} windows, {} are missing", grid.voxels(), left));
  return {};
}

}  // namespace

Expected<std::unique_ptr<Decoder>> open_payload(const VolumeInfo& info, const WindowSize& window,
                                                std::span<const std::byte> payload) {
  if (payload.size() < PayloadLayout::kHeaderBytes) {
    return fail(ErrorCode::kTruncated, fmt::format("expected a header of {} bytes, found {}",
                                                   PayloadLayout::kHeaderBytes, payload.size()));
  }
  const auto field = [&](std::uint64_t at) { return load<std::uint64_t>(payload.data() + at, 0); };
  Parts parts{.info = info, .window = window};
  parts.id_count = field(PayloadLayout::kIds);
  parts.window_count = field(PayloadLayout::kWindows);
  parts.location_count = field(PayloadLayout::kLocations);
  parts.word_count = field(PayloadLayout::kWords);
  parts.word_size = load<std::uint32_t>(payload.data() + PayloadLayout::kWordBytes, 0);
  if (parts.word_size != parts.window.word_bytes(parts.window_count) ||
      load<std::uint32_t>(payload.data() + PayloadLayout::kZero, 0) != 0) {
    return fail(ErrorCode::kMalformed,
                fmt::format("offset {}: expected words of {} bytes and a zero, found {} and {}",
                            PayloadLayout::kWordBytes, parts.window.word_bytes(parts.window_count),
                            parts.word_size,
                            load<std::uint32_t>(payload.data() + PayloadLayout::kZero, 0)));
  }
  const std::byte* at = payload.data() + PayloadLayout::kHeaderBytes;
  std::uint64_t left = payload.size() - PayloadLayout::kHeaderBytes;
  const std::uint64_t voxel = size_of(info.type);
  const std::tuple<const char*, std::uint64_t, std::uint64_t, const std::byte**> sections[] = {
      {"ids", parts.id_count, voxel, &parts.ids},
      {"windows", parts.window_count, window.bytes(), &parts.windows},
      {"locations", parts.location_count, voxel, &parts.locations},
      {"words", parts.word_count, parts.word_size, &parts.words}};
  for (const auto& [name, count, size, start] : sections) {
    if (count > left / size) {
      return fail(ErrorCode::kTruncated, fmt::format("expected {} {} of {} bytes, found {} bytes",
                                                     count, name, size, left));
    }
    *start = at;
    at += count * size;
    left -= count * size;
  }
  if (left != 0)
    return fail(ErrorCode::kMalformed, fmt::format("{} bytes follow the payload", left));
  // Every slice has an id or a location, so an extent of absurdly many slices ends here.
  if (info.extent.z > parts.id_count + parts.location_count) {
    return fail(ErrorCode::kTruncated,
                fmt::format("expected ids and locations of {} slices, found {} and {}",
                            info.extent.z, parts.id_count, parts.location_count));
  }
  if (auto ok = check_windows(parts); !ok) return tl::unexpected(ok.error());
  return std::make_unique<CompressoDecoder>(parts);
}

}  // namespace cvr::codecs::compresso
