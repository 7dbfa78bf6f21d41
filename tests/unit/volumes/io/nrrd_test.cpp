// NRRD: headers written by hand, the exact header that we write, and every header feature that is
// refused.
#include "volumes/io/nrrd.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include "tests/unit/volumes/io/io_fixture.hpp"

namespace cvr::volumes {
namespace {

using Nrrd = IoTest;

constexpr const char* kSmall = "type: uchar\ndimension: 3\nsizes: 2 3 2\nencoding: raw\n";
TEST_F(Nrrd, TheFirstAxisIsX) {
  const auto source =
      open_volume(write_bytes("a.nrrd", std::string("NRRD0001\n") + kSmall + "\n" + kTwelve));
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
      "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 3 1 2\nspacings: 8 4.5 40\nunits: \"nm\" "
      "\"nm\" \"nm\"\n"
      "kinds: domain domain domain\nendian: little\nencoding: raw\nkind:=labels\n\n`aaabacadaea");
  write_volume(path("b.nhdr"), MemorySource(volume));
  EXPECT_EQ(read_bytes(path("b.nhdr")),
            "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 3 1 2\nspacings: 8 4.5 40\nunits: \"nm\" "
            "\"nm\" \"nm\"\n"
            "kinds: domain domain domain\nendian: little\nencoding: raw\ndata file: "
            "b.nhdr.bin\nkind:=labels\n");
  EXPECT_EQ(read_bytes(path("b.nhdr.bin")), "`aaabacadaea");
}

TEST_F(Nrrd, SeriesHaveTimeAsTheLastAxis) {
  Volume volume({.extent = {3, 1, 2},
                 .type = VoxelType::kU8,
                 .kind = VolumeKind::kScalars,
                 .voxel_unit = "mm",
                 .time_steps = 2});
  std::memcpy(volume.data(), "abcdef", 6);
  write_nrrd(path("a.nrrd"), MemorySource(volume), NrrdEncoding::kRaw);
  EXPECT_EQ(
      read_bytes(path("a.nrrd")),
      "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 1 1 2\nspacings: 1 1 1 nan\nunits: \"mm\" "
      "\"mm\" \"mm\" \"\"\n"
      "kinds: domain domain domain list\nendian: little\nencoding: raw\nkind:=scalars\n\nabcdef");
  const std::string start = "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 3 1 2\nencoding: raw\n";
  const auto source = open_volume(write_bytes(
      "b.nrrd",
      start + "space directions: (2,0,0) (0,2,0) (0,0,5) none\nkinds: space space space time\n\n" +
          kTwelve));
  EXPECT_EQ(source->info().time_steps, 2u);
  EXPECT_EQ(source->info().voxel_size, (std::array<double, 3>{2, 2, 5}));
  // Of four axes without kinds the one of length 1 is dropped; two steps would need a kind.
  EXPECT_EQ(open_volume(write_bytes("c.nrrd", start + "\n" + kTwelve))->info().extent,
            (Extent{2, 3, 2}));
  const std::string four = "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 3 2 2\nencoding: raw\n";
  expect_error(write_bytes("c.nrrd", four + "\n" + kTwelve + kTwelve),
               {"line 3", "--axes", "2 x 3 x 2 x 2"});
  expect_error(
      write_bytes("c.nrrd", four + "kinds: domain domain domain domain\n\n" + kTwelve + kTwelve),
      {"line 6", "list or time"});
  expect_error(write_bytes("c.nrrd", start + "kinds: list domain domain domain\n\n" + kTwelve),
               {"line 6", "axis 1 of kind list"});
  expect_error(write_bytes("c.nrrd", start + "spacings: 1 1 1\n\n" + kTwelve),
               {"line 6", "4 values"});
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
  const std::array types{VoxelType::kU16, VoxelType::kU32, VoxelType::kU64, VoxelType::kI16,
                         VoxelType::kF32};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool scalars = i >= 3;
    const Volume volume =
        patterned({5, 7, 3}, types[i], scalars ? VolumeKind::kScalars : VolumeKind::kLabels);
    const auto source = open_volume(write_bytes(
        "a.nrrd",
        fmt::format(
            "NRRD0004\r\n# by hand\r\nType: {}\r\ndimension: 3\r\nsizes: 5 7 3\r\nendian: BIG\r\n"
            "encoding: RAW\r\n\r\n",
            names[i]) +
            big_endian_bytes(volume)));
    ASSERT_EQ(source->info().type, types[i]);
    EXPECT_EQ(source->data(), nullptr);
    expect_boxes(*source, volume);
  }
}

