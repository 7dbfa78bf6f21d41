#include "volumes/io/array_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "volumes/io/format.hpp"
#include "volumes/io/gzip.hpp"

namespace cvr::volumes {

namespace {

void swap_bytes(std::span<std::byte> voxels, std::size_t width) {
  for (std::size_t at = 0; at < voxels.size(); at += width) {
    std::reverse(voxels.begin() + static_cast<std::ptrdiff_t>(at),
                 voxels.begin() + static_cast<std::ptrdiff_t>(at + width));
  }
}

class ArraySource final : public VolumeSource {
 public:
  ArraySource(MappedFile file, const VolumeInfo& info, const ArrayLayout& layout, Provenance provenance)
      : file_(std::move(file)), info_(info), layout_(layout), provenance_(std::move(provenance)) {
    const std::uint64_t size = file_.size();
    if (layout_.gzip_start && !file_.whole()) {
      throw_input_error(file_.path(), "", "a compressed file that can be mapped whole",
                        fmt::format("{} bytes, more than this process may map", size));
    }
    if (layout_.gzip_start) {
      check_inflatable(file_.path(), size - std::min(*layout_.gzip_start, size), info_.bytes());
    } else if (layout_.offset > size || info_.bytes() > size - layout_.offset) {
      throw_input_error(file_.path(), fmt::format("byte {}", layout_.offset),
                        fmt::format("{} bytes of voxels ({} of type {})", info_.bytes(),
                                    to_string(info_.extent), name_of(info_.type)),
                        fmt::format("a file of {} bytes", size));
    }
  }

  const VolumeInfo& info() const override { return info_; }
  Provenance provenance() const override { return provenance_; }

  void read(const Box& box, std::byte* out) const override {
    if (layout_.gzip_start && inflated_.empty()) inflate_voxels();
    if (!file_.whole()) {
      read_from_file(box, out);
    } else {
      const std::byte* voxels = inflated_.empty() ? file_.bytes().data() + layout_.offset : inflated_.data();
      MemorySource(info_, voxels).read(box, out);
    }
    if (inflated_.empty()) settle({out, box.size.voxels() * size_of(info_.type)});
  }

  const std::byte* data() const override {
    if (!inflated_.empty()) return inflated_.data();
    if (!file_.whole() || layout_.gzip_start || (layout_.big_endian && size_of(info_.type) > 1) || layout_.reject_negative)
      return nullptr;
    const std::byte* voxels = file_.bytes().data() + layout_.offset;
    return reinterpret_cast<std::uintptr_t>(voxels) % size_of(info_.type) == 0 ? voxels : nullptr;
  }

 private:
  void inflate_voxels() const {
    Buffer voxels(info_.bytes());
    inflate_range(file_.path(), file_.bytes().subspan(*layout_.gzip_start), layout_.offset, voxels.bytes());
    settle(voxels.bytes());
    inflated_ = std::move(voxels);
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
        file_.read(layout_.offset + extent.index(start) * voxel, {out, piece});
        out += piece;
      }
    }
  }

  /// Native byte order, then the check that needs it.
  void settle(std::span<std::byte> voxels) const {
    const std::size_t width = size_of(info_.type);
    if (layout_.big_endian && width > 1) swap_bytes(voxels, width);
    if (layout_.reject_negative) reject_negative_voxels(file_.path(), voxels, width);
  }

  MappedFile file_;
  VolumeInfo info_;
  ArrayLayout layout_;
  Provenance provenance_;
  mutable Buffer inflated_;
};

}  // namespace

std::unique_ptr<VolumeSource> open_array(MappedFile file, const VolumeInfo& info, const ArrayLayout& layout,
                                         Provenance provenance) {
  return std::make_unique<ArraySource>(std::move(file), info, layout, std::move(provenance));
}

}  // namespace cvr::volumes
