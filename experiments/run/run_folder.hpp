// The folder of a run while the run goes on: the lock that keeps every other run out, rows.jsonl,
// the scratch files of the workers.
//
// The lock comes first: nothing in the folder is read for good, changed or removed before it is
// held, and it is held until all configurations of a command have ended. It is a lock of the system
// on OUT/.lock and so ends with the process, however that ends; the file stays, and is empty.
#pragma once

#include <memory>
#include <string>

#include "experiments/results/rows.hpp"

namespace cvr::experiments {

/// Holders in one process share the lock of a folder: a command takes it for all of its runs, each
/// run takes it again.
class RunLock {
 public:
  /// Makes the folder where there is none. Throws OutputError where that fails, InputError while
  /// another process holds the lock.
  static std::shared_ptr<const RunLock> take(const std::string& folder);
  explicit RunLock(const std::string& folder);

 private:
  LockedFile file_;
};

class RunFolder {
 public:
  /// Takes the lock, removes what a killed run has left, and makes the scratch folder. Throws as
  /// RunLock and RowWriter.
  explicit RunFolder(const std::string& out);
  /// Removes the scratch files.
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  const std::string& path() const { return out_; }
  const std::string& scratch() const { return scratch_; }
  std::string file(const std::string& name) const;
  void append(const Result& result) { rows_.append(result); }
  /// Removes what workers left there (encoded files, reference images, results of verification),
  /// and nothing else.
  void empty_scratch() const;

 private:
  std::string out_, scratch_;
  std::shared_ptr<const RunLock> lock_;
  RowWriter rows_;
};

}  // namespace cvr::experiments