TEST_F(Nrrd, SkipsLinesAndBytes) {
  write_bytes("data.bin", "one line\nanother\nxy" + kTwelve);
  const auto lines =
      open_volume(write_bytes("a.nhdr", std::string("NRRD0001\n") + kSmall +
                                            "data file: data.bin\nline skip: 2\nbyte skip: 2\n"));
  EXPECT_EQ(read_all(*lines).label({1, 2, 1}), 11u);
  write_bytes("end.bin", "whatever" + kTwelve);
  const auto end = open_volume(write_bytes(
      "b.nhdr", std::string("NRRD0001\n") + kSmall + "data file: end.bin\nbyte skip: -1\n"));
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
      "a.nrrd",
      std::string("NRRD0004\n") + kSmall +
          "space: left-posterior-superior\nspace directions: (0,3,4) (0.5,0,0)  (0,0,-2)\n"
          "space units: \"mm\" \"mm\" \"mm\"\nspace origin: (1,2,3)\nkinds: space space space\n"
          "kind:=scalars\nsource:=a\\nb\n\n" +
          kTwelve));
  EXPECT_EQ(source->info().voxel_size, (std::array<double, 3>{5, 0.5, 2}));
  EXPECT_EQ(source->info().voxel_unit, "mm");
  EXPECT_EQ(source->info().kind, VolumeKind::kScalars);
  EXPECT_EQ(source->provenance().source, "a\nb");
  const auto unknown = open_volume(write_bytes(
      "b.nrrd", std::string("NRRD0002\n") + kSmall + "spacings: 1.5 NaN 2\n\n" + kTwelve));
  EXPECT_EQ(unknown->info().voxel_size, (std::array<double, 3>{1.5, 1, 2}));
}

TEST_F(Nrrd, SignedIntegersAreLabelsWithoutNegatives) {
  const std::string head =
      "NRRD0004\ntype: int\ndimension: 3\nsizes: 2 1 1\nendian: little\nencoding: raw\n\n";
  const auto good =
      open_volume(write_bytes("a.nrrd", head + std::string("\1\0\0\0\377\377\377\177", 8)));
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
           Bad{"space directions: none (1,0,0) (0,1,0)\nkinds: list domain domain", "line 7",
               "axis 1 of kind list"},
           Bad{"space directions: (1,0,0) (0,1,0) (0,0,1", "line 6", "(0,0,1"},
           Bad{"units: \"mm\" \"mm\" \"s\"", "line 6", "\"s\""},
           Bad{"kinds: space RGB-color space", "line 6", "rgb-color"},
           Bad{"endian: middle", "line 6", "middle"},
           Bad{"space dimension: 17", "line 6", "17"},
           Bad{"kinds: domain domain time-ish", "line 6", "time-ish"},
           Bad{"kinds: domain 3-color domain", "line 6", "axis 2 of kind 3-color, 3 values"},
           Bad{"kinds: 3-color domain domain", "line 6", "found 2"},
           Bad{"kinds: vector domain domain", "line 6", "axis 1 of kind vector"},
           Bad{"space: 3D-left-handed\nspace directions: (1,0) (0,1) (1,1)", "line 7",
               "vectors of 3 numbers"},
           Bad{"space: 3D-left-handed\nspace dimension: 2", "line 7", "dimension 3"},
           Bad{"space origin: (1,2,3)", "line 6", "space directions"},
           Bad{"spacings: 1 1 1\nspace directions: (1,0,0) (0,1,0) (0,0,1)", "line 7",
               "spacings are in line 6"},
           Bad{"datafile: a\ndata file: a", "line 7", "'data file' is in line 6"},
           Bad{"content: a\ncontent: b", "line 7", "'content' is in line 6"},
           Bad{"a:=1\na:=2", "line 7", "'a' is in line 6"},
       }) {
    expect_error(write_bytes("a.nrrd", good + bad.header + "\n\n" + kTwelve),
                 {"a.nrrd", bad.line, bad.part});
  }
  expect_error(write_bytes("a.nrrd", "NRRD0009\n"), {"line 1", "NRRD0009"});
  expect_error(write_bytes("a.nrrd",
                           "NRRD0004\ntype: double\ndimension: 3\nsizes: 1 1 1\nencoding: "
                           "raw\nendian: little\n\n12345678"),
               {"float64 (NRRD type double)", "--kind labels"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\ntype: block\n"), {"line 2", "block"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\ndimension: 17\n"), {"line 2", "'17'"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\nencoding: bzip2\n"), {"line 2", "bzip2"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\nsizes: 1 2 -3\n"), {"line 2", "-3"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\nsizes: 1 2 99999999999999999999\n"),
               {"line 2", "9999"});
  expect_error(write_bytes("a.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\n\n"),
               {"encoding"});
  expect_error(
      write_bytes("a.nrrd",
                  "NRRD0004\ntype: short\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nab"),
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
    expect_error(write_bytes("a.nrrd", head("18446744073709551615 18446744073709551615 2")),
                 {"2^48"});
    expect_error(write_bytes("a.nrrd", head("65536 65536 65536")), {"281474976710656"});
    expect_error(write_bytes("a.nrrd", head("0 4 4")), {"0x4x4"});
  }
  expect_error(write_bytes("a.nhdr", std::string("NRRD0001\n") + kSmall + "data file: none.bin\n"),
               {"none.bin"});
}

