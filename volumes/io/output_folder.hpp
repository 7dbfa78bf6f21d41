// A folder in the making, as OutputFile is for files.
#pragma once

#include <filesystem>
#include <string>

namespace cvr::volumes {

/// A precomputed volume grows in "TARGET.part0" (or the next free number) beside its final name;
/// commit puts it there. Without commit it vanishes. What may be replaced: nothing, an empty
/// folder, and a folder that holds exactly what write_precomputed wrote.
class OutputFolder {
 public:
  /// Throws OutputError as check_output_folder does, or if the folder cannot be made.
  explicit OutputFolder(std::string path);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& partial() const { return partial_; }
  /// Throws OutputError; what was there before is then there still.
  void commit();

 private:
  void replace_old();

  std::string path_;  ///< as the caller says it
  std::filesystem::path target_, partial_;
  bool committed_ = false;
};

}  // namespace cvr::volumes
