// The encoder: batches of slices, each slice on its own, the windows of all slices at the end.
#include <fmt/format.h>

#include <algorithm>

#include "codecs/bytes.hpp"
#include "codecs/compresso/format.hpp"
#include "codecs/compresso/slice.hpp"
#include "codecs/compresso/windows.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs::compresso {

namespace {

/// Slices that are encoded side by side; rounded up to whole windows.
constexpr std::uint64_t kBatchSlices = 32;

/// Three planes of labels and boundary bits around a slice; the outer ones are absent at the
/// volume's ends.
template <class T>
struct Neighbourhood {
  const T* labels;
  const T* below_labels;
  const T* above_labels;
  const BitPlane* bits;
  const BitPlane* below_bits;
  const BitPlane* above_bits;
};

/// The location of the unresolved boundary voxel (x, y). Its left and upper neighbours are boundary
/// or outside.
template <class T>
std::uint64_t neighbour_code(const Neighbourhood<T>& n, std::uint64_t x, std::uint64_t y) {
  const std::uint64_t width = n.bits->width();
  const std::uint64_t at = x + width * y;
  const T label = n.labels[at];
  if (x + 1 < width && n.labels[at + 1] == label && !n.bits->test(x + 1, y))
    return Location::kRight;
  if (y + 1 < n.bits->height() && n.labels[at + width] == label && !n.bits->test(x, y + 1))
    return Location::kDown;
  if (n.below_labels != nullptr && n.below_labels[at] == label && !n.below_bits->test(x, y))
    return Location::kBelow;
  if (n.above_labels != nullptr && n.above_labels[at] == label && !n.above_bits->test(x, y))
    return Location::kAbove;
  return Location::kExplicit;
}

template <class T>
struct SliceCode {
  Components components;
  std::vector<T> ids;
  std::vector<T> locations;

  void encode(const Neighbourhood<T>& n) {
    const std::uint64_t width = n.bits->width();
    components.find(*n.bits);
    ids.clear();
    ids.reserve(components.count());
    for (const auto& [x, y] : components.firsts()) ids.push_back(n.labels[x + width * y]);
    locations.clear();
    for (std::uint64_t y = 0; y < n.bits->height(); ++y) {
      for (std::uint64_t word = 0; word < n.bits->row_words(); ++word) {
        for (std::uint64_t open = unresolved_bits(*n.bits, word, y); open != 0; open &= open - 1) {
          add_location(n, word * 64 + static_cast<std::uint64_t>(std::countr_zero(open)), y);
        }
      }
    }
  }

 private:
  void add_location(const Neighbourhood<T>& n, std::uint64_t x, std::uint64_t y) {
    const std::uint64_t code = neighbour_code(n, x, y);
    const T label = n.labels[x + n.bits->width() * y];
    if (code < Location::kEscape) {
      locations.push_back(static_cast<T>(code));
    } else if (label <= std::numeric_limits<T>::max() - Location::kExplicit) {
      locations.push_back(static_cast<T>(label + Location::kExplicit));
    } else {
      locations.push_back(static_cast<T>(Location::kEscape));
      locations.push_back(label);
    }
  }
};

template <class T>
class VolumeEncoder {
 public:
  VolumeEncoder(const VolumeSource& source, const WindowSize& window, unsigned threads)
      : extent_(source.info().extent),
        window_(window),
        grid_(window_grid(extent_, window)),
        threads_(std::max(threads, 1u)),
        batch_((kBatchSlices + window.z - 1) / window.z * window.z),
        reader_(source),
        bits_(std::min(batch_ + 2, extent_.z)),
        slices_(std::min(batch_, extent_.z)) {}

  Expected<Payload> encode() {
    for (std::uint64_t z0 = 0; z0 < extent_.z; z0 += batch_) {
      encode_batch(z0, std::min(z0 + batch_, extent_.z));
      if (!windows_fit_) return fail(ErrorCode::kTooLarge, "more than 2^31 - 1 distinct windows");
    }
    return assemble();
  }

