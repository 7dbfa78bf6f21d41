#include "volumes/io/array_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>

#include "volumes/io/gzip.hpp"
#include "volumes/io/text_voxels.hpp"

namespace cvr::volumes {

namespace {

void swap_bytes(std::span<std::byte> voxels, std::size_t width) {
  for (std::size_t at = 0; at < voxels.size(); at += width) {
    std::reverse(voxels.begin() + static_cast<std::ptrdiff_t>(at),
                 voxels.begin() + static_cast<std::ptrdiff_t>(at + width));
  }
}

/// Copies `count` voxels of Width bytes that lie `stride` voxels apart.
template <std::size_t Width>
void gather_row(const std::byte* from, std::uint64_t stride, std::uint64_t count, std::byte* to) {
  for (std::uint64_t i = 0; i < count; ++i)
    std::memcpy(to + i * Width, from + i * stride * Width, Width);
}

class ArraySource final : public VolumeSource {
 public:
  ArraySource(MappedFile file, const VolumeInfo& info, const ArrayLayout& layout,
              Provenance provenance, std::vector<std::string> other_files)
      : file_(std::move(file)),
        info_(info),
        layout_(layout),
        provenance_(std::move(provenance)),
        files_(std::move(other_files)) {
    if (std::ranges::find(files_, file_.path()) == files_.end()) files_.push_back(file_.path());
    check_size();
  }

  const VolumeInfo& info() const override { return info_; }
  Provenance provenance() const override { return provenance_; }
  std::vector<std::string> files() const override { return files_; }

  void read(const Box& box, std::byte* out) const override {
    if (layout_.encoding != ArrayEncoding::kPlain && decoded_.empty()) decode();
    const bool decoded = !decoded_.empty();
    if (!file_.whole()) {
      read_from_file(box, out);
    } else if (x_fastest()) {
      MemorySource(info_,
                   decoded ? decoded_.data() : file_.bytes().data() + layout_.offset + first_byte())
          .read(box, out);
    } else {
      gather(decoded ? decoded_.data() : file_.bytes().data() + layout_.offset, box, out);
    }
    if (!(decoded && x_fastest())) settle({out, box.size.voxels() * size_of(info_.type)}, box);
  }

  const std::byte* data() const override {
    if (!x_fastest() || !file_.whole()) return nullptr;
    if (!decoded_.empty()) return decoded_.data();
    const bool swapped = layout_.big_endian && size_of(info_.type) > 1;
    if (layout_.encoding != ArrayEncoding::kPlain || swapped || layout_.reject_negative ||
        layout_.whole_numbers) {
      return nullptr;
    }
    const std::byte* voxels = file_.bytes().data() + layout_.offset + first_byte();
    return reinterpret_cast<std::uintptr_t>(voxels) % size_of(info_.type) == 0 ? voxels : nullptr;
  }

 private:
  /// Whether the stored order is that of volumes.
  bool x_fastest() const {
    const Extent step = info_.step_extent();
    return layout_.strides == std::array{std::uint64_t{1}, step.x, step.x * step.y, step.voxels()};
  }

  /// Of the first voxel of the volume among the stored ones, where x is fastest.
  std::uint64_t first_byte() const {
    return layout_.first_step * layout_.strides[3] * size_of(info_.type);
  }

  void check_size() {
    const std::uint64_t size = file_.size();
    if (!file_.whole() && (layout_.encoding != ArrayEncoding::kPlain || !x_fastest())) {
      throw_input_error(file_.path(), "", "a compressed or reordered file that can be mapped whole",
                        fmt::format("{} bytes, more than this process may map", size));
    }
    const std::uint64_t coded = size - std::min(layout_.start, size);
    switch (layout_.encoding) {
      case ArrayEncoding::kGzip:
        return check_inflatable(
            file_.path(), coded,
            layout_.at_end ? layout_.stored_bytes : layout_.offset + layout_.stored_bytes);
      case ArrayEncoding::kHex:
        return check_digits(file_.path(), coded, layout_.stored_bytes);
      case ArrayEncoding::kText:
        return check_numbers(file_.path(), coded, layout_.stored_bytes / size_of(info_.type));
      case ArrayEncoding::kPlain:
        break;
    }
    const bool exact = layout_.offset <= size && layout_.stored_bytes == size - layout_.offset;
    if (layout_.at_end ? layout_.stored_bytes > size : !exact) {
      throw_input_error(
          file_.path(), layout_.at_end ? "" : fmt::format("byte {}", layout_.offset),
          fmt::format("{} bytes of voxels ({} voxels of {} bytes) and the end of the file",
                      layout_.stored_bytes, layout_.stored_bytes / size_of(info_.type),
                      size_of(info_.type)),
          layout_.offset > size
              ? fmt::format("a file of {} bytes", size)
              : fmt::format("{} bytes there, in a file of {} bytes", size - layout_.offset, size));
    }
    if (layout_.at_end) layout_.offset = size - layout_.stored_bytes;
  }

