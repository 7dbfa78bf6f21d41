// Shares of files are those of the generators' cells and turbulence; work memory was measured on
// volumes of 64^3 to 144^3 voxels, with one thread.
#include "codecs/estimates.hpp"

#include <lzma.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace cvr::codecs {

namespace {

constexpr double kMiB = 1 << 20;

struct Work {
  const VolumeInfo& info;
  const Parameters& parameters;
  double threads;

  double volume() const { return static_cast<double>(info.bytes()); }
  double voxels() const { return static_cast<double>(info.extent.voxels()); }
  double planes(double depth) const {
    return volume() * std::min(1.0, depth / static_cast<double>(info.extent.z));
  }
  /// One value for labels, one for scalars of integers, one for floats.
  double share(double labels, double integers, double floats) const {
    return info.kind == VolumeKind::kLabels ? labels
           : info.type == VoxelType::kF32   ? floats
                                            : integers;
  }
  double integer(std::string_view name) const {
    return static_cast<double>(parameters.integer(name));
  }
};

MemoryEstimate raw(const Work& w) { return {.file = w.volume(), .access_ns = 8.8}; }

MemoryEstimate zstd(const Work& w) {
  // Window and tables double about every third level.
  const double tables = std::min(3 * kMiB * std::exp2((w.integer("level") - 3) / 3), 600 * kMiB);
  return {.file = w.volume() * w.share(0.055, 0.75, 0.88),
          .encode = 0.5 * kMiB + tables,
          .decode = 0.5 * kMiB + std::min(tables, 0.3 * w.volume())};
}

/// An encoder of liblzma touches its tables as it goes through its dictionary.
double xz_encoder(double preset, double bytes) {
  const auto whole =
      static_cast<double>(lzma_easy_encoder_memusage(static_cast<std::uint32_t>(preset)));
  return std::min(whole, 15.5 * kMiB + 9.5 * bytes);
}
double xz_decoder(double preset, double bytes) {
  const auto whole =
      static_cast<double>(lzma_easy_decoder_memusage(static_cast<std::uint32_t>(preset)));
  return std::min(whole, 0.4 * kMiB + bytes);
}

MemoryEstimate lzma(const Work& w) {
  const double preset = w.integer("level");
  return {.file = w.volume() * w.share(0.03, 0.7, 0.85),
          .encode = xz_encoder(preset, w.volume()),
          .decode = xz_decoder(preset, w.volume())};
}

MemoryEstimate hdf5_gzip(const Work& w) {
  const double file = w.volume() * w.share(0.06, 0.75, 0.88);
  return {
      .file = file, .encode = 4.5 * kMiB + w.threads * kMiB / 2, .decode = w.threads * kMiB / 2};
}

MemoryEstimate neuroglancer(const Work& w) {
  return {.file = w.volume() * 0.12,
          .encode = 1.6 * kMiB,
          .decode = 0.4 * kMiB,
          .open = 0.4 * kMiB,
          .access_ns = 17.5,
          .levels = w.integer("levels")};
}

MemoryEstimate compresso(const Work& w) {
  return {.file = w.volume() * 0.08,
          .encode = 2.5 * w.planes(16) + 1.6 * w.voxels(),
          .decode = 0.4 * kMiB + 2 * w.planes(16)};
}

MemoryEstimate compresso_lzma(const Work& w) {
  MemoryEstimate inner = compresso(w);
  const double payload = inner.file;
  inner.encode += payload + xz_encoder(6, payload);
  inner.decode += payload;
  inner.file = w.volume() * 0.022;
  return inner;
}

/// Bricks: grids of each thread, of 64-bit labels the narrowed slab.
MemoryEstimate bricks(const Work& w, double share, double kept) {
  const double edge = w.integer("brick");
  const double grids = 24 * edge * edge * edge * w.threads;
  const double narrowed = w.info.type == VoxelType::kU64 ? w.planes(64) / 2 : 0;
  return {.file = w.volume() * share,
          .encode = 0.5 * kMiB + grids + narrowed + kept * w.voxels(),
          .decode = 0.4 * kMiB + grids / 4,
          .open = 0.4 * kMiB + grids / 4,
          .access_ns = 300,
          .levels = std::log2(edge) + 1};
}
MemoryEstimate csgv_nibble(const Work& w) { return bricks(w, 0.063, 0); }
MemoryEstimate csgv_rans(const Work& w) { return bricks(w, 0.028, 0); }
MemoryEstimate csgv_ctx(const Work& w) {
  MemoryEstimate need = bricks(w, 0.014, 0);
  need.encode += 5 * kMiB;  // counts of the sampled bricks
  return need;
}
MemoryEstimate csgvr_nibble(const Work& w) { return bricks(w, 0.15, 0); }
MemoryEstimate csgvr(const Work& w) { return bricks(w, 0.05, 0); }
MemoryEstimate csgvr_c(const Work& w) { return bricks(w, 0.023, 1); }

/// Vector quantisers hold the blocks of a time step or sub-volume as floats, their residuals and
/// codes (bytes per voxel), and what they train with (MiB).
MemoryEstimate quantiser(const Work& w, double bits, double training, double floats) {
  const double edge = w.integer("edge");
  const double step = static_cast<double>(w.info.step_extent().voxels());
  const double part = edge == 0 ? step : std::min(step, edge * edge * edge);
  const double rate = w.integer("rate") > 0 ? w.integer("rate") / 1000 : bits;
  const double file = w.voxels() * rate / 8;
  return {.file = file,
          .encode = training * kMiB + floats * part,
          .decode = 0.7 * kMiB + file,
          .open = 0.7 * kMiB + file,
          .access_ns = 16};
}
MemoryEstimate vq(const Work& w) { return quantiser(w, w.integer("bits") / 64, 2.3, 9.5); }
MemoryEstimate hvq(const Work& w) {
  return quantiser(w, (w.integer("octants") + w.integer("voxels") + 8) / 64, 2.4, 9);
}
MemoryEstimate tvq(const Work& w) { return quantiser(w, 0.55, 6, 8); }

/// Blocks of scalars: a slab's words, and what each thread codes with.
MemoryEstimate blocks(const Work& w, double bits_a_voxel, double largest_bits_a_voxel,
                      double encoder, double coder, double ns) {
  const double slab = std::min(4 * kMiB + w.planes(4), w.volume());
  const double words = slab / static_cast<double>(size_of(w.info.type)) * largest_bits_a_voxel / 8;
  return {.file = w.voxels() * bits_a_voxel / 8,
          .encode = words + encoder * w.threads,
          .decode = coder * w.threads,
          .open = coder,
          .access_ns = ns};
}
MemoryEstimate zfp(const Work& w) {
  if (w.parameters.text("mode") == "accuracy") return blocks(w, 10, 36, kMiB / 2, kMiB / 2, 300);
  const double bits = w.integer("block_bits") / 64;
  return blocks(w, bits, bits, kMiB / 2, kMiB / 2, 200);
}
MemoryEstimate astc(const Work& w) {
  const double edge = w.integer("edge");
  const double bits = 128 / (edge * edge * edge);
  return blocks(w, bits, bits, 71 * kMiB, 18 * kMiB, 500);
}
MemoryEstimate bc4(const Work& w) { return blocks(w, 4, 4, kMiB / 2, kMiB / 2, 24); }

struct Entry {
  std::string_view id;
  MemoryEstimate (*memory)(const Work&);
};

constexpr std::array kEntries{
    Entry{"raw", raw},
    Entry{"zstd", zstd},
    Entry{"lzma", lzma},
    Entry{"hdf5-gzip", hdf5_gzip},
    Entry{"neuroglancer", neuroglancer},
    Entry{"compresso", compresso},
    Entry{"compresso-lzma", compresso_lzma},
    Entry{"csgv-nibble", csgv_nibble},
    Entry{"csgv-rans", csgv_rans},
    Entry{"csgv-ctx", csgv_ctx},
    Entry{"csgvr-nibble", csgvr_nibble},
    Entry{"csgvr", csgvr},
    Entry{"csgvr-sb", csgvr},
    Entry{"csgvr-c", csgvr_c},
    Entry{"vq", vq},
    Entry{"hvq", hvq},
    Entry{"tvq", tvq},
    Entry{"zfp", zfp},
    Entry{"astc", astc},
    Entry{"bc4", bc4},
};

const Entry* entry_of(const Codec& codec) {
  const auto found = std::ranges::find(kEntries, codec.traits().id, &Entry::id);
  return found == kEntries.end() ? nullptr : found;
}

}  // namespace

MemoryEstimate estimate_memory(const Codec& codec, const VolumeInfo& info,
                               const Parameters& parameters, unsigned threads) {
  const Work work{info, parameters, static_cast<double>(std::max(threads, 1u))};
  if (const Entry* entry = entry_of(codec)) return entry->memory(work);
  return {.file = work.volume() * work.share(0.1, 0.8, 0.9),
          .encode = work.planes(64),
          .decode = kMiB,
          .open = kMiB};
}

}  // namespace cvr::codecs
