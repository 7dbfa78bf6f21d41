// Opens NRRD volumes by their parsed header, and writes them attached or detached; the format facts are in
// nrrd.hpp.
#include "volumes/io/nrrd.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "volumes/io/array_source.hpp"
#include "volumes/io/gzip.hpp"

namespace cvr::volumes {

namespace {

constexpr int kGzipLevel = 6;

/// The offset behind `lines` lines, counted from `offset`.
std::uint64_t skip_lines(const MappedFile& file, std::uint64_t offset, std::uint64_t lines) {
  for (std::uint64_t line = 0; line < lines; ++line) {
    const std::size_t end = file.text().find('\n', offset);
    if (end == std::string_view::npos) {
      throw_input_error(file.path(), "line skip", fmt::format("{} lines before the voxels", lines),
                        fmt::format("{}", line));
    }
    offset = end + 1;
  }
  return offset;
}

ArrayLayout layout_of(const NrrdHeader& header, const MappedFile& data, std::uint64_t voxel_bytes) {
  ArrayLayout layout{.big_endian = header.big_endian};
  const std::uint64_t start = header.data_file.empty() ? header.data_offset : 0;
  const std::uint64_t behind_lines = skip_lines(data, start, header.line_skip);
  const auto skip = static_cast<std::uint64_t>(std::max<std::int64_t>(header.byte_skip, 0));
  if (header.encoding == NrrdEncoding::kGzip) {
    layout.gzip_start = behind_lines;
    layout.offset = skip;
    return layout;
  }
  const std::uint64_t size = data.size();
  if (header.byte_skip < 0) {
    if (voxel_bytes > size - start) {
      throw_input_error(data.path(), "byte skip -1", fmt::format("{} bytes of voxels", voxel_bytes),
                        fmt::format("a file of {} bytes", size));
    }
    layout.offset = size - voxel_bytes;
  } else {
    layout.offset = behind_lines + skip;
  }
  return layout;
}

void write_voxels(OutputFile& output, const VolumeSource& source, NrrdEncoding encoding) {
  const auto plain = [&output](std::span<const std::byte> bytes) { output.write(bytes); };
  if (encoding == NrrdEncoding::kRaw) return for_each_slab(source, plain);
  GzipWriter gzip(plain, kGzipLevel);
  for_each_slab(source, [&gzip](std::span<const std::byte> slab) { gzip.write(slab); });
  gzip.finish();
}

}  // namespace

std::unique_ptr<VolumeSource> open_nrrd(const VolumePath& path, const OpenOptions& options) {
  MappedFile file(path.file, MappedFile::Least::kBegin);
  const NrrdHeader header = parse_nrrd_header(path.file, file.text());
  const Interpretation meaning = interpret(path.file, header.type, options.kind, header.kind);
  const Steps steps = check_steps(path, "sizes", header.steps);
  const std::uint64_t stored_steps = std::max<std::uint64_t>(header.steps, 1);
  const Extent whole = check_extent(path.file, "sizes", header.size, stored_steps, meaning.type);
  const VolumeInfo info{.extent = {whole.x, whole.y, whole.z / stored_steps * steps.count},
                        .type = meaning.type,
                        .kind = meaning.kind,
                        .voxel_size = header.voxel_size,
                        .voxel_unit = header.voxel_unit,
                        .time_steps = steps.count};
  MappedFile data =
      header.data_file.empty()
          ? std::move(file)
          : MappedFile((std::filesystem::path(path.file).parent_path() / header.data_file).string(),
                       MappedFile::Least::kBegin);
  ArrayLayout layout = layout_of(header, data, whole.voxels() * size_of(info.type));
  layout.offset += steps.first * (info.bytes() / steps.count);
  layout.reject_negative = meaning.reject_negative;
  return open_array(std::move(data), info, layout, header.provenance);
}

void write_nrrd(const std::string& path, const VolumeSource& source, NrrdEncoding encoding) {
  const VolumeInfo& info = source.info();
  for (const std::string_view forbidden : {"\"", "\n"}) {
    if (info.voxel_unit.find(forbidden) != std::string::npos) {
      throw_input_error(path, "units", "a unit without quotation marks and line ends", info.voxel_unit);
    }
  }
  OutputFile file(path);
  if (!path.ends_with(".nhdr")) {
    file.write(nrrd_header_text(info, source.provenance(), encoding, ""));
    write_voxels(file, source, encoding);
    return file.commit();
  }
  OutputFile data(path + (encoding == NrrdEncoding::kRaw ? ".bin" : ".bin.gz"));
  write_voxels(data, source, encoding);
  data.close();
  const std::string data_name = std::filesystem::path(data.path()).filename().string();
  file.write(nrrd_header_text(info, source.provenance(), encoding, data_name));
  file.close();
  // Both are complete. Without a header the new data cannot be read with the old one's sizes.
  std::filesystem::remove(path);
  data.commit();
  file.commit();
}

void write_nrrd(const VolumePath& path, const VolumeSource& source) {
  write_nrrd(path.file, source, path.file.ends_with(".nhdr") ? NrrdEncoding::kRaw : NrrdEncoding::kGzip);
}

}  // namespace cvr::volumes
