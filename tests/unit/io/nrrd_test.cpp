// NRRD: headers written by hand, the exact header that we write, and every header feature that is refused.
#include "volumes/io/nrrd.hpp"

#include <fmt/format.h>

#include "io_fixture.hpp"

namespace cvr::volumes {
namespace {

using Nrrd = IoTest;

constexpr const char* kSmall = "type: uchar\ndimension: 3\nsizes: 2 3 2\nencoding: raw\n";
const std::string kTwelve("\0\1\2\3\4\5\6\7\10\11\12\13", 12);

TEST_F(Nrrd, TheFirstAxisIsX) {
  const auto source = open_volume(write_bytes("a.nrrd", std::string("NRRD0001\n") + kSmall + "\n" + kTwelve));
  EXPECT_EQ(source->info().extent, (Extent{2, 3, 2}));
  const Volume volume = read_all(*source);
  EXPECT_EQ(volume.label({1, 0, 0}), 1u);
  EXPECT_EQ(volume.label({0, 1, 0}), 2u);
  EXPECT_EQ(volume.label({0, 0, 1}), 6u);
}

TEST_F(Nrrd, HeaderIsGolden) {
  Volume volume({.extent = {3, 1, 2},
                 .type = VoxelType::kU16,
                 .kind = VolumeKind::kLabels,
                 .voxel_size = {8, 4.5, 40},
                 .voxel_unit = "nm"});
  for (std::uint16_t i = 0; i < 6; ++i)
    volume.voxels<std::uint16_t>()[i] = static_cast<std::uint16_t>(0x6160 + i);
  write_nrrd(path("a.nrrd"), MemorySource(volume), NrrdEncoding::kRaw);
  EXPECT_EQ(
      read_bytes(path("a.nrrd")),
      "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 3 1 2\nspacings: 8 4.5 40\nunits: \"nm\" \"nm\" \"nm\"\n"
      "kinds: domain domain domain\nendian: little\nencoding: raw\nkind:=labels\n\n`aaabacadaea");
  write_volume(path("b.nhdr"), MemorySource(volume));
  EXPECT_EQ(
      read_bytes(path("b.nhdr")),
      "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 3 1 2\nspacings: 8 4.5 40\nunits: \"nm\" \"nm\" \"nm\"\n"
      "kinds: domain domain domain\nendian: little\nencoding: raw\ndata file: b.nhdr.bin\nkind:=labels\n");
  EXPECT_EQ(read_bytes(path("b.nhdr.bin")), "`aaabacadaea");
}

TEST_F(Nrrd, SeriesHaveTimeAsTheLastAxis) {
  Volume volume({.extent = {3, 1, 2}, .type = VoxelType::kU8, .kind = VolumeKind::kScalars, .voxel_unit = "mm", .time_steps = 2});
  std::memcpy(volume.data(), "abcdef", 6);
  write_nrrd(path("a.nrrd"), MemorySource(volume), NrrdEncoding::kRaw);
  EXPECT_EQ(read_bytes(path("a.nrrd")),
            "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 1 1 2\nspacings: 1 1 1 nan\nunits: \"mm\" \"mm\" \"mm\" \"\"\n"
            "kinds: domain domain domain list\nendian: little\nencoding: raw\nkind:=scalars\n\nabcdef");
  const std::string start = "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 3 1 2\nencoding: raw\n";
  const auto source = open_volume(write_bytes(
      "b.nrrd", start + "space directions: (2,0,0) (0,2,0) (0,0,5) none\nkinds: space space space time\n\n" + kTwelve));
  EXPECT_EQ(source->info().time_steps, 2u);
  EXPECT_EQ(source->info().voxel_size, (std::array<double, 3>{2, 2, 5}));
  expect_error(write_bytes("c.nrrd", start + "\n" + kTwelve), {"kinds"});
  expect_error(write_bytes("c.nrrd", start + "kinds: list domain domain domain\n\n" + kTwelve), {"line 6", "list"});
  expect_error(write_bytes("c.nrrd", start + "kinds: domain domain domain domain\n\n" + kTwelve), {"line 6", "list or time"});
  expect_error(write_bytes("c.nrrd", start + "spacings: 1 1 1\n\n" + kTwelve), {"line 6", "4 values"});
}

TEST_F(Nrrd, AttachedAndDetachedRawAndGzip) {
  const Volume volume = patterned({70, 13, 67}, VoxelType::kU64, VolumeKind::kLabels);
  for (const NrrdEncoding encoding : {NrrdEncoding::kRaw, NrrdEncoding::kGzip}) {
    for (const char* name : {"a.nrrd", "b.nhdr"}) {
      write_nrrd(path(name), MemorySource(volume), encoding);
      const auto source = open_volume(path(name));
      EXPECT_EQ(source->info().kind, VolumeKind::kLabels);
      expect_boxes(*source, volume);
    }
  }
}

TEST_F(Nrrd, BigEndianOfEveryWidth) {
  const std::array names{"ushort", "unsigned int", "uint64_t", "int16", "float"};
  const std::array types{VoxelType::kU16, VoxelType::kU32, VoxelType::kU64, VoxelType::kI16, VoxelType::kF32};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool scalars = i >= 3;
    const Volume volume =
        patterned({5, 7, 3}, types[i], scalars ? VolumeKind::kScalars : VolumeKind::kLabels);
    const auto source = open_volume(write_bytes(
        "a.nrrd",
        fmt::format("NRRD0004\r\n# by hand\r\nType: {}\r\ndimension: 3\r\nsizes: 5 7 3\r\nendian: BIG\r\n"
                    "encoding: RAW\r\n\r\n",
                    names[i]) +
            big_endian_bytes(volume)));
    ASSERT_EQ(source->info().type, types[i]);
    EXPECT_EQ(source->data(), nullptr);
    expect_boxes(*source, volume);
  }
}

TEST_F(Nrrd, SkipsLinesAndBytes) {
  write_bytes("data.bin", "one line\nanother\nxy" + kTwelve + "tail");
  const auto lines = open_volume(write_bytes(
      "a.nhdr", std::string("NRRD0001\n") + kSmall + "data file: data.bin\nline skip: 2\nbyte skip: 2\n"));
  EXPECT_EQ(read_all(*lines).label({1, 2, 1}), 11u);
  write_bytes("end.bin", "whatever" + kTwelve);
  const auto end = open_volume(
      write_bytes("b.nhdr", std::string("NRRD0001\n") + kSmall + "data file: end.bin\nbyte skip: -1\n"));
  EXPECT_EQ(read_all(*end).label({1, 2, 1}), 11u);
  EXPECT_EQ(end->data()[11], std::byte{11});
}

TEST_F(Nrrd, ByteSkipOfGzipCountsInflatedBytes) {
  Volume volume({.extent = {14, 1, 1}, .type = VoxelType::kU8, .voxel_unit = {}});
  std::memcpy(volume.data(), ("xy" + kTwelve).data(), 14);
  write_nrrd(path("source.nhdr"), MemorySource(volume), NrrdEncoding::kGzip);
  const auto source =
      open_volume(write_bytes("a.nhdr",
                              "NRRD0001\ntype: uint8\ndimension: 3\nsizes: 2 3 2\nencoding: gz\n"
                              "data file: source.nhdr.bin.gz\nbyte skip: 2\n"));
  EXPECT_EQ(read_all(*source).label({1, 2, 1}), 11u);
}

TEST_F(Nrrd, VoxelSizeFromDirectionsAndUnits) {
  const auto source = open_volume(write_bytes(
      "a.nrrd", std::string("NRRD0004\n") + kSmall +
                    "space: left-posterior-superior\nspace directions: (0,3,4) (0.5,0,0)  (0,0,-2)\n"
                    "space units: \"mm\" \"mm\" \"mm\"\nspace origin: (1,2,3)\nkinds: space space space\n"
                    "kind:=scalars\nsource:=a\\nb\n\n" +
                    kTwelve));
  EXPECT_EQ(source->info().voxel_size, (std::array<double, 3>{5, 0.5, 2}));
  EXPECT_EQ(source->info().voxel_unit, "mm");
  EXPECT_EQ(source->info().kind, VolumeKind::kScalars);
  EXPECT_EQ(source->provenance().source, "a\nb");
  const auto unknown = open_volume(
      write_bytes("b.nrrd", std::string("NRRD0002\n") + kSmall + "spacings: 1.5 NaN 2\n\n" + kTwelve));
  EXPECT_EQ(unknown->info().voxel_size, (std::array<double, 3>{1.5, 1, 2}));
}

TEST_F(Nrrd, SignedIntegersAreLabelsWithoutNegatives) {
  const std::string head =
      "NRRD0004\ntype: int\ndimension: 3\nsizes: 2 1 1\nendian: little\nencoding: raw\n\n";
  const auto good = open_volume(write_bytes("a.nrrd", head + std::string("\1\0\0\0\377\377\377\177", 8)));
  EXPECT_EQ(good->info().type, VoxelType::kU32);
  EXPECT_EQ(read_all(*good).label({1, 0, 0}), 2147483647u);
  expect_error(write_bytes("b.nrrd", head + std::string("\376\377\377\377\1\0\0\0", 8)), {"-2"});
}

TEST_F(Nrrd, ErrorsNameTheLine) {
  struct Bad {
    const char* header;
    const char* line;
    const char* part;
  };
  const std::string good = std::string("NRRD0004\n") + kSmall;
  for (const Bad& bad : {
           Bad{"type: double", "line 6", "once"},
           Bad{"dimension: 4", "line 6", "once"},
           Bad{"unheard of: 3", "line 6", "unheard of"},
           Bad{"no colon here", "line 6", "no colon here"},
           Bad{"data file: LIST", "line 6", "LIST"},
           Bad{"data file: a%03d.raw 0 9 1", "line 6", "a%03d"},
           Bad{"byte skip: -2", "line 6", "-2"},
           Bad{"line skip: many", "line 6", "many"},
           Bad{"spacings: 1 2", "line 6", "1 2"},
           Bad{"spacings: 1 2 inf", "line 6", "inf"},
           Bad{"space directions: none (1,0,0) (0,1,0)", "line 6", "none"},
           Bad{"space directions: (1,0,0) (0,1,0) (0,0,1", "line 6", "(0,0,1"},
           Bad{"units: \"mm\" \"mm\" \"s\"", "line 6", "\"s\""},
           Bad{"kinds: RGB-color space space", "line 6", "RGB-color"},
           Bad{"endian: middle", "line 6", "middle"},
           Bad{"kind:=colours", "line 6", "colours"},
           Bad{"space dimension: 4", "line 6", "4"},
       }) {
    expect_error(write_bytes("a.nrrd", good + bad.header + "\n\n" + kTwelve), {"a.nrrd", bad.line, bad.part});
  }
  expect_error(write_bytes("a.nrrd", "NRRD0009\n"), {"line 1", "NRRD0009"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\ntype: double\n"), {"line 2", "double"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\ntype: block\n"), {"line 2", "block"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\ndimension: 2\n"), {"line 2", "'2'"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\nencoding: bzip2\n"), {"line 2", "bzip2"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\nsizes: 1 2 -3\n"), {"line 2", "-3"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\nsizes: 1 2 99999999999999999999\n"), {"line 2", "9999"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\n\n"), {"encoding"});
  expect_error(
      write_bytes("a.nrrd", "NRRD0004\ntype: short\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nab"),
      {"endian"});
}

TEST_F(Nrrd, AbsurdSizesAreRefusedBeforeAnyAllocation) {
  for (const char* encoding : {"raw", "gzip"}) {
    const auto head = [&](const char* sizes) {
      return fmt::format("NRRD0004\ntype: uchar\ndimension: 3\nsizes: {}\nencoding: {}\n\n", sizes,
                         encoding) +
             kTwelve;
    };
    expect_error(write_bytes("a.nrrd", head("1048576 1048576 1048576")), {"2^48"});
    expect_error(write_bytes("a.nrrd", head("18446744073709551615 18446744073709551615 2")), {"2^48"});
    expect_error(write_bytes("a.nrrd", head("65536 65536 65536")), {"281474976710656"});
    expect_error(write_bytes("a.nrrd", head("0 4 4")), {"0x4x4"});
  }
  expect_error(write_bytes("a.nhdr", std::string("NRRD0001\n") + kSmall + "data file: none.bin\n"),
               {"none.bin"});
}

TEST_F(Nrrd, DamagedGzipIsAnError) {
  const Volume volume = patterned({70, 13, 67}, VoxelType::kU8, VolumeKind::kLabels);
  write_nrrd(path("a.nhdr"), MemorySource(volume), NrrdEncoding::kGzip);
  const std::string good = read_bytes(path("a.nhdr.bin.gz"));
  for (const std::size_t at : {good.size() / 2, good.size() - 6, good.size() - 2}) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    write_bytes("a.nhdr.bin.gz", bytes);
    EXPECT_THROW(read_all(*open_volume(path("a.nhdr"))), InputError) << at;
  }
}

}  // namespace
}  // namespace cvr::volumes
