#pragma once

#include <filesystem>
#include <string>

namespace atropos::experiments {

/// A folder that appears whole or not at all: written beside its place as `NAME.partial`, renamed by
/// commit(), removed by the destructor otherwise.
class OutputFolder {
  public:
    /// What is done with an interrupted run's `NAME.partial`, and with this one's when it fails.
    enum class Leftover {
        kRemove,
        kKeepOnFailure,  ///< begins anew, leaves what it has when it fails
        kContinue,       ///< goes on with what is there
    };

    /// Throws scenes::FileError when `target` is a non-empty folder and not `force`, a file, or can't be
    /// made.
    OutputFolder(std::filesystem::path target, bool force, Leftover leftover = Leftover::kRemove);
    ~OutputFolder();
    OutputFolder(const OutputFolder&) = delete;
    OutputFolder& operator=(const OutputFolder&) = delete;

    /// Where to write until commit().
    const std::filesystem::path& path() const { return partial_; }
    const std::filesystem::path& target() const { return target_; }

    /// Replaces the target by what was written.
    void commit();

  private:
    std::filesystem::path target_;
    std::filesystem::path partial_;
    Leftover leftover_;
    bool committed_ = false;
};

/// Throws scenes::FileError when the output can't be placed at `target`; call before long work.
void check_output(const std::filesystem::path& target, bool force);

/// Writes a whole file, or throws scenes::FileError and leaves none behind (full disk included).
void write_file(const std::filesystem::path& file, const std::string& bytes);

}  // namespace atropos::experiments
