// NRRD headers ("Definition of NRRD File Format", Teem): what of them this project reads and writes.
//
//   NRRD000X                      magic, X = 1..5
//   field: description            one a line; names and most values without regard to case
//   key:=value                    ours: kind, name, source, licence
//   # comment
//   (blank line)                  ends an attached header; the data follow
//
// Read: dimension 3, or 4 with time last (kind list or time): a series; all integer types and float; encodings raw and gzip; both byte orders; one data file;
// line skip (before decompression), byte skip (after it; -1 with raw: the data end the file); the voxel size
// from `space directions` (their lengths) or `spacings`, its unit from `space units` or `units`. Fields that
// only describe (content, centers, thicknesses, axis mins, ...) are checked for existence and otherwise
// ignored. Everything else is an error with its line.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "volumes/io/format.hpp"

namespace cvr::volumes {

enum class NrrdEncoding { kRaw, kGzip };

struct NrrdHeader {
  std::array<std::uint64_t, 3> size{};  ///< of one step
  std::uint64_t steps = 0;              ///< of a series; 0: a single volume
  StoredType type{VoxelType::kU8};
  NrrdEncoding encoding = NrrdEncoding::kRaw;
  bool big_endian = false;
  std::array<double, 3> voxel_size{1, 1, 1};
  std::string voxel_unit;
  std::string data_file;  ///< as written in the header; empty: attached
  std::uint64_t line_skip = 0;
  std::int64_t byte_skip = 0;  ///< -1: the voxels are the last bytes of the file
  std::optional<VolumeKind> kind;
  Provenance provenance;
  std::uint64_t data_offset = 0;  ///< of the first byte behind the header
};

/// Throws InputError "FILE: line N: ...".
NrrdHeader parse_nrrd_header(const std::string& file, std::string_view text);

/// The header of a volume; `data_file` empty: attached, with the blank line that ends it.
std::string nrrd_header_text(const VolumeInfo& info, const Provenance& provenance, NrrdEncoding encoding,
                             const std::string& data_file);

/// A name ending in .nhdr gets a detached header beside its data in NAME.nhdr.bin (raw) or NAME.nhdr.bin.gz
/// (gzip).
void write_nrrd(const std::string& file, const VolumeSource& source, NrrdEncoding encoding);

}  // namespace cvr::volumes
