// A generated volume through encode, validate, error and decode, each within an address space that
// the volume does not fit into.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {

struct Streamed {
  std::string size;             ///< "X,Y,Z" of u32 labels
  std::uint64_t bytes;          ///< of the volume
  std::uint64_t address_space;  ///< bytes
  std::string codec;            ///< id and parameters
  std::string volume, decoded;  ///< names of the original and of the decoded file
};

/// Each command has to end well; prints what encode reports.
inline void expect_streams(const Program& program, const Streamed& s) {
  const auto limited = [&](const std::string& arguments) {
    const Outcome outcome = program.run_within(s.address_space, arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << ": " << outcome.err;
    return outcome;
  };
  limited("generate worst-case -p pattern=2 -p thickness=64 --size " + s.size +
          " --seed 1 --threads 2 -o " + s.volume);
  if (testing::Test::HasFailure()) return;
  const Outcome encoded =
      limited("encode " + s.volume + " -o v.cvr --codec " + s.codec + " --threads 2 --json");
  if (testing::Test::HasFailure()) return;
  const auto report = nlohmann::json::parse(encoded.out);
  EXPECT_EQ(report["original_bytes"], s.bytes);
  EXPECT_EQ(report["streamed"], true);
  limited("error " + s.volume + " v.cvr --threads 2");
  limited("decode v.cvr --threads 2 -o " + s.decoded);
  limited("error " + s.decoded + " v.cvr --threads 2");
}

}  // namespace cvr::cli_tests