  /// All stored voxels, or of those with x fastest only what the volume has, and then settled.
  void decode() const {
    const bool whole = !x_fastest() || layout_.encoding != ArrayEncoding::kGzip;
    Buffer voxels(whole ? layout_.stored_bytes : info_.bytes());
    const std::uint64_t skipped = whole ? 0 : first_byte();
    const auto coded = file_.bytes().subspan(layout_.start);
    const auto text = file_.text().substr(layout_.start);
    if (layout_.encoding == ArrayEncoding::kHex) {
      read_hex_voxels(file_.path(), text, voxels.bytes());
    } else if (layout_.encoding == ArrayEncoding::kText) {
      read_text_voxels(file_.path(), text, layout_.stored, voxels.bytes());
    } else {
      std::uint64_t offset = layout_.offset;
      if (layout_.at_end) {
        const std::uint64_t size = inflated_size(file_.path(), coded);
        if (size < layout_.stored_bytes) {
          throw_input_error(file_.path(), "gzip stream",
                            fmt::format("at least {} inflated bytes", layout_.stored_bytes),
                            fmt::format("{}", size));
        }
        offset = size - layout_.stored_bytes;
      }
      inflate_exactly(file_.path(), coded, offset + skipped, voxels.bytes(),
                      layout_.stored_bytes - voxels.size() - skipped);
    }
    if (x_fastest()) {
      if (whole && voxels.size() != info_.bytes()) {  // some steps of a series
        std::memmove(voxels.data(), voxels.data() + first_byte(), info_.bytes());
        voxels.resize(info_.bytes());
      }
      settle(voxels.bytes(), {{0, 0, 0}, info_.extent});
    }
    decoded_ = std::move(voxels);
  }

  /// Of a file that is not mapped whole: in pieces as long as lie together.
  void read_from_file(const Box& box, std::byte* out) const {
    const Extent& extent = info_.extent;
    const std::size_t voxel = size_of(info_.type);
    const bool whole_rows = box.size.x == extent.x;
    const std::uint64_t rows = whole_rows ? box.size.y : 1;
    const std::uint64_t planes = whole_rows && box.size.y == extent.y ? box.size.z : 1;
    const std::size_t piece = box.size.x * rows * planes * voxel;
    for (std::uint64_t z = 0; z < box.size.z; z += planes) {
      for (std::uint64_t y = 0; y < box.size.y; y += rows) {
        const Coordinate start{box.origin.x, box.origin.y + y, box.origin.z + z};
        file_.read(layout_.offset + first_byte() + extent.index(start) * voxel, {out, piece});
        out += piece;
      }
    }
  }

  void gather(const std::byte* stored, const Box& box, std::byte* out) const {
    const auto gather_voxels = [&]<std::size_t Width>() {
      const std::uint64_t depth = info_.step_extent().z;
      const auto& [sx, sy, sz, st] = layout_.strides;
      for (std::uint64_t z = box.origin.z; z < box.origin.z + box.size.z; ++z) {
        const std::uint64_t plane = (layout_.first_step + z / depth) * st + z % depth * sz;
        for (std::uint64_t y = box.origin.y; y < box.origin.y + box.size.y; ++y) {
          gather_row<Width>(stored + (plane + y * sy + box.origin.x * sx) * Width, sx, box.size.x,
                            out);
          out += box.size.x * Width;
        }
      }
    };
    switch (size_of(info_.type)) {
      case 1:
        return gather_voxels.template operator()<1>();
      case 2:
        return gather_voxels.template operator()<2>();
      case 4:
        return gather_voxels.template operator()<4>();
      default:
        return gather_voxels.template operator()<8>();
    }
  }

  /// Native byte order, then what needs it.
  void settle(std::span<std::byte> voxels, const Box& box) const {
    const std::size_t width = size_of(info_.type);
    if (layout_.big_endian && width > 1) swap_bytes(voxels, width);
    if (layout_.reject_negative) reject_negative_voxels(file_.path(), voxels, width, &box);
    if (layout_.whole_numbers) labels_from_floats(file_.path(), voxels, width, box);
  }

  MappedFile file_;
  VolumeInfo info_;
  ArrayLayout layout_;
  Provenance provenance_;
  std::vector<std::string> files_;
  mutable Buffer decoded_;
};

}  // namespace

std::unique_ptr<VolumeSource> open_array(MappedFile file, const VolumeInfo& info,
                                         const ArrayLayout& layout, Provenance provenance,
                                         std::vector<std::string> other_files) {
  return std::make_unique<ArraySource>(std::move(file), info, layout, std::move(provenance),
                                       std::move(other_files));
}

}  // namespace cvr::volumes
