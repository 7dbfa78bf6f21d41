// Decoding the finest level from memory into memory. A round opens the decoder (it checks the
// stream's tables) and decodes; the checksum of the envelope was verified before. The steps of a
// progressive decoder are timed after that.
#include "codecs/container.hpp"
#include "experiments/stages/costs.hpp"
#include "experiments/stages/destination.hpp"
#include "experiments/stages/encoded_volume.hpp"

namespace cvr::experiments {

namespace {

class DecodeRun final : public StageRun {
 public:
  explicit DecodeRun(const StageInput& input)
      : spec_(input.spec), truth_(input.truth), source_(input.source) {}

  Parts prepare() override {
    bytes_ = obtain_encoded(spec_, source_);
    Parts parts;
    verify(bytes_.bytes(), truth_, spec_.threads, parts);
    file_.emplace(checked(codecs::open_file(bytes_.bytes())));
    parts.size = describe_size(*file_, bytes_.size(), spec_.bytes_per_voxel);
    destination_.emplace(truth_.info(), spec_.memory_limit / 2);
    parts.destination = destination_->whole() ? "whole volume" : "one slab";
    return parts;
  }

  std::vector<Sample> round() override {
    const Stopwatch watch;
    const auto decoder = codecs::open_decoder(*file_);
    if (!decoder) fail_stage(decoder.error());
    const auto done = (*decoder)->decode(0, spec_.threads, *destination_);
    std::vector<Sample> samples{watch.lap("decode", truth_.info().extent.voxels())};
    if (!done) fail_stage(done.error());
    if (const auto* access = (*decoder)->progressive_access()) time_steps(*access, samples);
    return samples;
  }

 private:
  void time_steps(const codecs::ProgressiveAccess& access, std::vector<Sample>& samples) {
    for (unsigned step = 0; step < access.steps(); ++step) {
      const Stopwatch watch;
      const auto done = access.decode_step(step, spec_.threads, *destination_);
      samples.push_back(
          watch.lap(std::string(access.step_name(step)), truth_.info().extent.voxels()));
      if (!done) fail_stage(done.error());
    }
  }

  WorkerSpec spec_;
  const volumes::VolumeSource& truth_;
  const volumes::VolumeSource& source_;
  codecs::Buffer bytes_;
  std::optional<codecs::OpenedFile> file_;
  std::optional<Destination> destination_;
};

class DecodeStage final : public StageKind {
 public:
  const StageTraits& traits() const override {
    static constexpr StageTraits kTraits{
        .id = "decode",
        .sentence = "Decoding the finest level from memory into memory",
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
    const double to = process_memory(cell) + destination_memory(info, choices);
    if (cell.codec == kMemcpy) return to + static_cast<double>(info.bytes());
    const codecs::MemoryEstimate need = estimate_of(cell, info);
    return to + need.file + need.decode;
  }
  std::unique_ptr<StageRun> make_run(const StageInput& input) const override {
    return std::make_unique<DecodeRun>(input);
  }
};

}  // namespace

const StageKind& decode_stage() {
  static const DecodeStage kStage;
  return kStage;
}

}  // namespace cvr::experiments
