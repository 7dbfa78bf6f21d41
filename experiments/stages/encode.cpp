// Encoding from the mapped original into memory: the whole file, envelope and checksums included.
#include <algorithm>
#include <thread>

#include "codecs/registry.hpp"
#include "experiments/stages/costs.hpp"
#include "experiments/stages/encoded_volume.hpp"

namespace cvr::experiments {

namespace {

class EncodeRun final : public StageRun {
 public:
  explicit EncodeRun(const StageInput& input)
      : spec_(input.spec),
        truth_(input.truth),
        source_(input.source),
        codec_(*codecs::find_codec(input.spec.codec)) {
    parameters_ = checked(
        codecs::Parameters::parse(codec_.parameters(), codecs::split_canonical(spec_.parameters)));
  }

  Parts prepare() override {
    // One thread against as many as the cell or the machine has, at least two.
    const unsigned other =
        spec_.threads > 1 ? 1 : std::max(2u, std::thread::hardware_concurrency());
    const auto encoded = checked(codecs::encode(codec_, source_, parameters_, spec_.threads));
    {
      const auto again = checked(codecs::encode(codec_, source_, parameters_, other));
      if (!std::ranges::equal(encoded.bytes.bytes(), again.bytes.bytes())) {
        throw StageFailure(kFailed, "encoding with " + std::to_string(spec_.threads) +
                                        " and with " + std::to_string(other) +
                                        " threads gives different bytes");
      }
    }
    const auto bytes = encoded.bytes.bytes();
    Parts parts;
    verify(bytes, truth_, spec_.threads, parts);
    parts.verification->same_bytes_with_threads = {std::min(spec_.threads, other),
                                                   std::max(spec_.threads, other)};
    const auto file = checked(codecs::open_file(bytes));
    parts.size = describe_size(file, bytes.size(), spec_.bytes_per_voxel);
    if (const auto entropy =
            checked(checked(codecs::open_decoder(file))->entropy_bytes(spec_.threads))) {
      parts.size->entropy_bytes = *entropy;
    }
    if (codec_.traits().stored_compressed)
      add_rates_at_rest(bytes, truth_.info().bytes(), *parts.size);
    leave_in_scratch(spec_, bytes);
    return parts;
  }

  std::vector<Sample> round() override {
    const Stopwatch watch;
    const auto encoded = codecs::encode(codec_, source_, parameters_, spec_.threads);
    auto sample = watch.lap("encode", truth_.info().extent.voxels());
    if (!encoded) fail_stage(encoded.error());
    return {sample};
  }

 private:
  WorkerSpec spec_;
  const volumes::VolumeSource& truth_;
  const volumes::VolumeSource& source_;
  const codecs::Codec& codec_;
  codecs::Parameters parameters_;
};

class EncodeStage final : public StageKind {
 public:
  const StageTraits& traits() const override {
    static constexpr StageTraits kTraits{
        .id = "encode",
        .sentence = "Encoding from the mapped original into memory",
        .version = 2,  // memory is counted since the check
        .memcpy = true};
    return kTraits;
  }
  double expected_seconds(const Cell& cell, const volumes::VolumeInfo& info,
                          double rounds) const override {
    return seconds_by_passes(cell, info, rounds);
  }
  double expected_memory(const Cell& cell, const volumes::VolumeInfo& info,
                         const MemoryChoices& choices) const override {
    if (cell.codec == kMemcpy) return process_memory(cell) + destination_memory(info, choices);
    const codecs::MemoryEstimate need = estimate_of(cell, info);
    return process_memory(cell) + need.file + need.encode;
  }
  std::unique_ptr<StageRun> make_run(const StageInput& input) const override {
    return std::make_unique<EncodeRun>(input);
  }
};

}  // namespace

const StageKind& encode_stage() {
  static const EncodeStage kStage;
  return kStage;
}

}  // namespace cvr::experiments
