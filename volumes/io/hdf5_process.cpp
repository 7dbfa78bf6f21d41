#include "volumes/io/hdf5_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/io/hdf5_handle.hpp"

namespace cvr::volumes {

namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kMaximumMessage = std::uint64_t{1} << 30;
constexpr std::chrono::seconds kWaitAtLeast{
    120};  ///< for a reply, whatever the child computes: slow disks
constexpr unsigned kWaitPerCpuSecond = 10;

/// All bytes or false.
bool send_all(int socket, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t sent = ::send(socket, at, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += sent;
    size -= static_cast<std::size_t>(sent);
  }
  return true;
}

enum class Received { kAll, kEnd, kTimeout };

Received receive_all(int socket, void* data, std::size_t size, Clock::time_point deadline) {
  char* at = static_cast<char*>(data);
  while (size > 0) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return Received::kTimeout;
    pollfd ready{socket, POLLIN, 0};
    const int count = ::poll(&ready, 1, static_cast<int>(std::min<long long>(left, INT_MAX)));
    if (count <= 0) continue;  // interrupted, or the deadline
    const ssize_t got = ::recv(socket, at, size, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return Received::kEnd;
    at += got;
    size -= static_cast<std::size_t>(got);
  }
  return Received::kAll;
}

bool send_message(int socket, const Json& message) {
  const std::vector<std::uint8_t> bytes = Json::to_cbor(message);
  const std::uint64_t size = bytes.size();
  return send_all(socket, &size, sizeof size) && send_all(socket, bytes.data(), bytes.size());
}

Received receive_message(int socket, Json& message, Clock::time_point deadline) {
  std::uint64_t size = 0;
  if (const Received got = receive_all(socket, &size, sizeof size, deadline); got != Received::kAll)
    return got;
  if (size > kMaximumMessage) return Received::kEnd;
  std::vector<std::uint8_t> bytes(size);
  if (const Received got = receive_all(socket, bytes.data(), size, deadline); got != Received::kAll)
    return got;
  message = Json::from_cbor(bytes, true, false);
  return message.is_object() ? Received::kAll : Received::kEnd;
}

/// From now on the child may compute for `seconds` more.
void limit_computing(unsigned seconds) {
  rusage usage{};
  rlimit limit{};
  ::getrusage(RUSAGE_SELF, &usage);
  ::getrlimit(RLIMIT_CPU, &limit);
  const auto used = static_cast<rlim_t>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec + 1);
  limit.rlim_cur = std::min<rlim_t>(used + seconds, limit.rlim_max);
  ::setrlimit(RLIMIT_CPU, &limit);
}

/// Descriptors, signals, limits and the library's settings of the child. Returns the socket's new
/// number.
int settle_in(int socket) {
  constexpr int kSocket = 3;
  const int null = ::open("/dev/null", O_RDWR);
  const int spare = ::fcntl(socket, F_DUPFD, kSocket + 1);
  ::dup2(spare, kSocket);
  for (int standard = 0; standard < kSocket; ++standard) ::dup2(null, standard);
  ::close_range(kSocket + 1, ~0u, 0);
  for (const int signal : {SIGTERM, SIGXCPU, SIGALRM, SIGCHLD}) std::signal(signal, SIG_DFL);
  // What the program does about its own faults is not to be done for the library's.
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT}) std::signal(signal, SIG_DFL);
  for (const int signal : {SIGINT, SIGQUIT, SIGHUP, SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  // Where the library looks for files that a volume names is decided here, not by the environment.
  for (const char* name : {"HDF5_EXTFILE_PREFIX", "HDF5_EXT_PREFIX", "HDF5_VDS_PREFIX"})
    ::unsetenv(name);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  return kSocket;
}

Json answer(const Hdf5Process::Serve& serve, const Json& message, std::span<std::byte> shared) {
  try {
    limit_computing(message.at("cpu_seconds").get<unsigned>());
    return {{"result", serve(message.at("request"), shared)}};
  } catch (const InputError& error) {
    return {{"input_error", error.what()}};
  } catch (const OutputError& error) {
    return {{"output_error", error.what()}};
  } catch (const std::bad_alloc&) {
    return {{"failure", "more memory needed than there is"}};
  } catch (const std::exception& error) {
    return {{"failure", error.what()}};
  }
}

[[noreturn]] void run_child(int socket, std::span<std::byte> shared,
                            const Hdf5Process::Serve& serve) {
  const int own = settle_in(socket);
  Json message;
  while (receive_message(own, message, Clock::time_point::max()) == Received::kAll) {
    if (!send_message(own, answer(serve, message, shared))) break;
  }
  ::_exit(0);  // no destructors and no exit handlers: libhdf5's would write
}

}  // namespace

