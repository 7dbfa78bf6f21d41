#include "experiments/results/provenance.hpp"

#include <gmock/gmock.h>
#include <gnu/libc-version.h>
#include <gtest/gtest.h>
#include <xxhash.h>
#include <zstd.h>

namespace cvr::experiments {
namespace {

TEST(Provenance, NamesLibrariesFeaturesAndSettings) {
  const Provenance p = describe_machine_and_build();
  EXPECT_EQ(p.libc, std::string("glibc ") + gnu_get_libc_version());
  EXPECT_EQ(*p.libraries->find("zstd"), ZSTD_versionString());
  for (const char* library : {"zstd", "liblzma", "zlib", "hdf5", "zfp", "xxhash"})
    EXPECT_THAT(*p.libraries->find(library), testing::ContainsRegex("^[0-9]+\\.[0-9]+")) << library;
  EXPECT_FALSE(p.libraries->find("astcenc")->empty());
  for (const std::string& compiled : p.cpu_features->compiled)
    EXPECT_THAT(p.cpu_features->present, testing::Contains(compiled))
        << "this program could not run";
#ifdef __AVX2__
  EXPECT_THAT(p.cpu_features->compiled, testing::Contains("avx2"));
#endif
  for (const auto* setting : {&p.governor, &p.turbo, &p.huge_pages})
    EXPECT_FALSE(setting->value().empty());
}

TEST(Provenance, TheFingerprintOfTheMachineIsOfProcessorCoresAndMemoryAlone) {
  const Provenance p = describe_machine_and_build();
  const std::string text =
      Row(p.cpu).dump() + "|" + std::to_string(p.cores) + "|" + std::to_string(p.memory_bytes);
  char digits[17];
  snprintf(digits, sizeof digits, "%016llx",
           static_cast<unsigned long long>(XXH3_64bits(text.data(), text.size())));
  EXPECT_EQ(p.machine, digits);
}

TEST(Provenance, RoundsMixAcrossSettingsButNotAcrossLibraries) {
  Provenance p = describe_machine_and_build();
  const std::string before = what_times_depend_on(p);
  p.governor = "another";
  p.huge_pages = "another";
  EXPECT_EQ(what_times_depend_on(p), before);
  (*p.libraries)["zstd"] = "another";
  EXPECT_NE(what_times_depend_on(p), before);
}

}  // namespace
}  // namespace cvr::experiments
