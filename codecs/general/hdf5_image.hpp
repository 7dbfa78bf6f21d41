// An HDF5 file with one chunked dataset: written by libhdf5 in memory, read by this project's own
// bounded reader.
//
// Writing: the core driver grows a buffer of ours (file image callbacks), so that the finished
// image is handed over without a copy. Chunks arrive compressed and go in with H5Dwrite_chunk. No
// time stamps: the bytes depend on the chunks and their order alone.
//
// Reading: libhdf5 trusts its files too much for bytes of unknown origin. What is needed here is
// little: from the superblock (version 0) through the root group to the dataset's object header
// (version 1), its layout and its chunk index (version 1 B-tree), as the HDF5 file format
// specification describes them. Every address is checked; chunks are only located, not
// decompressed.
#pragma once

#include <array>
#include <memory>

#include "codecs/codec.hpp"

namespace cvr::codecs::general {

/// A chunked dataset as both sides know it from the envelope.
struct ChunkedDataset {
  VolumeInfo info;
  Extent chunk;  ///< voxels, at most the extent on each axis
  bool shuffle;
  unsigned level;  ///< of gzip

  Extent grid() const;
  std::uint64_t chunk_bytes() const { return chunk.voxels() * size_of(info.type); }
};

class Hdf5ImageWriter {
 public:
  /// Throws std::runtime_error with libhdf5's reason, here and below.
  explicit Hdf5ImageWriter(const ChunkedDataset& dataset);
  ~Hdf5ImageWriter();
  /// `position` in chunks; `bytes` after all filters.
  void write_chunk(const Coordinate& position, std::span<const std::byte> bytes);
  /// Closes the file and gives its bytes.
  Buffer finish();

 private:
  struct File;
  ChunkedDataset dataset_;
  std::unique_ptr<File> file_;
};

struct ChunkPlace {
  std::uint64_t offset = 0;
  std::uint64_t size = 0;  ///< 0: not found yet
};
/// Where each chunk of the dataset lies, x fastest. All of them exist and lie inside `image`.
Expected<std::vector<ChunkPlace>> locate_chunks(std::span<const std::byte> image,
                                                const ChunkedDataset& dataset);

}  // namespace cvr::codecs::general
