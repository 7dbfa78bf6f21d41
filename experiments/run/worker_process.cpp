#include "experiments/run/worker_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/json_text.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kComplaintBytes = 500;
constexpr std::size_t kLongestAnswer = std::size_t{64} << 20;
constexpr std::size_t kSaidBytes = 60;
constexpr std::size_t kPipeBytes = 1 << 16;
/// A signal that arrives just before poll does not end it, so the wait is cut in pieces.
constexpr double kLongestWait = 0.2;

void close_if_open(int& descriptor) {
  if (descriptor >= 0) close(descriptor);
  descriptor = -1;
}

void limit(int resource, std::uint64_t soft, std::uint64_t hard) {
  const rlimit bounds{soft, hard};
  setrlimit(resource, &bounds);
}

[[noreturn]] void become_worker(const char* program, const WorkerLimits& limits, int in, int out,
                                int complaints, pid_t parent) {
  // A parent that is killed takes its workers with it.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);
  setpgid(0, 0);
  std::signal(SIGPIPE, SIG_DFL);
  std::signal(SIGXFSZ, SIG_IGN);  // writing beyond the limit is an error of the write
  // Who ends a run by sending these to all of its processes means its parent, which ends the
  // workers.
  for (const int ignored : {SIGINT, SIGTERM, SIGHUP}) std::signal(ignored, SIG_IGN);
  limit(RLIMIT_CORE, 0, 0);
  if (limits.cpu_seconds > 0) limit(RLIMIT_CPU, limits.cpu_seconds, limits.cpu_seconds + 5);
  if (limits.file_bytes > 0) limit(RLIMIT_FSIZE, limits.file_bytes, limits.file_bytes);
  dup2(in, STDIN_FILENO);
  dup2(out, STDOUT_FILENO);
  dup2(complaints, STDERR_FILENO);
  execl(program, "cvrbench", "worker", nullptr);
  _exit(127);
}

struct Pipe {
  int read_end = -1, write_end = -1;
  Pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
      throw EnvironmentError(fmt::format("cannot make a pipe: {}", std::strerror(errno)));
    read_end = ends[0];
    write_end = ends[1];
  }
  ~Pipe() {
    close_if_open(read_end);
    close_if_open(write_end);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
};

}  // namespace

std::string first_line_of(const std::string& program, const std::string& argument) {
  std::string command = "'";
  for (const char c : program) command += c == '\'' ? std::string("'\\''") : std::string(1, c);
  command += "' " + argument;
  const auto close = [](std::FILE* pipe) { pclose(pipe); };
  const std::unique_ptr<std::FILE, decltype(close)> pipe(popen(command.c_str(), "r"), close);
  char line[512];
  if (!pipe || std::fgets(line, sizeof line, pipe.get()) == nullptr)
    throw EnvironmentError(
        fmt::format("{} {}: expected a line of text, found none", program, argument));
  std::string text(line);
  if (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

WorkerProcess::WorkerProcess(const std::string& program, const WorkerLimits& limits) {
  Pipe to, from, complaints;
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0)
    become_worker(program.c_str(), limits, to.read_end, from.write_end, complaints.write_end,
                  parent);
  if (pid_ < 0)
    throw EnvironmentError(fmt::format("cannot start a worker process: {}", std::strerror(errno)));
  fcntl(complaints.read_end, F_SETFL, O_NONBLOCK);
  to_ = std::exchange(to.write_end, -1);
  from_ = std::exchange(from.read_end, -1);
  complaints_from_ = std::exchange(complaints.read_end, -1);
}

WorkerProcess::~WorkerProcess() {
  if (pid_ > 0) finish(0);
}

void WorkerProcess::move_to_core(std::size_t n) {
  cpu_set_t allowed, one;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;
  const auto count = static_cast<std::size_t>(CPU_COUNT(&allowed));
  if (count == 0) return;
  n %= count;
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (!CPU_ISSET(core, &allowed) || n-- > 0) continue;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    sched_setaffinity(pid_, sizeof one, &one);
    return;
  }
}

