#include "volumes/io/content.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace cvr::volumes {

namespace {

using namespace std::string_view_literals;

struct Signature {
  std::size_t offset;
  std::string_view bytes;
  std::string_view what;
};

constexpr std::array kSignatures{
    Signature{0, "\x89HDF\r\n\x1a\n"sv, "an HDF5 file (.h5)"},
    Signature{0, "NRRD000"sv, "an NRRD file (.nrrd)"},
    Signature{0, "\x5c\x01\0\0"sv, "a NIfTI-1 or Analyze header (.nii)"},
    Signature{0, "\0\0\x01\x5c"sv, "a NIfTI-1 or Analyze header (.nii)"},
    Signature{0, "\x1c\x02\0\0"sv, "a NIfTI-2 header"},
    Signature{0, "\0\0\x02\x1c"sv, "a NIfTI-2 header"},
    Signature{0, "\x1f\x8b"sv, "gzip data (.gz)"},
    Signature{0, "BZh"sv, "bzip2 data (.bz2)"},
    Signature{0,
              "\xfd"
              "7zXZ\0"sv,
              "xz data (.xz)"},
    Signature{0, "\x28\xb5\x2f\xfd"sv, "zstd data (.zst)"},
    Signature{0, "PK\x03\x04"sv, "a zip archive"},
    Signature{257, "ustar"sv, "a tar archive"},
    Signature{0, "\x89PNG"sv, "a PNG image"},
    Signature{0, "\xff\xd8\xff"sv, "a JPEG image"},
    Signature{0, "II*\0"sv, "a TIFF image"},
    Signature{0, "MM\0*"sv, "a TIFF image"},
    Signature{128, "DICM"sv, "a DICOM file"},
    Signature{0, "\x93NUMPY"sv, "a NumPy array (.npy)"},
    Signature{0, "ObjectType"sv, "a MetaImage header (.mhd, .mha)"},
    Signature{0, "NDims"sv, "a MetaImage header (.mhd, .mha)"},
    Signature{0, "# vtk"sv, "a VTK file"},
    Signature{0, "<?xml"sv, "an XML document"},
    Signature{0, "<VTKFile"sv, "a VTK XML file"},
    Signature{0, "CVRBENCH"sv, "an encoded file of this program (decode it first)"},
    Signature{0, "{"sv, "JSON text"},
};
constexpr std::size_t kShownBytes = 16;

}  // namespace

std::string describe_content(std::span<const std::byte> bytes) {
  if (bytes.empty()) return "an empty file";
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const Signature& signature : kSignatures) {
    if (text.size() >= signature.offset &&
        text.substr(signature.offset).starts_with(signature.bytes))
      return std::string(signature.what);
  }
  const std::string_view start = text.substr(0, std::min(text.find('\n'), kShownBytes));
  const bool printable = !start.empty() && std::all_of(start.begin(), start.end(),
                                                       [](char c) { return c >= ' ' && c <= '~'; });
  return printable ? fmt::format("text that begins '{}'", start) : "other bytes";
}

}  // namespace cvr::volumes