TEST_F(Nrrd, SurplusAndMissingBytesAreErrors) {
  const std::string raw = std::string("NRRD0001\n") + kSmall,
                    gzip = "NRRD0001\ntype: uchar\ndimension: 3\nsizes: 2 3 2\nencoding: gzip\n";
  expect_error(write_bytes("a.nrrd", raw + "\n" + kTwelve + "x"), {"12 bytes", "13 bytes"});
  expect_error(write_bytes("a.nrrd", raw + "\n" + kTwelve.substr(1)), {"12 bytes", "11 bytes"});
  expect_error(write_bytes("a.nrrd", gzip + "\n" + gzipped(kTwelve + "xyz")),
               {"12 inflated bytes", "found 15"});
  expect_error(write_bytes("a.nrrd", gzip + "\n" + gzipped(kTwelve.substr(3))),
               {"12 inflated bytes", "after 9"});
  expect_error(write_bytes("a.nrrd", gzip + "\n" + gzipped(kTwelve) + "junk!"),
               {"end of the file", "5 bytes behind"});
  expect_error(write_bytes("a.nrrd", gzip + "\n" + gzipped(kTwelve) + gzipped("member")),
               {"12 inflated bytes", "found 18"});
  EXPECT_EQ(
      plain_bytes(read_all(*open_volume(write_bytes(
          "a.nrrd", gzip + "\n" + gzipped(kTwelve.substr(0, 6)) + gzipped(kTwelve.substr(6)))))),
      kTwelve);
  for (const auto& [bytes, number] :
       {std::pair{kTwelve + "x", "13 bytes"}, {kTwelve.substr(1), "11 bytes"}}) {
    write_bytes("data.bin", bytes);
    expect_error(write_bytes("a.nhdr", raw + "data file: data.bin\n"),
                 {"data.bin", "12 bytes", number});
  }
  write_bytes("data.bin", kTwelve);
  expect_error(write_bytes("a.nhdr", raw + "data file: data.bin\n\nattached"),
               {"line 6", "8 bytes"});
  write_bytes("data.gz", gzipped("whatever" + kTwelve));
  EXPECT_EQ(plain_bytes(read_all(
                *open_volume(write_bytes("a.nhdr", gzip + "byte skip: -1\ndata file: data.gz\n")))),
            kTwelve);
}

