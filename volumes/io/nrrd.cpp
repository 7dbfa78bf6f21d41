// Opens NRRD volumes by their parsed header; the format facts are in nrrd.hpp.
#include "volumes/io/nrrd.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "volumes/io/named_file.hpp"

namespace cvr::volumes {

namespace {

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

ArrayLayout layout_of(const NrrdHeader& header, const MappedFile& data) {
  const std::uint64_t behind_lines =
      skip_lines(data, header.data_file.empty() ? header.data_offset : 0, header.line_skip);
  const auto skip = static_cast<std::uint64_t>(std::max<std::int64_t>(header.byte_skip, 0));
  ArrayLayout layout{.encoding = header.encoding,
                     .at_end = header.byte_skip < 0,
                     .big_endian = header.big_endian && header.encoding != ArrayEncoding::kText,
                     .stored = header.type};
  switch (header.encoding) {
    case ArrayEncoding::kPlain:
      layout.offset = behind_lines + skip;
      break;
    case ArrayEncoding::kGzip:
      layout.start = behind_lines;
      layout.offset = skip;
      break;
    case ArrayEncoding::kHex:
    case ArrayEncoding::kText:
      layout.start = std::min<std::uint64_t>(behind_lines + skip, data.size());
      break;
  }
  return layout;
}

/// The file of the voxels: the header's own, or the one that it names.
MappedFile open_data(MappedFile file, const NrrdHeader& header, const OpenOptions& options) {
  if (header.data_file.empty()) return file;
  const std::string_view behind = file.text().substr(header.data_offset);
  if (behind.find_first_not_of(" \t\r\n") != std::string_view::npos) {
    throw_input_error(file.path(), header.line_of("data file"),
                      "nothing behind a header that names a data file",
                      fmt::format("{} bytes there", behind.size()));
  }
  return MappedFile(named_file(file.path(), header.line_of("data file"), header.data_file, options),
                    MappedFile::Least::kBegin);
}

}  // namespace

std::unique_ptr<VolumeSource> open_nrrd(const VolumePath& path, const OpenOptions& options) {
  MappedFile file(path.file, MappedFile::Least::kBegin);
  const NrrdHeader header = parse_nrrd_header(path.file, file.text());
  const Interpretation meaning = interpret(
      path.file, header.type, options.kind, header.kind, FloatLabels::kConverted,
      header.type.is_float64 ? fmt::format("float64 (NRRD type {})", header.type_name) : "");
  const NrrdGeometry geometry = nrrd_geometry(path.file, header, meaning.type, options);
  VolumeInfo info{.extent = {},
                  .type = meaning.type,
                  .kind = meaning.kind,
                  .voxel_size = geometry.voxel_size,
                  .voxel_unit = geometry.voxel_unit,
                  .offset = geometry.offset};
  MappedFile data = open_data(std::move(file), header, options);
  ArrayLayout layout = layout_of(header, data);
  layout.reject_negative = meaning.reject_negative;
  layout.whole_numbers = meaning.whole_numbers;
  apply_axes(path, header.line_of("sizes"), geometry.axes, info, layout);
  return open_array(std::move(data), info, layout, header.provenance, {path.file});
}

}  // namespace cvr::volumes