Hdf5Process::Hdf5Process(std::size_t shared_bytes, Serve serve) {
  void* memory =
      ::mmap(nullptr, shared_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    throw Hdf5Failure(
        fmt::format("no memory of {} bytes to share with the process that uses HDF5: {}",
                    shared_bytes, std::strerror(errno)));
  }
  shared_ = {static_cast<std::byte*>(memory), shared_bytes};
  std::array<int, 2> ends{-1, -1};
  {
    // No other thread uses the library while its state is copied, nor starts a child that would
    // keep the far end of this socket.
    const Hdf5Session session;
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0) child_ = ::fork();
    if (child_ == 0) run_child(ends[1], shared_, serve);
    if (ends[1] >= 0) ::close(ends[1]);
  }
  socket_ = ends[0];
  if (child_ < 0) {
    const std::string reason = std::strerror(errno);
    if (socket_ >= 0) ::close(socket_);
    ::munmap(memory, shared_bytes);
    throw Hdf5Failure("no process could be started to use HDF5: " + reason);
  }
}

Hdf5Process::~Hdf5Process() {
  ::close(socket_);
  if (child_ > 0) {
    ::kill(child_, SIGKILL);
    while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) continue;
  }
  ::munmap(shared_.data(), shared_.size());
}

std::string Hdf5Process::end_of_child() const {
  int status = 0;
  pid_t ended = 0;
  while ((ended = ::waitpid(child_, &status, 0)) < 0 && errno == EINTR) continue;
  child_ = -1;
  if (ended < 0) return "the process that uses HDF5 ended";
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
    return "the HDF5 library does not come to an end";
  if (WIFSIGNALED(status)) {
    return fmt::format("the HDF5 library crashes ({})", ::strsignal(WTERMSIG(status)));
  }
  return fmt::format("the HDF5 library ends its process (status {})", WEXITSTATUS(status));
}

nlohmann::json Hdf5Process::call(const Json& request, unsigned cpu_seconds) const {
  if (child_ < 0) throw Hdf5Failure("the process that uses HDF5 has ended");
  const auto deadline =
      Clock::now() + kWaitAtLeast + std::chrono::seconds(kWaitPerCpuSecond * cpu_seconds);
  Json reply;
  Received got = Received::kEnd;
  if (send_message(socket_, {{"cpu_seconds", cpu_seconds}, {"request", request}})) {
    got = receive_message(socket_, reply, deadline);
  }
  if (got == Received::kTimeout) {
    ::kill(child_, SIGKILL);
    end_of_child();
    throw Hdf5Failure("the HDF5 library gives no answer");
  }
  if (got == Received::kEnd) {
    ::kill(child_,
           SIGKILL);  // one that lives nevertheless; a child that is ending keeps its own reason
    throw Hdf5Failure(end_of_child());
  }
  if (reply.contains("input_error")) throw InputError(reply["input_error"].get<std::string>());
  if (reply.contains("output_error")) throw OutputError(reply["output_error"].get<std::string>());
  if (reply.contains("failure")) throw Hdf5Failure(reply["failure"].get<std::string>());
  return std::move(reply["result"]);
}

}  // namespace cvr::volumes
