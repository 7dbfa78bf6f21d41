// The program in the background, to be stopped, interrupted and killed.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {

/// Asks again and again, up to a minute: no test depends on the speed of a machine.
template <class Condition>
bool wait_until(const Condition& condition,
                std::chrono::milliseconds limit = std::chrono::minutes(1)) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// Processes, zombies left out, that carry a mark in their environment.
inline std::vector<pid_t> marked_processes(const std::string& mark) {
  std::vector<pid_t> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", error)) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream in(entry.path() / "environ", std::ios::binary);  // empty of zombies
    const std::string environment{std::istreambuf_iterator<char>(in), {}};
    if (environment.find("CVRBENCH_TEST_MARK=" + mark) != std::string::npos)
      found.push_back(std::stoi(name));
  }
  return found;
}

class Child {
 public:
  /// `arguments` behind the program's name, in the folder of `program`. `fault`: of tests/faults, by
  /// the program whose workers fail.
  Child(const Program& program, const std::vector<std::string>& arguments,
        const std::string& fault = "")
      : mark_(program / "mark") {
    pid_ = fork();
    if (pid_ != 0) return;
    if (chdir((program / "").c_str()) != 0) _exit(126);
    setenv("XDG_CACHE_HOME", (program / "cache").c_str(), 1);
    setenv("XDG_DATA_HOME", (program / "share").c_str(), 1);
    setenv("CVRBENCH_DATA", "", 1);
    setenv("CVRBENCH_TEST_MARK", mark_.c_str(), 1);
    const int nowhere = open("/dev/null", O_RDWR);
    const int errors = open((program / "child-stderr").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(nowhere, STDIN_FILENO);
    dup2(nowhere, STDOUT_FILENO);
    dup2(errors, STDERR_FILENO);
    std::vector<char*> words{const_cast<char*>("cvrbench")};
    for (const std::string& argument : arguments)
      words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    setenv("CVRBENCH_TEST_FAULT", fault.c_str(), 1);
    execv(fault.empty() ? CVRBENCH_PROGRAM : CVRBENCH_FAULTY, words.data());
    _exit(127);
  }
  ~Child() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void send(int signal_number) const { kill(pid_, signal_number); }
  /// Its status as of waitpid.
  int wait() {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) continue;
    pid_ = -1;
    return status;
  }
  bool runs() const {
    siginfo_t ended{};
    return waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           ended.si_pid == 0;
  }
  /// It and the workers.
  std::size_t processes() const { return marked_processes(mark_).size(); }

 private:
  std::string mark_;
  pid_t pid_ = -1;
};

}  // namespace cvr::cli_tests
