#include "experiments/run/worker.hpp"

#include <fcntl.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <memory>
#include <new>
#include <vector>

#include "experiments/results/samples.hpp"
#include "experiments/stages/stage_kind.hpp"
#include "gpu/vulkan/device.hpp"
#include "volumes/io/io.hpp"

namespace cvr::experiments {

namespace {

/// Address space that threads reserve without using it: a stack and a malloc arena each.
constexpr std::uint64_t kReservedPerThread = std::uint64_t{160} << 20;
constexpr std::uint64_t kProgram = std::uint64_t{256} << 20;

void limit_memory(const WorkerSpec& spec) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  if (spec.memory_limit == 0) return;
  // RLIMIT_DATA counts private writable memory, which is what the limit is about; RLIMIT_AS bounds
  // every other mapping too.
  const std::uint64_t all = spec.memory_limit + spec.location.info.bytes() + kProgram +
                            (spec.threads + 2) * kReservedPerThread;
  const rlimit data{spec.memory_limit, spec.memory_limit}, space{all, all};
  setrlimit(RLIMIT_DATA, &data);
  if (!kind_of(spec).limits_address_space()) return;
  setrlimit(RLIMIT_AS, &space);
#else
  (void)spec;  // a sanitizer's shadow memory exceeds any limit
#endif
}

/// Starts the record of the largest resident memory anew, so that it tells of the timed rounds and
/// not of the check.
void reset_peak_memory() {
  std::ofstream clear("/proc/self/clear_refs");
  clear << "5" << std::flush;
}

/// The largest resident memory since the record began, in bytes; 0 where the system does not tell.
/// What wait4 tells also counts the parent's memory at the time of the fork.
std::uint64_t peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024;
  }
  return 0;
}

/// The parent's end of the answers.
class Answers {
 public:
  /// Takes standard output for itself.
  Answers() : descriptor_(fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1)) {
    dup2(STDERR_FILENO, STDOUT_FILENO);
  }
  ~Answers() { close(descriptor_); }
  Answers(const Answers&) = delete;
  Answers& operator=(const Answers&) = delete;

  void send(const Row& message) const {
    const std::string line = message.dump(-1, ' ', false, Row::error_handler_t::replace) + "\n";
    for (std::size_t at = 0; at < line.size();) {
      const ssize_t written = write(descriptor_, line.data() + at, line.size() - at);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) _exit(1);  // nobody listens
      at += static_cast<std::size_t>(written);
    }
  }

 private:
  int descriptor_;
};

void serve(const WorkerSpec& spec, std::istream& in, const Answers& answers, StageHooks& hooks) {
  const auto truth = spec.raw_path.empty()
                         ? open_location(spec.location, spec.threads)
                         : volumes::open_volume(spec.raw_path, spec.location.info.kind);
  hooks.begin(spec);
  const auto stage = make_stage_run({spec, *truth, hooks.source(spec, *truth), hooks});
  Parts parts = stage->prepare();
  if (!parts.memory) parts.memory.emplace();
  if (const std::uint64_t peak = peak_memory(); peak > 0) parts.memory->check_peak_bytes = peak;
  malloc_trim(0);  // what the check has freed is not the rounds'
  reset_peak_memory();
  answers.send({{"event", "ready"}, {"parts", to_json(parts)}});
  for (std::string line; std::getline(in, line) && line == "round";) {
    hooks.begin_round();
    std::vector<Sample> samples = stage->round();
    hooks.end_round(samples);
    answers.send({{"event", "round"}, {"samples", to_row(samples)}, {"peak_bytes", peak_memory()}});
  }
}

}  // namespace

int serve_worker(std::istream& in, StageHooks& hooks) {
  const Answers answers;
  const auto failure = [&answers](std::string_view status, std::string_view reason,
                                  bool environment = false) {
    answers.send({{"event", "failure"},
                  {"status", status},
                  {"reason", reason},
                  {"environment", environment}});
    return 1;
  };
  try {
    std::string line;
    std::getline(in, line);
    const WorkerSpec spec = worker_spec_from_json(line);
    limit_memory(spec);
    serve(spec, in, answers, hooks);
    return 0;
  } catch (const StageFailure& error) {
    return failure(error.status(), error.what());
  } catch (const std::bad_alloc&) {
    return failure(kOutOfMemory, "an allocation failed within the memory limit");
  } catch (const gpu::DeviceError& error) {
    return failure(kFailed, error.what(), true);
  } catch (const std::exception& error) {
    return failure(kFailed, error.what());
  }
}

}  // namespace cvr::experiments
