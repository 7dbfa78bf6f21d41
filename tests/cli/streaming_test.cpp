// Volumes that do not fit into memory: commands draw them slab by slab.
#include "tests/cli/streaming.hpp"

#include <gmock/gmock.h>

namespace cvr::cli_tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // shadow memory exceeds any limit
#else
constexpr bool kSanitized = false;
#endif

/// What the program, its libraries and its threads reserve before they do anything.
constexpr std::uint64_t kProgram = std::uint64_t{320} << 20;
constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;

TEST(Streaming, AVolumeLargerThanTheAddressSpaceIsEncodedVerifiedAndDecoded) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer's shadow memory exceeds the limit";
  const Program program;
  // Raw: 768 MiB are not mapped into 576 MiB but read in pieces.
  expect_streams(program, {"512,512,768", 768 * kMiB, 256 * kMiB + kProgram,
                           "csgv-nibble -p brick=32", "v.raw", "d.raw"});
}

TEST(Streaming, EveryFormatIsWrittenFromADecoder) {
  const Program program;
  ASSERT_EQ(program.run("generate cells --size 70,80,150 --seed 2 -o v.raw").exit_code, 0);
  ASSERT_EQ(program.run("encode v.raw -o v.cvr --codec csgvr-sb -p brick=32").exit_code, 0);
  for (const std::string name :
       {"d.raw", "d.nrrd", "d.nhdr", "d.nii", "d.nii.gz", "d.h5", "d.precomputed/"}) {
    const Outcome decoded = program.run("decode v.cvr --threads 2 -o " + name);
    ASSERT_EQ(decoded.exit_code, 0) << name << ": " << decoded.err;
    EXPECT_EQ(program.run("error v.raw " + name).exit_code, 0) << name;
  }
}

TEST(Streaming, ASmallVolumeIsReadBeforeItIsTimed) {
  const Program program;
  for (const std::string name : {"v.raw", "v.h5"}) {
    ASSERT_EQ(program.run("generate cells --size 40,24,33 --seed 7 -o " + name).exit_code, 0);
    const Outcome encoded = program.run("encode " + name + " -o v.cvr --codec zstd --json");
    ASSERT_EQ(encoded.exit_code, 0) << encoded.err;
    EXPECT_EQ(json::parse(encoded.out)["streamed"], false) << name;
  }
}

/// A file whose last bytes are wrong, its checksum right: the decoder finds out at the end, and no
/// volume must be left.
TEST(Streaming, AnErrorOfTheDecoderLeavesNoVolume) {
  const Program program;
  ASSERT_EQ(program.run("generate cells --size 40,24,133 --seed 7 -o v.raw").exit_code, 0);
  ASSERT_EQ(program.run("encode v.raw -o v.cvr --codec zstd").exit_code, 0);
  std::string file = program.read("v.cvr");
  file.pop_back();
  program.write("cut.cvr", file);
  for (const std::string name : {"d.raw", "d.h5", "d.precomputed/"}) {
    const Outcome decoded = program.run("decode cut.cvr -o " + name);
    EXPECT_EQ(decoded.exit_code, 2) << name;
    EXPECT_THAT(decoded.err, HasSubstr("cut.cvr: ")) << name;
    EXPECT_FALSE(std::filesystem::exists(program / name)) << name;
  }
}

/// The writer fails while the decoder has more to say: neither waits for the other.
TEST(Streaming, AWriterThatFailsEndsTheCommand) {
  const Program program;
  ASSERT_EQ(program
                .run("generate worst-case -p pattern=2 -p thickness=9 --size 256,256,256 --seed 7 "
                     "-o v.raw")
                .exit_code,
            0);
  ASSERT_EQ(program.run("encode v.raw -o v.cvr --codec csgvr-sb -p brick=32").exit_code, 0);
  // 4 MiB a file: the volume has 64.
  const Outcome decoded = program.run("decode v.cvr -o d.raw", "ulimit -f 4096; trap '' XFSZ; ");
  EXPECT_NE(decoded.exit_code, 0);
  EXPECT_LT(decoded.exit_code, 128);
  EXPECT_FALSE(std::filesystem::exists(program / "d.raw"));
}

}  // namespace
}  // namespace cvr::cli_tests
