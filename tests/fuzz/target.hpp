// A fuzz target is written once and built twice: as a libFuzzer program of its own (CVRBENCH_FUZZ),
// and into test_fuzz_inputs, which hands it every input of tests/corpus and tests/fuzz/found in
// every build.
//
//   CVR_FUZZ_TARGET(nrrd, input) { ... }
//
// The name is that of the file, and of the folders with its inputs. A target with variants (a codec
// each) has one folder a variant, named NAME-VARIANT; its libFuzzer program takes the variant from
// the environment variable CVRBENCH_FUZZ_VARIANT.
//
// A target returns whatever the bytes are. What it may not do is crash, throw, read or write
// outside its memory, take seconds, or hold more than eight times the input plus 256 MiB.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cvr::fuzz {

/// Lies at a multiple of 8, as every allocation does, in a block of exactly its size.
using Input = std::span<const std::byte>;

struct Target {
  std::string name;  ///< with the variant
  std::function<void(Input)> run;
};

/// All targets of this program, in the order of their names.
std::vector<Target> targets();

namespace detail {
using Run = void (*)(const std::string& variant, Input);
/// Adds a target before main; `variants` is called later, and is null where there are none. Returns
/// true.
bool add_target(std::string name, std::vector<std::string> (*variants)(), Run run);
}  // namespace detail

inline std::string_view text_of(Input input) {
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}

}  // namespace cvr::fuzz

#ifdef CVR_FUZZ_PROGRAM

#define CVR_FUZZ_TARGET(name, input)                                                  \
  static void fuzz_##name(::cvr::fuzz::Input input);                                  \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);  \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { \
    fuzz_##name(std::as_bytes(std::span(data, size)));                                \
    return 0;                                                                         \
  }                                                                                   \
  static void fuzz_##name(::cvr::fuzz::Input input)

/// `variants()` names them all, in any order; the body gets one of them.
#define CVR_FUZZ_TARGET_WITH_VARIANTS(name, variants, variant, input)                 \
  static void fuzz_##name(const std::string& variant, ::cvr::fuzz::Input input);      \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);  \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { \
    static const std::string kVariant = [] {                                          \
      const char* chosen = std::getenv("CVRBENCH_FUZZ_VARIANT");                      \
      return chosen == nullptr ? variants().front() : std::string(chosen);            \
    }();                                                                              \
    fuzz_##name(kVariant, std::as_bytes(std::span(data, size)));                      \
    return 0;                                                                         \
  }                                                                                   \
  static void fuzz_##name(const std::string& variant, ::cvr::fuzz::Input input)

#else

#define CVR_FUZZ_TARGET(name, input)                                                             \
  static void fuzz_##name(::cvr::fuzz::Input input);                                             \
  [[maybe_unused]] static const bool added_##name = ::cvr::fuzz::detail::add_target(             \
      #name, nullptr, [](const std::string&, ::cvr::fuzz::Input bytes) { fuzz_##name(bytes); }); \
  static void fuzz_##name(::cvr::fuzz::Input input)

#define CVR_FUZZ_TARGET_WITH_VARIANTS(name, variants, variant, input)            \
  static void fuzz_##name(const std::string& variant, ::cvr::fuzz::Input input); \
  [[maybe_unused]] static const bool added_##name =                              \
      ::cvr::fuzz::detail::add_target(#name, &variants, &fuzz_##name);           \
  static void fuzz_##name(const std::string& variant, ::cvr::fuzz::Input input)

#endif