TEST_F(Nrrd, AxesOfLengthOneAreDropped) {
  for (const auto& [sizes, fields] :
       {std::pair{"1 2 3 2", "kinds: list domain domain domain\n"},
        {"2 1 3 2", "kinds: domain vector domain domain\n"},
        {"1 2 3 2", "kinds: RGB-color space space space\n"},
        {"2 3 2 1", "kinds: domain domain domain list\n"},
        {"2 3 2 1", ""},
        {"1 2 3 2", "space: RAS\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n"}}) {
    SCOPED_TRACE(fields);
    const auto source = open_volume(write_bytes(
        "a.nrrd", fmt::format("NRRD0004\ntype: uchar\ndimension: 4\nsizes: {}\nencoding: raw\n{}\n",
                              sizes, fields) +
                      kTwelve));
    EXPECT_EQ(source->info().extent, (Extent{2, 3, 2}));
    EXPECT_EQ(source->info().time_steps, 1u);
    EXPECT_EQ(plain_bytes(read_all(*source)), kTwelve);
  }
}

TEST_F(Nrrd, AxesMayBeNamed) {
  const std::string name = write_bytes("a.nrrd",
                                       "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 3 2 "
                                       "1\nencoding: raw\nkinds: list domain domain domain\n"
                                       "spacings: nan 5 6 7\n\n" +
                                           kTwelve);
  expect_error(name, {"axis 1 of kind list"});
  const auto series = open_volume(name, OpenOptions{.axes = "txyz"});
  EXPECT_EQ(series->info().time_steps, 2u);
  EXPECT_EQ(series->info().voxel_size, (std::array<double, 3>{5, 6, 7}));
  EXPECT_EQ(plain_bytes(read_all(*series)), std::string("\0\2\4\6\10\12\1\3\5\7\11\13", 12));
  EXPECT_EQ(plain_bytes(read_all(*open_volume(name + "[1]", OpenOptions{.axes = "txy"}))),
            std::string("\1\3\5\7\11\13", 6));
  EXPECT_EQ(read_all(*open_volume(name, OpenOptions{.axes = "zyxt"})).label({1, 2, 0}), 10u);
  expect_error(name, {"2 x 3 x 2 x 1", "'xyzta'"}, OpenOptions{.axes = "xyzta"});
  const std::string time = write_bytes("b.nrrd",
                                       "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 3 2 "
                                       "1\nencoding: raw\nkinds: time domain domain domain\n\n" +
                                           kTwelve);
  EXPECT_EQ(plain_bytes(read_all(*open_volume(time + "[0]"))), std::string("\0\2\4\6\10\12", 6));
}

TEST_F(Nrrd, TheOffsetIsTheOrigin) {
  const auto offset = [this](const std::string& directions) {
    return open_volume(
               write_bytes("a.nrrd", std::string("NRRD0004\n") + kSmall +
                                         "space dimension: 3\nspace directions: " + directions +
                                         "\nspace origin: (10,-20.5,30)\n\n" + kTwelve))
        ->info()
        .offset;
  };
  EXPECT_EQ(offset("(1,0,0) (0,2,0) (0,0,3)"), (std::array<double, 3>{10, -20.5, 30}));
  EXPECT_EQ(offset("(-1,0,0) (0,-2,0) (0,0,3)"), (std::array<double, 3>{10, -20.5, 30}))
      << "the place of the first voxel";
  EXPECT_EQ(offset("(0,0,1) (2,0,0) (0,3,0)"), (std::array<double, 3>{30, 10, -20.5}))
      << "axes in another order";
  EXPECT_EQ(offset("(0.8,0.6,0) (-0.6,0.8,0) (0,0,1)"), (std::array<double, 3>{10, -20.5, 30}))
      << "oblique";
}

