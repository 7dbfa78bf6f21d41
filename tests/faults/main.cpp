// cvrbench with a worker that fails on purpose, for the tests of what a run makes of it:
// CVRBENCH_TEST_FAULT="FAULT CODEC STAGE", globs of the cells that fail. FAULT is one of
//   crash         the worker ends by a signal before its check
//   hang          it never answers
//   oom           it takes memory until there is none
//   mismatch      what it encodes differs from the original in one voxel
//   device-lost   the device is lost when a round submits work to it
//   device-mib=N  the device allocates at most so much at a time
//   slower=N      its rounds are told to have taken N times as long
#include <fnmatch.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "experiments/cli/program.hpp"
#include "gpu/vulkan/device.hpp"

namespace cvr::experiments {
namespace {

/// The original with one voxel changed.
class AlteredSource final : public volumes::VolumeSource {
 public:
  explicit AlteredSource(const volumes::VolumeSource& truth) : truth_(truth) {}
  const volumes::VolumeInfo& info() const override { return truth_.info(); }
  void read(const volumes::Box& box, std::byte* out) const override {
    truth_.read(box, out);
    if (box.origin == volumes::Coordinate{} && box.size.voxels() > 0) out[0] ^= std::byte{1};
  }

 private:
  const volumes::VolumeSource& truth_;
};

class Faults final : public StageHooks {
 public:
  Faults() {
    const char* told = std::getenv("CVRBENCH_TEST_FAULT");
    std::istringstream words(told == nullptr ? "" : told);
    std::string codec, stage;
    words >> fault_;
    if (words >> codec) codec_ = codec;
    if (words >> stage) stage_ = stage;
  }

  void begin(const WorkerSpec& spec) override {
    hits_ = fnmatch(codec_.c_str(), spec.codec.c_str(), 0) == 0 &&
            fnmatch(stage_.c_str(), spec.stage.c_str(), 0) == 0;
    if (!hits_) return;
    if (fault_ == "crash") std::raise(SIGSEGV);
    while (fault_ == "hang") pause();
    std::vector<std::unique_ptr<char[]>> blocks;
    while (fault_ == "oom") {
      constexpr std::size_t kBlock = 16 << 20;
      blocks.push_back(std::make_unique<char[]>(kBlock));
    }
  }

  const volumes::VolumeSource& source(const WorkerSpec&,
                                      const volumes::VolumeSource& truth) override {
    if (!hits_ || fault_ != "mismatch") return truth;
    altered_ = std::make_unique<AlteredSource>(truth);
    return *altered_;
  }

  void change_device(gpu::DeviceOptions& options) override {
    if (!hits_) return;
    if (fault_ == "device-lost") {
      options.after_wait = [this] {
        if (in_rounds_) gpu::check(VK_ERROR_DEVICE_LOST, "vkWaitForFences");
      };
    }
    if (fault_.starts_with("device-mib="))
      options.largest_allocation = std::stoull(fault_.substr(fault_.find('=') + 1)) << 20;
  }

  void begin_round() override { in_rounds_ = true; }

  void end_round(std::vector<Sample>& samples) override {
    if (!hits_ || !fault_.starts_with("slower=")) return;
    const double factor = std::stod(fault_.substr(fault_.find('=') + 1));
    for (Sample& sample : samples) sample.wall_seconds *= factor;
  }

 private:
  std::string fault_, codec_ = "*", stage_ = "*";
  bool hits_ = false, in_rounds_ = false;
  std::unique_ptr<AlteredSource> altered_;
};

}  // namespace
}  // namespace cvr::experiments

int main(int argc, char** argv) {
  cvr::experiments::Faults faults;
  return cvr::experiments::cli::run_program(argc, argv, faults);
}
