// The encoded file that stages work on, its sizes, and its comparison with the original.
#pragma once

#include <filesystem>
#include <string_view>

#include "codecs/container.hpp"
#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

/// Rates in percent of the original: `rate` of the whole file against the stored type,
/// `published_rate` of the published bytes against `bytes_per_voxel` (0: the stored type);
/// bits_per_voxel; breakdown; of lossy codecs that a GPU decodes gpu_bytes and gpu_bits_per_voxel;
/// where the parameters promise an error the bound, and bound_kept, whether the encoder kept it.
/// Throws StageFailure if the breakdown does not sum.
Parts::Size describe_size(const codecs::OpenedFile& file, std::uint64_t file_bytes,
                          std::uint32_t bytes_per_voxel);

/// Adds rate_gzip and rate_xz: the file through gzip -6 and xz -6.
void add_rates_at_rest(std::span<const std::byte> file, std::uint64_t original_bytes,
                       Parts::Size& size);

/// Reads the encoded file that an earlier stage of this run left in the scratch folder, or encodes
/// on all cores and leaves it.
codecs::Buffer obtain_encoded(const WorkerSpec& spec, const volumes::VolumeSource& source);
void leave_in_scratch(const WorkerSpec& spec, std::span<const std::byte> file);
/// Writes a file of the scratch folder whole or not at all: one that cannot be written costs the
/// next cell its making, nothing else.
void keep_in_scratch(const std::filesystem::path& path, std::string_view content);

/// Decodes the finest level against the truth and adds "verification" to `parts`, of lossy codecs
/// also "error" with what the encoder recorded, and "steps", the bytes and PSNR of the steps of a
/// progressive decoder. Throws StageFailure when a lossless codec's voxels differ, or a lossy
/// codec's errors are not those that it recorded.
void verify(std::span<const std::byte> file, const volumes::VolumeSource& truth, unsigned threads,
            Parts& parts);

/// The same on all cores, once a run for the same bytes of the same volume: what it has found is
/// left in the scratch folder. For stages whose cells share encodings.
void verify_once(const WorkerSpec& spec, std::span<const std::byte> file,
                 const volumes::VolumeSource& truth, Parts& parts);

/// {largest_error, mean_squared_error}.
Named<double> describe_recorded(const codecs::RecordedError& recorded);

}  // namespace cvr::experiments