 private:
  void encode_batch(std::uint64_t z0, std::uint64_t z1) {
    const std::uint64_t lo = z0 == 0 ? 0 : z0 - 1, hi = std::min(z1 + 1, extent_.z);
    const std::uint64_t plane = extent_.x * extent_.y;
    const T* labels = reinterpret_cast<const T*>(reader_.read(lo, hi));
    // The first planes of this batch are the last ones of the batch before.
    const std::uint64_t known = known_to_ - lo;
    for (std::uint64_t i = 0; i < known; ++i) std::swap(bits_[i], bits_[lo - known_from_ + i]);
    volumes::parallel_for(threads_, hi - lo - known, [&](unsigned, std::uint64_t i) {
      mark_boundaries(labels + (known + i) * plane, extent_.x, extent_.y, bits_[known + i]);
    });
    known_from_ = lo;
    known_to_ = hi;
    volumes::parallel_for(threads_, z1 - z0, [&](unsigned, std::uint64_t i) {
      const std::uint64_t z = z0 + i, at = z - lo;
      const bool below = z > 0, above = z + 1 < extent_.z;
      const T* here = labels + at * plane;
      slices_[i].encode({here, below ? here - plane : nullptr, above ? here + plane : nullptr,
                         &bits_[at], below ? &bits_[at - 1] : nullptr,
                         above ? &bits_[at + 1] : nullptr});
    });
    for (std::uint64_t i = 0; i < z1 - z0; ++i) {
      ids_.append(slices_[i].ids.data(), slices_[i].ids.size() * sizeof(T));
      locations_.append(slices_[i].locations.data(), slices_[i].locations.size() * sizeof(T));
    }
    for (std::uint64_t z = z0; z < z1; z += window_.z) {
      append_windows(std::span(bits_).subspan(z - lo, std::min<std::uint64_t>(window_.z, z1 - z)));
    }
  }

  void append_windows(std::span<const BitPlane> layer) {
    layer_.resize(grid_.x * grid_.y);
    volumes::parallel_for(threads_, grid_.y, [&](unsigned, std::uint64_t wy) {
      gather_windows(layer, window_, wy, std::span(layer_).subspan(wy * grid_.x, grid_.x));
    });
    windows_fit_ = windows_fit_ && windows_.append(layer_);
  }

  Expected<Payload> assemble() {
    const std::vector<std::uint64_t>& windows = windows_.sort();
    const std::uint64_t bytes = window_.word_bytes(windows.size());
    Buffer words;
    windows_.write(bytes, words);
    ByteWriter out;
    out.put(std::uint64_t{ids_.size() / sizeof(T)});
    out.put(std::uint64_t{windows.size()});
    out.put(std::uint64_t{locations_.size() / sizeof(T)});
    out.put(std::uint64_t{words.size() / bytes});
    out.put(narrow<std::uint32_t>(bytes));
    out.put(std::uint32_t{0});
    Payload payload{out.take(), {}, 0};
    const auto append = [&payload](ByteClass use, Buffer& part) {
      payload.bytes.append(part.bytes());
      payload.breakdown[use] += part.size();
      part = Buffer();
    };
    payload.breakdown[ByteClass::kHeader] = PayloadLayout::kHeaderBytes;
    append(ByteClass::kPalette, ids_);
    Buffer list;
    for (const std::uint64_t window : windows) list.append(&window, window_.bytes());
    append(ByteClass::kTables, list);
    append(ByteClass::kOperations, locations_);
    append(ByteClass::kOperations, words);
    payload.published_bytes = payload.bytes.size();
    return payload;
  }

  Extent extent_;
  WindowSize window_;
  Extent grid_;
  unsigned threads_;
  std::uint64_t batch_;
  volumes::SlabReader reader_;
  std::vector<BitPlane> bits_;  ///< of the slices known_from_ <= z < known_to_
  std::uint64_t known_from_ = 0, known_to_ = 0;
  std::vector<SliceCode<T>> slices_;
  std::vector<std::uint64_t> layer_;
  WindowStream windows_;
  bool windows_fit_ = true;
  Buffer ids_, locations_;
};

}  // namespace

Expected<Payload> encode_payload(const VolumeSource& source, const WindowSize& window,
                                 unsigned threads) {
  return volumes::with_label_type(source.info().type, [&]<class T>() {
    return VolumeEncoder<T>(source, window, threads).encode();
  });
}

}  // namespace cvr::codecs::compresso
