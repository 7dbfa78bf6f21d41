#include "experiments/cli/interruption.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "volumes/io/unfinished.hpp"

namespace cvr::experiments::cli {

InterruptWatch::InterruptWatch() {
  sigemptyset(&watched_);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    sigaction(number, nullptr, &action);
    if (action.sa_handler != SIG_IGN) sigaddset(&watched_, number);
  }
  signals_ = signalfd(-1, &watched_, SFD_CLOEXEC);
  stop_ = eventfd(0, EFD_CLOEXEC);
  if (signals_ < 0 || stop_ < 0)
    throw std::system_error(errno, std::generic_category(), "watching for signals");
  pthread_sigmask(SIG_BLOCK, &watched_, &before_);
  thread_ = std::thread([this] { watch(); });
}

InterruptWatch::~InterruptWatch() {
  const std::uint64_t one = 1;
  static_cast<void>(::write(stop_, &one, sizeof one));
  thread_.join();
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  ::close(signals_);
  ::close(stop_);
}

void InterruptWatch::watch() {
  std::array<pollfd, 2> waited{{{signals_, POLLIN, 0}, {stop_, POLLIN, 0}}};
  while (true) {
    if (::poll(waited.data(), waited.size(), -1) < 0) continue;
    signalfd_siginfo told{};
    if ((waited[0].revents & POLLIN) != 0 && ::read(signals_, &told, sizeof told) == sizeof told) {
      end_by(static_cast<int>(told.ssi_signo));
    }
    if ((waited[1].revents & POLLIN) != 0) return;
  }
}

void InterruptWatch::end_by(int signal_number) {
  if (const pid_t child = child_; child > 0) {
    ::kill(child, SIGTERM);
    siginfo_t ignored{};
    while (::waitid(P_PID, static_cast<id_t>(child), &ignored, WEXITED | WNOWAIT) != 0 &&
           errno == EINTR)
      continue;
  }
  volumes::abandon_outputs();
  ::signal(signal_number, SIG_DFL);
  sigset_t one;
  sigemptyset(&one);
  sigaddset(&one, signal_number);
  pthread_sigmask(SIG_UNBLOCK, &one, nullptr);
  ::raise(signal_number);
  ::_exit(128 + signal_number);
}

}  // namespace cvr::experiments::cli
