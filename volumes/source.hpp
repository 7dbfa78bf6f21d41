// The two doors through which voxels pass: a VolumeSource is read by encoders, a SlabSink is
// written by decoders.
//
// Neither needs a whole volume in memory: encoders draw slabs of whole xy planes, decoders deliver
// such slabs in ascending z.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "volumes/volume.hpp"

namespace cvr::volumes {

/// Where a volume comes from, as its file says; a field is empty where the file says nothing.
struct Provenance {
  std::string name, source, licence;
  bool operator==(const Provenance&) const = default;
};

/// Something that can give the voxels of any box: a file, a generator, or memory.
class VolumeSource {
 public:
  virtual ~VolumeSource() = default;
  virtual const VolumeInfo& info() const = 0;
  /// Writes the voxels of `box` to `out`, x fastest and densely packed (box.size.voxels() *
  /// size_of(type) bytes). `box` must lie inside the extent. One call at a time. Throws InputError.
  virtual void read(const Box& box, std::byte* out) const = 0;
  /// All voxels if they lie in memory already, else nullptr.
  virtual const std::byte* data() const { return nullptr; }
  virtual Provenance provenance() const { return {}; }
  /// The files and folders that the voxels are read from, so that no output replaces one of them;
  /// none for memory and generators.
  virtual std::vector<std::string> files() const { return {}; }
};

/// A source over voxels that somebody else owns.
class MemorySource final : public VolumeSource {
 public:
  MemorySource(const VolumeInfo& info, const std::byte* voxels) : info_(info), voxels_(voxels) {}
  explicit MemorySource(const Volume& volume) : MemorySource(volume.info(), volume.data()) {}
  const VolumeInfo& info() const override { return info_; }
  void read(const Box& box, std::byte* out) const override;
  const std::byte* data() const override { return voxels_; }

 private:
  VolumeInfo info_;
  const std::byte* voxels_;
};

/// Reads the planes [z0, z1) of a source: a pointer into memory where the source has it, else into
/// a buffer of its own.
class SlabReader {
 public:
  explicit SlabReader(const VolumeSource& source) : source_(source) {}
  /// (z1 - z0) * X * Y voxels; valid until the next call.
  const std::byte* read(std::uint64_t z0, std::uint64_t z1);

 private:
  const VolumeSource& source_;
  Buffer buffer_;
};

/// The whole volume of a source in memory.
Volume read_all(const VolumeSource& source);

/// Takes decoded slabs in ascending z. begin and end alternate and are called by one thread;
/// between them several threads may write the slab.
class SlabSink {
 public:
  virtual ~SlabSink() = default;
  /// The largest number of planes that one slab should have; decoders round it to their own
  /// granularity.
  virtual std::uint64_t preferred_depth() const = 0;
  /// Where to write the planes [z0, z1) of the decoded level, x fastest, in the voxel type of the
  /// volume.
  virtual std::byte* begin(std::uint64_t z0, std::uint64_t z1) = 0;
  virtual void end(std::uint64_t z0, std::uint64_t z1) = 0;
};

/// Collects the slabs into a whole volume, one slab, no copy.
class VolumeSink final : public SlabSink {
 public:
  /// `info` is that of the decoded level.
  explicit VolumeSink(const VolumeInfo& info) : volume_(info) {}
  std::uint64_t preferred_depth() const override { return volume_.extent().z; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override;
  void end(std::uint64_t, std::uint64_t) override {}
  Volume take() { return std::move(volume_); }

 private:
  Volume volume_;
};

/// Compares the slabs with a source, so that volumes larger than memory can be verified.
class CompareSink final : public SlabSink {
 public:
  explicit CompareSink(const VolumeSource& truth, std::uint64_t depth = 64)
      : reader_(truth), truth_(truth), depth_(depth) {}
  std::uint64_t preferred_depth() const override { return depth_; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override;
  void end(std::uint64_t z0, std::uint64_t z1) override;
  std::uint64_t compared() const { return compared_; }
  std::uint64_t mismatches() const { return mismatches_; }

 private:
  SlabReader reader_;
  const VolumeSource& truth_;
  std::uint64_t depth_;
  Buffer slab_;
  std::uint64_t compared_ = 0;
  std::uint64_t mismatches_ = 0;
};

}  // namespace cvr::volumes
