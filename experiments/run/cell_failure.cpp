#include "experiments/run/cell_failure.hpp"

#include <fmt/format.h>

#include <csignal>
#include <cstring>

namespace cvr::experiments {

namespace {

std::string text_in(const Row& message, const char* key) {
  return message.is_object() && message.contains(key) && message[key].is_string()
             ? message[key].get<std::string>()
             : "";
}

/// Of a worker that has said itself what went wrong, or has said something else.
CellFailure as_told(const Row& message, const std::string& when) {
  const std::string status = text_in(message, "status"), reason = text_in(message, "reason");
  if (text_in(message, "event") != "failure" || !is_status(status) || status == kOk)
    return {std::string(kFailed), fmt::format("gave an answer to {} that is none", when)};
  const bool environment = message.contains("environment") && message["environment"] == true;
  return {status, reason, environment};
}

}  // namespace

CellFailure end_and_explain(WorkerProcess& worker, WorkerProcess::Wait outcome, const Row& message,
                            const std::string& when, double timeout_s, const WorkerLimits& limits) {
  using Wait = WorkerProcess::Wait;
  const WorkerEnd end =
      worker.finish(outcome == Wait::kTimeout || outcome == Wait::kNoAnswer ? 0 : kGrace);
  if (outcome == Wait::kTimeout)
    return {std::string(kTimeout), fmt::format("{} took longer than {} s", when, timeout_s)};
  if (outcome == Wait::kMessage) return as_told(message, when);
  if (outcome == Wait::kNoAnswer)
    return {std::string(kFailed),
            fmt::format("gave an answer to {} that is none: '{}'", when, worker.said())};
  if (end.signal == SIGXCPU)
    return {std::string(kTimeout),
            fmt::format("took more than {} s of processor time by {}", limits.cpu_seconds, when)};
  if (end.signal == SIGKILL && !worker.killed())
    return {std::string(kOutOfMemory),
            fmt::format("killed by the system in {}, as it does when memory runs out", when)};
  if (worker.killed())
    return {std::string(kFailed), fmt::format("said no more in {} and did not end{}{}", when,
                                              end.complaints.empty() ? "" : ": ", end.complaints)};
  const std::string how = end.signal != 0
                              ? fmt::format("signal {} ({})", end.signal, strsignal(end.signal))
                              : fmt::format("exit code {}", end.exit_code);
  return {std::string(kFailed), fmt::format("crashed in {}: {}{}{}", when, how,
                                            end.complaints.empty() ? "" : ": ", end.complaints)};
}

}  // namespace cvr::experiments
