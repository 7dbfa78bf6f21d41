#include "experiments/results/provenance.hpp"

#include <gmock/gmock.h>
#include <gnu/libc-version.h>
#include <gtest/gtest.h>
#include <xxhash.h>
#include <zstd.h>

namespace cvr::experiments {
namespace {

TEST(Provenance, NamesLibrariesFeaturesAndSettings) {
  const Row p = describe_machine_and_build();
  EXPECT_EQ(p["libc"], std::string("glibc ") + gnu_get_libc_version());
  EXPECT_EQ(p["libraries"]["zstd"], ZSTD_versionString());
  for (const char* library : {"zstd", "liblzma", "zlib", "hdf5", "zfp", "xxhash"})
    EXPECT_THAT(p["libraries"].value(library, ""), testing::ContainsRegex("^[0-9]+\\.[0-9]+"))
        << library;
  EXPECT_FALSE(p["libraries"].value("astcenc", "").empty());
  const auto present = p["cpu_features"]["present"].get<std::vector<std::string>>();
  for (const Row& compiled : p["cpu_features"]["compiled"])
    EXPECT_THAT(present, testing::Contains(compiled.get<std::string>()))
        << "this program could not run";
#ifdef __AVX2__
  EXPECT_THAT(p["cpu_features"]["compiled"].get<std::vector<std::string>>(),
              testing::Contains("avx2"));
#endif
  for (const char* setting : {"governor", "turbo", "huge_pages"})
    EXPECT_FALSE(p.value(setting, "").empty()) << setting;
}

TEST(Provenance, TheFingerprintOfTheMachineIsOfProcessorCoresAndMemoryAlone) {
  const Row p = describe_machine_and_build();
  const std::string text =
      p["cpu"].dump() + "|" + p["cores"].dump() + "|" + p["memory_bytes"].dump();
  char digits[17];
  snprintf(digits, sizeof digits, "%016llx",
           static_cast<unsigned long long>(XXH3_64bits(text.data(), text.size())));
  EXPECT_EQ(p["machine"], digits);
}

TEST(Provenance, RoundsMixAcrossSettingsButNotAcrossLibraries) {
  Row p = describe_machine_and_build();
  const std::string before = what_times_depend_on(p);
  p["governor"] = "another";
  p["huge_pages"] = "another";
  EXPECT_EQ(what_times_depend_on(p), before);
  p["libraries"]["zstd"] = "another";
  EXPECT_NE(what_times_depend_on(p), before);
}

}  // namespace
}  // namespace cvr::experiments
