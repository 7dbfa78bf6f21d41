#include "experiments/worker_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <thread>

namespace cvr::experiments {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kComplaintBytes = 500;

void close_if_open(int& descriptor) {
  if (descriptor >= 0) close(descriptor);
  descriptor = -1;
}

[[noreturn]] void become_worker(const char* program, int in, int out, int complaints, pid_t parent) {
  // A parent that is killed takes its workers with it.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);
  std::signal(SIGPIPE, SIG_DFL);
  std::signal(SIGINT, SIG_IGN);  // the terminal's Ctrl-C reaches the parent, which ends the workers
  dup2(in, STDIN_FILENO);
  dup2(out, STDOUT_FILENO);
  dup2(complaints, STDERR_FILENO);
  execl(program, "cvrbench", "worker", nullptr);
  _exit(127);
}

}  // namespace

std::string first_line_of(const std::string& program, const std::string& argument) {
  std::string command = "'";
  for (const char c : program) command += c == '\'' ? std::string("'\\''") : std::string(1, c);
  command += "' " + argument;
  const auto close = [](std::FILE* pipe) { pclose(pipe); };
  const std::unique_ptr<std::FILE, decltype(close)> pipe(popen(command.c_str(), "r"), close);
  char line[512];
  if (!pipe || std::fgets(line, sizeof line, pipe.get()) == nullptr)
    throw EnvironmentError(fmt::format("{} {}: expected a line of text, found none", program, argument));
  std::string text(line);
  if (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

WorkerProcess::WorkerProcess(const std::string& program) {
  int to[2], from[2];
  if (pipe2(to, O_CLOEXEC) != 0)
    throw EnvironmentError(fmt::format("cannot make a pipe: {}", std::strerror(errno)));
  if (pipe2(from, O_CLOEXEC) != 0) {
    close(to[0]);
    close(to[1]);
    throw EnvironmentError(fmt::format("cannot make a pipe: {}", std::strerror(errno)));
  }
  complaints_ = memfd_create("complaints", MFD_CLOEXEC);
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) become_worker(program.c_str(), to[0], from[1], complaints_, parent);
  const int error = errno;
  close(to[0]);
  close(from[1]);
  to_ = to[1];
  from_ = from[0];
  if (pid_ < 0) {
    close_if_open(to_);
    close_if_open(from_);
    close_if_open(complaints_);
    throw EnvironmentError(fmt::format("cannot start a worker process: {}", std::strerror(error)));
  }
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

WorkerProcess::Wait WorkerProcess::receive(double timeout_seconds, Row& message) {
  const auto deadline = Clock::now() + std::chrono::duration<double>(timeout_seconds);
  while (true) {
    if (const std::size_t end = pending_.find('\n'); end != std::string::npos) {
      message = Row::parse(pending_.substr(0, end), nullptr, false);
      pending_.erase(0, end + 1);
      return message.is_object() ? Wait::kMessage : Wait::kEnd;
    }
    const double left = std::chrono::duration<double>(deadline - Clock::now()).count();
    if (left <= 0) return Wait::kTimeout;
    pollfd ready{from_, POLLIN, 0};
    const int count = poll(&ready, 1, static_cast<int>(std::min(left * 1000 + 1, 1e9)));
    if (count < 0 && errno == EINTR) return Wait::kInterrupted;
    if (count <= 0) continue;
    char block[4096];
    const ssize_t got = read(from_, block, sizeof block);
    if (got < 0 && errno == EINTR) return Wait::kInterrupted;
    if (got <= 0) return Wait::kEnd;
    pending_.append(block, static_cast<std::size_t>(got));
  }
}

WorkerEnd WorkerProcess::finish(double grace_seconds) {
  close_if_open(to_);
  WorkerEnd end;
  int status = 0;
  rusage usage{};
  const auto deadline = Clock::now() + std::chrono::duration<double>(grace_seconds);
  pid_t ended = 0;
  while ((ended = wait4(pid_, &status, WNOHANG, &usage)) == 0 && Clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (ended == 0) {
    killed_ = true;
    kill(pid_, SIGKILL);
    while (wait4(pid_, &status, 0, &usage) < 0 && errno == EINTR) continue;
  }
  pid_ = -1;
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  if (WIFEXITED(status)) end.exit_code = WEXITSTATUS(status);
  end.peak_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  if (complaints_ >= 0) {
    const off_t size = lseek(complaints_, 0, SEEK_END);
    const off_t start = std::max<off_t>(0, size - static_cast<off_t>(kComplaintBytes));
    end.complaints.resize(static_cast<std::size_t>(std::max<off_t>(0, size - start)));
    const ssize_t got = pread(complaints_, end.complaints.data(), end.complaints.size(), start);
    end.complaints.resize(static_cast<std::size_t>(std::max<ssize_t>(0, got)));
    while (!end.complaints.empty() && end.complaints.back() == '\n') end.complaints.pop_back();
  }
  close_if_open(from_);
  close_if_open(complaints_);
  return end;
}

}  // namespace cvr::experiments