TEST_F(Nrrd, HexadecimalAndText) {
  const auto head = [](const char* type, const char* encoding) {
    return fmt::format(
        "NRRD0004\ntype: {}\ndimension: 3\nsizes: 2 1 1\nendian: big\nencoding: {}\n\n", type,
        encoding);
  };
  const Volume hex =
      read_all(*open_volume(write_bytes("a.nrrd", head("ushort", "hex") + "01fF\n00 0a\n")));
  EXPECT_EQ(hex.label({0, 0, 0}), 0x1ffu);
  EXPECT_EQ(hex.label({1, 0, 0}), 10u);
  expect_error(write_bytes("a.nrrd", head("ushort", "hex") + "01ff000a1"),
               {"8 hexadecimal digits", "found 9"});
  expect_error(write_bytes("a.nrrd", head("ushort", "hex") + "01ff00"),
               {"8 digits", "6 characters"});
  expect_error(write_bytes("a.nrrd", head("ushort", "hex") + "01ff 00  "),
               {"8 hexadecimal digits", "found 6"});
  expect_error(write_bytes("a.nrrd", head("ushort", "hex") + "01ff00xa"), {"character 6", "0x78"});
  const Volume text =
      read_all(*open_volume(write_bytes("a.nrrd", head("ushort", "ASCII") + "511\n65535\n")));
  EXPECT_EQ(text.label({0, 0, 0}), 511u);
  EXPECT_EQ(text.label({1, 0, 0}), 65535u);
  expect_error(write_bytes("a.nrrd", head("ushort", "text") + "511 65536"),
               {"voxel number 1", "u16", "'65536'"});
  expect_error(write_bytes("a.nrrd", head("ushort", "text") + "1 2 3"), {"2 numbers", "found 3"});
  expect_error(write_bytes("a.nrrd", head("ushort", "text") + "1    "), {"2 numbers", "found 1"});
  expect_error(write_bytes("a.nrrd", head("short", "txt") + "3 -4"), {"voxel (1, 0, 0)", "-4"},
               VolumeKind::kLabels);
}

TEST_F(Nrrd, ReadsNothingOutsideItsFolder) {
  const std::string raw = std::string("NRRD0001\n") + kSmall + "data file: ";
  write_bytes("outside.bin", kTwelve);
  write_bytes("own/below/data.bin", kTwelve);
  std::filesystem::create_symlink(path("outside.bin"), path("own/link.bin"));
  for (const std::string& name :
       {path("outside.bin"), std::string("../outside.bin"), std::string("below/../../outside.bin"),
        std::string("link.bin")}) {
    SCOPED_TRACE(name);
    const std::string header = write_bytes("own/a.nhdr", raw + name + "\n");
    expect_error(header, {"line 6", path("outside.bin"), "--allow-external"});
    EXPECT_EQ(plain_bytes(
                  read_all(*open_volume(header, OpenOptions{.axes = {}, .allow_external = true}))),
              kTwelve);
  }
  for (const std::string& name : {path("own/below/data.bin"), std::string("below/data.bin"),
                                  std::string("../own/below/data.bin")}) {
    const auto source = open_volume(write_bytes("own/a.nhdr", raw + name + "\n"));
    EXPECT_EQ(plain_bytes(read_all(*source)), kTwelve);
    EXPECT_EQ(source->files().size(), 2u);
    EXPECT_EQ(source->files()[0], path("own/a.nhdr"));
    EXPECT_TRUE(std::filesystem::equivalent(source->files()[1], path("own/below/data.bin")));
  }
  // A header that is a link finds its data beside itself and beside the file it links to.
  std::filesystem::create_symlink(write_bytes("own/a.nhdr", raw + "below/data.bin\n"),
                                  path("linked.nhdr"));
  std::filesystem::create_symlink(path("own/below"), path("below"));
  EXPECT_EQ(plain_bytes(read_all(*open_volume(path("linked.nhdr")))), kTwelve);
  ASSERT_EQ(::mkfifo(path("own/fifo").c_str(), 0600), 0);
  expect_error(write_bytes("own/b.nhdr", raw + "fifo\n"), {"fifo", "device, pipe or socket"});
  expect_error(write_bytes("own/c.nhdr", raw + "/dev/zero\n"), {"/dev/zero"});
  expect_error(path("own/fifo"), {"device, pipe or socket"});
}

TEST_F(Nrrd, SomebodyElsesKeysAreNoErrors) {
  const auto source = open_volume(
      write_bytes("a.nrrd", std::string("NRRD0004\n") + kSmall +
                                "kind:=colours\nvoxel_size:=x\nMR.x: y:=z\n\n" + kTwelve));
  EXPECT_EQ(source->info().kind, VolumeKind::kLabels);
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
