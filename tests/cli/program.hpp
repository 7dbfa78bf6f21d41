// Runs the cvrbench program as a user would, in a folder of its own.
#pragma once

#include <stdlib.h>
#include <sys/wait.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace cvr::cli_tests {

struct Outcome {
  int exit_code;  ///< 128 + signal when a signal ended it
  std::string out, err;
};

class Program {
 public:
  Program() {
    std::string name = (std::filesystem::temp_directory_path() / "cvrbench-cli-XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~Program() { std::filesystem::remove_all(folder_); }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  std::string operator/(const std::string& name) const { return (folder_ / name).string(); }

  /// The arguments as a shell reads them; the current folder is the test's own. `before`: commands
  /// of the shell that go first.
  Outcome run(const std::string& arguments, const std::string& before = "") const {
    return run_program(CVRBENCH_PROGRAM, arguments, before);
  }

  /// By the program whose workers fail: "FAULT CODEC STAGE" of tests/faults.
  Outcome run_with_fault(const std::string& fault, const std::string& arguments) const {
    return run_program(CVRBENCH_FAULTY, arguments, "CVRBENCH_TEST_FAULT='" + fault + "' ");
  }

  /// By another program of the same command line.
  Outcome run_program(const std::string& program, const std::string& arguments,
                      const std::string& before) const {
    const std::string command =
        "cd " + folder_.string() + " && " + before + "XDG_CACHE_HOME=" + (*this / "cache") +
        " XDG_DATA_HOME=" + (*this / "share") + " CVRBENCH_DATA= " + program + " " + arguments +
        " 2>" + (*this / "stderr");
    FILE* pipe = popen(command.c_str(), "r");
    Outcome outcome{-1, "", ""};
    std::array<char, 4096> block;
    for (std::size_t got = 0; (got = fread(block.data(), 1, block.size(), pipe)) > 0;)
      outcome.out.append(block.data(), got);
    const int status = pclose(pipe);
    outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    outcome.err = read("stderr");
    return outcome;
  }

  /// Within so many bytes of address space.
  Outcome run_within(std::uint64_t address_space, const std::string& arguments) const {
    return run(arguments, "ulimit -v " + std::to_string(address_space / 1024) + "; ");
  }

  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::string read(const std::string& name) const {
    std::ifstream in(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace cvr::cli_tests