bool WorkerProcess::send(const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t written = write(to_, text.data() + at, text.size() - at);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    at += static_cast<std::size_t>(written);
  }
  return true;
}

WorkerProcess::Wait WorkerProcess::take_answer(std::size_t end, Row& message) {
  const std::string line = pending_.substr(0, end);
  pending_.erase(0, end + 1);
  searched_ = 0;
  try {
    message = volumes::parse_json(line, "worker");
    if (message.is_object() && message.contains("event") && message["event"].is_string())
      return Wait::kMessage;
  } catch (const volumes::InputError&) {
    // As what is JSON but no answer.
  }
  said_ = volumes::printable(line.substr(0, kSaidBytes));
  return Wait::kNoAnswer;
}

WorkerProcess::Wait WorkerProcess::receive(double timeout_seconds, Row& message,
                                           const volatile std::sig_atomic_t* interrupted) {
  const auto deadline = Clock::now() + std::chrono::duration<double>(timeout_seconds);
  std::vector<char> block(kPipeBytes);
  for (bool late = false; true;) {
    if (const std::size_t end = pending_.find('\n', searched_); end != std::string::npos)
      return take_answer(end, message);
    if (pending_.size() > kLongestAnswer) {
      said_ = volumes::printable(pending_.substr(0, kSaidBytes));
      return Wait::kNoAnswer;
    }
    if (interrupted != nullptr && *interrupted != 0) return Wait::kInterrupted;
    if (late) return Wait::kTimeout;
    // An answer that lies in the pipe counts, however long this process was stopped.
    const double left = std::chrono::duration<double>(deadline - Clock::now()).count();
    late = left <= 0;
    std::array<pollfd, 2> ready{{{from_, POLLIN, 0}, {complaints_from_, POLLIN, 0}}};
    const int wait = late ? 0 : static_cast<int>(1000 * std::min(left, kLongestWait)) + 1;
    if (poll(ready.data(), ready.size(), wait) <= 0) continue;
    if (ready[1].revents != 0) drain_complaints();
    if (ready[0].revents == 0) continue;
    const ssize_t got = read(from_, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return Wait::kEnd;
    searched_ = pending_.size();
    pending_.append(block.data(), static_cast<std::size_t>(got));
  }
}

/// Reads what is there, up to 1 MiB, and keeps the last of it.
void WorkerProcess::drain_complaints() {
  std::array<char, 4096> block;
  for (int i = 0; i < 256 && complaints_from_ >= 0; ++i) {
    const ssize_t got = read(complaints_from_, block.data(), block.size());
    if (got == 0) close_if_open(complaints_from_);
    if (got <= 0) break;
    complaints_.append(block.data(), static_cast<std::size_t>(got));
    if (complaints_.size() > kComplaintBytes)
      complaints_.erase(0, complaints_.size() - kComplaintBytes);
  }
}

WorkerEnd WorkerProcess::finish(double grace_seconds) {
  close_if_open(to_);
  const auto deadline = Clock::now() + std::chrono::duration<double>(grace_seconds);
  siginfo_t ended{};
  // The process is left to be waited for, so that its number, which is that of its group, is not
  // taken by another.
  while (waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         ended.si_pid == 0 && Clock::now() < deadline) {
    drain_complaints();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (ended.si_pid == 0) {
    killed_ = true;
    kill(pid_, SIGKILL);
  }
  kill(-pid_, SIGKILL);
  WorkerEnd end;
  int status = 0;
  rusage usage{};
  while (wait4(pid_, &status, 0, &usage) < 0 && errno == EINTR) continue;
  pid_ = -1;
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  if (WIFEXITED(status)) end.exit_code = WEXITSTATUS(status);
  end.peak_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  drain_complaints();
  while (!complaints_.empty() && complaints_.back() == '\n') complaints_.pop_back();
  end.complaints = volumes::printable(complaints_);
  close_if_open(from_);
  close_if_open(complaints_from_);
  return end;
}

}  // namespace cvr::experiments
