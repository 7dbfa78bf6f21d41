#include <fmt/format.h>

#include <new>
#include <stdexcept>

#include "codecs/general/hdf5_image.hpp"
#include "volumes/io/hdf5_handle.hpp"

namespace cvr::codecs::general {

using volumes::Hdf5Handle;
using volumes::Hdf5Session;

namespace {

/// The core driver grows the file by whole pieces of this size.
constexpr std::size_t kGrowth = std::size_t{1} << 20;

void* image_malloc(std::size_t size, H5FD_file_image_op_t, void* image) noexcept {
  try {
    static_cast<Buffer*>(image)->resize(size);
    return static_cast<Buffer*>(image)->data();
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void* image_realloc(void*, std::size_t size, H5FD_file_image_op_t operation, void* image) noexcept {
  return image_malloc(size, operation, image);
}
/// The buffer outlives the file.
herr_t image_keep(void*, H5FD_file_image_op_t, void*) noexcept { return 0; }
void* udata_share(void* image) noexcept { return image; }
herr_t udata_keep(void*) noexcept { return 0; }

void check(bool ok, const char* what) {
  if (!ok) throw std::runtime_error(fmt::format("HDF5: {}: {}", what, volumes::hdf5_reason()));
}

}  // namespace

Extent ChunkedDataset::grid() const {
  const auto up = [](std::uint64_t n, std::uint64_t d) { return n / d + (n % d != 0 ? 1 : 0); };
  return {up(info.extent.x, chunk.x), up(info.extent.y, chunk.y), up(info.extent.z, chunk.z)};
}

struct Hdf5ImageWriter::File {
  Buffer image;
  Hdf5Handle file, dataset;
};

Hdf5ImageWriter::Hdf5ImageWriter(const ChunkedDataset& dataset)
    : dataset_(dataset), file_(std::make_unique<File>()) {
  const Hdf5Session session;
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  check(H5Pset_fapl_core(access.get(), kGrowth, false) >= 0, "core driver");
  H5FD_file_image_callbacks_t callbacks{};
  callbacks.image_malloc = image_malloc;
  callbacks.image_realloc = image_realloc;
  callbacks.image_free = image_keep;
  callbacks.udata_copy = udata_share;
  callbacks.udata_free = udata_keep;
  callbacks.udata = &file_->image;
  check(H5Pset_file_image_callbacks(access.get(), &callbacks) >= 0, "file image callbacks");
  // The name is never opened: the core driver has no file behind it.
  file_->file = Hdf5Handle(H5Fcreate("image", H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose);
  check(file_->file.valid(), "create file");

  const Extent& e = dataset.info.extent;
  const hsize_t extent[3] = {e.z, e.y, e.x};
  const hsize_t chunk[3] = {dataset.chunk.z, dataset.chunk.y, dataset.chunk.x};
  const Hdf5Handle space(H5Screate_simple(3, extent, nullptr), H5Sclose);
  const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  check(H5Pset_obj_track_times(creation.get(), false) >= 0, "object times");
  check(H5Pset_chunk(creation.get(), 3, chunk) >= 0, "chunks");
  if (dataset.shuffle) check(H5Pset_shuffle(creation.get()) >= 0, "shuffle");
  check(H5Pset_deflate(creation.get(), dataset.level) >= 0, "gzip");
  const char* name = dataset.info.kind == VolumeKind::kLabels ? "labels" : "scalars";
  file_->dataset =
      Hdf5Handle(H5Dcreate2(file_->file.get(), name, volumes::hdf5_file_type(dataset.info.type),
                            space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                 H5Dclose);
  check(file_->dataset.valid(), "create dataset");
}

Hdf5ImageWriter::~Hdf5ImageWriter() {
  const Hdf5Session session;
  if (file_) file_->dataset.reset();
  if (file_) file_->file.reset();
}

void Hdf5ImageWriter::write_chunk(const Coordinate& position, std::span<const std::byte> bytes) {
  const Hdf5Session session;
  const hsize_t offset[3] = {position.z * dataset_.chunk.z, position.y * dataset_.chunk.y,
                             position.x * dataset_.chunk.x};
  check(
      H5Dwrite_chunk(file_->dataset.get(), H5P_DEFAULT, 0, offset, bytes.size(), bytes.data()) >= 0,
      "write chunk");
}

Buffer Hdf5ImageWriter::finish() {
  const Hdf5Session session;
  file_->dataset.reset();
  check(H5Fflush(file_->file.get(), H5F_SCOPE_GLOBAL) >= 0, "flush");
  // The driver's own size is rounded up to kGrowth.
  const ssize_t size = H5Fget_file_image(file_->file.get(), nullptr, 0);
  check(size >= 0, "image size");
  file_->file.reset();
  Buffer image = std::move(file_->image);
  check(static_cast<std::size_t>(size) <= image.size(), "image size");
  image.resize(static_cast<std::size_t>(size));
  return image;
}

}  // namespace cvr::codecs::general
