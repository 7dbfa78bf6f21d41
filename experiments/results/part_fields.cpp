// The tables of what is measured of a cell (result.hpp, Parts and what it is made of).
#include "experiments/results/fields.hpp"

namespace cvr::experiments {

namespace {

constexpr const char* kFrom0 = R"({"minimum": 0})";
constexpr const char* kFrom1 = R"({"minimum": 1})";
constexpr const char* kFrom2 = R"({"minimum": 2})";

}  // namespace

template <>
FieldTable<Repeated> table_of() {
  using S = Repeated;
  return FieldTable<S>()
      .required("median", &S::median)
      .required("mad", &S::mad)
      .required("lower_quartile", &S::lower_quartile)
      .required("upper_quartile", &S::upper_quartile)
      .required("interval", &S::interval)
      .required("interval_coverage", &S::interval_coverage)
      .required("minimum", &S::minimum)
      .required("maximum", &S::maximum)
      .required("mean", &S::mean)
      .required("note", &S::note)
      .required("samples", &S::samples, "", R"({"minItems": 1})");
}

template <>
Row Carrier<Repeated>::schema() {
  return {{"$ref", "#/$defs/statistics"}};
}

template <>
FieldTable<Parts::Device> table_of() {
  using S = Parts::Device;
  return FieldTable<S>()
      .required("name", &S::name)
      .required("type", &S::type, "software: device times are CPU times",
                R"({"enum": ["software", "integrated", "discrete", "virtual", "other"]})")
      .required("driver", &S::driver)
      .required("api", &S::api);
}

template <>
FieldTable<Parts::Verification> table_of() {
  using S = Parts::Verification;
  return FieldTable<S>()
      .optional("voxels_compared", &S::voxels_compared)
      .optional("mismatches", &S::mismatches)
      .optional("same_bytes_with_threads", &S::same_bytes_with_threads,
                "two thread counts that gave the same bytes")
      .optional(
          "points_compared", &S::points_compared,
          "single voxels, all series, with the original or of lossy codecs the decoded volume; a "
          "mismatch fails the cell")
      .optional(
          "labels_compared", &S::labels_compared,
          "stage label-statistics: labels whose voxels and bounding boxes are those of a plain "
          "count of the original; a difference fails the cell",
          kFrom1)
      .optional(
          "pixels_compared", &S::pixels_compared,
          "of three views, and of the fixed one where there is one, with the reference and with "
          "codec raw where the device has room for it")
      .optional("label_mismatches", &S::label_mismatches,
                "labels other than the reference's that are no near-ties; one fails the cell",
                R"({"const": 0})")
      .optional("near_ties", &S::near_ties,
                "labels that the reference has with its ray moved by 10^-4 voxels")
      .optional("other_colours", &S::other_colours,
                "pixels of which a channel differs from the reference's by more than 1.5/255")
      .optional("same_as_raw", &S::same_as_raw,
                "labels and colours are exactly those of codec raw without a cache on the device",
                R"({"const": true})")
      .optional("samples", &S::samples, "random rays per pixel in these images")
      .optional("psnr_db", &S::psnr_db, "against the reference, the worst view; null where equal")
      .optional("largest_difference", &S::largest_difference,
                "of a colour channel in 0 .. 1, against the reference");
}

template <>
FieldTable<Parts::Error> table_of() {
  using S = Parts::Error;
  return FieldTable<S>()
      .required("psnr_db", &S::psnr_db,
                "peak 255 for u8, else the range of the original; null where equal")
      .required("exact", &S::exact)
      .required("largest_error", &S::largest_error,
                "absolute; null where a decoded voxel is not finite")
      .required("mean_squared_error", &S::mean_squared_error)
      .required("mean_absolute_error", &S::mean_absolute_error)
      .required(
          "edge_mean_squared_error", &S::edge_mean_squared_error,
          "over the 5 % of the voxels of steepest gradient; null where no voxel has a gradient")
      .required("edge_psnr_db", &S::edge_psnr_db)
      .required("edge_voxels", &S::edge_voxels)
      .required("non_finite_voxels", &S::non_finite_voxels, "of the original, in no error")
      .optional("time_steps", &S::time_steps, "of a series", kFrom2)
      .optional("worst_step", &S::worst_step,
                "the time step of a series with the largest mean squared error", kFrom0)
      .optional("worst_step_psnr_db", &S::worst_step_psnr_db,
                "its PSNR, by the peak of the whole series; null where equal")
      .optional("relative_error", &S::relative_error,
                "of f32: |error| / |voxel| that 50, 90 and 99 % of the voxels other than 0 do not "
                "exceed")
      .optional("recorded", &S::recorded, "what the file promises; another error fails the cell",
                R"({"required": ["largest_error", "mean_squared_error"]})");
}

template <>
FieldTable<Parts::Step> table_of() {
  using S = Parts::Step;
  return FieldTable<S>()
      .required("name", &S::name)
      .required("bytes", &S::bytes, "of the file that the step needs")
      .required("bits_per_voxel", &S::bits_per_voxel)
      .required("psnr_db", &S::psnr_db)
      .required("largest_error", &S::largest_error)
      .optional("seconds", &S::seconds, "of decoding it; stage decode");
}

template <>
FieldTable<Parts::Size> table_of() {
  using S = Parts::Size;
  return FieldTable<S>()
      .required("bytes", &S::bytes, "of the whole file")
      .required("published_bytes", &S::published_bytes, "by the accounting of the papers' tables")
      .required("rate", &S::rate, "percent: bytes / bytes of the original in its stored type")
      .required("published_rate", &S::published_rate,
                "percent: published_bytes / (voxels x published_bytes_per_voxel)")
      .required("published_bytes_per_voxel", &S::published_bytes_per_voxel)
      .required("bits_per_voxel", &S::bits_per_voxel)
      .optional("gpu_bytes", &S::gpu_bytes, "of lossy codecs that a GPU decodes: all buffers there")
      .optional("gpu_bits_per_voxel", &S::gpu_bits_per_voxel)
      .optional(
          "bound", &S::bound,
          "of lossy codecs whose parameters promise a largest absolute error: that promise, in "
          "voxel values")
      .optional(
          "bound_kept", &S::bound_kept,
          "whether the encoder's own measurement (error.recorded.largest_error) is at most the "
          "bound")
      .required("breakdown", &S::breakdown, "sums to bytes")
      .optional("checksums", &S::checksums,
                "XXH3-64 of each section of the file, in their order: envelope, then steps of a "
                "progressive codec or what its payload begins with, and the rest",
                R"({"additionalProperties": {"type": "string", "pattern": "^[0-9a-f]{16}$"}})")
      .optional(
          "entropy_bytes", &S::entropy_bytes,
          "stage encode, of codecs with an entropy coder of their own: what operations and stop "
          "bits take at the empirical entropy of the codec's own contexts and alphabets, its "
          "tables for nothing")
      .optional("rate_gzip", &S::rate_gzip, "percent, the whole file through gzip -6")
      .optional("rate_xz", &S::rate_xz, "percent, the whole file through xz -6");
}

template <>
FieldTable<Parts::DrawnStep> table_of() {
  using S = Parts::DrawnStep;
  return FieldTable<S>().required("name", &S::name).required("bytes", &S::bytes);
}

template <>
FieldTable<Parts::Spread> table_of() {
  using S = Parts::Spread;
  return FieldTable<S>()
      .required("min_ms", &S::min_ms)
      .required("mean_ms", &S::mean_ms)
      .required("median_ms", &S::median_ms)
      .required("p95_ms", &S::p95_ms)
      .required("p99_ms", &S::p99_ms)
      .required("max_ms", &S::max_ms);
}

template <>
FieldTable<Parts::Pass> table_of() {
  using S = Parts::Pass;
  return FieldTable<S>().required("median_ms", &S::median_ms).required("mean_ms", &S::mean_ms);
}

template <>
FieldTable<Parts::Incomplete> table_of() {
  using S = Parts::Incomplete;
  return FieldTable<S>()
      .required("first", &S::first)
      .required("median", &S::median)
      .required("largest", &S::largest);
}

template <>
FieldTable<Parts::FrameTimes> table_of() {
  using S = Parts::FrameTimes;
  return FieldTable<S>()
      .required("count", &S::count, "frames per round", kFrom1)
      .required("rounds", &S::rounds, "", kFrom1)
      .all_of<Parts::Spread>()
      .required(
          "wall", &S::wall,
          "wall time of a frame in ms, from the end of one wait for the device to the end of the "
          "next")
      .required("passes", &S::passes)
      .required("host_median_ms", &S::host_median_ms, "wall time of a frame, waiting included")
      .required("incomplete", &S::incomplete, "pixels of a frame that met a placeholder")
      .required("ms", &S::ms, "every frame, round by round");
}

template <>
FieldTable<Parts::Frames> table_of() {
  using S = Parts::Frames;
  return FieldTable<S>()
      .all_of<Parts::FrameTimes>()
      .required("first_round_mean_ms", &S::first_round_mean_ms)
      .required("first_frame_ms", &S::first_frame_ms, "median over the rounds")
      .required("first", &S::first, "first frames of the first round", R"({"maxItems": 16})");
}

template <>
FieldTable<Parts::Held> table_of() {
  using S = Parts::Held;
  return FieldTable<S>()
      .optional("key", &S::key, "of the camera path, from 0", kFrom0)
      .optional("exact_after_frames", &S::exact_after_frames,
                "from an empty cache; parts of the image where the cache is too small for all",
                kFrom1)
      .optional("compared", &S::compared,
                "false: the cache is too small for the whole view, so a warm frame lacks pixels")
      .optional("cells_read", &S::cells_read,
                "in one warm frame, by a kernel that counts; so the next two")
      .optional("cells_decoded", &S::cells_decoded)
      .optional("bytes_touched", &S::bytes_touched, "of the encoding")
      .optional("cache_complete", &S::cache_complete,
                "nothing was decoded and no pixel incomplete; null: the mode has no cache")
      .all_of<Parts::FrameTimes>();
}

template <>
FieldTable<Parts::Pictures> table_of() {
  using S = Parts::Pictures;
  return FieldTable<S>()
      .required("picture", &S::picture)
      .required("difference", &S::difference)
      .required("gain", &S::gain, "what differences are multiplied by")
      .required("psnr_db", &S::psnr_db, "of the fixed view; null where equal")
      .required("ssim", &S::ssim);
}

template <>
FieldTable<Parts::JumpFrame> table_of() {
  using S = Parts::JumpFrame;
  return FieldTable<S>()
      .required("psnr_db", &S::psnr_db, "null where equal")
      .required("label_mismatches", &S::label_mismatches)
      .required("incomplete", &S::incomplete)
      .required("ms", &S::ms);
}

template <>
FieldTable<Parts::Jump> table_of() {
  using S = Parts::Jump;
  return FieldTable<S>().required("frames", &S::frames).required("pixels", &S::pixels);
}

template <>
FieldTable<Parts::PictureError> table_of() {
  using S = Parts::PictureError;
  return FieldTable<S>()
      .required("psnr_db", &S::psnr_db, "null where equal")
      .required("ssim", &S::ssim)
      .optional("largest", &S::largest, "of scalars: largest channel difference")
      .optional("label_mismatches", &S::label_mismatches)
      .required("pixels", &S::pixels)
      .optional("samples_of_truth", &S::samples_of_truth);
}

template <>
FieldTable<Parts::Needed> table_of() {
  using S = Parts::Needed;
  return FieldTable<S>()
      .required("visits", &S::visits, "of cells by rays, in bricks with a visible label")
      .required("distinct_cells", &S::distinct_cells)
      .required("distinct_bricks", &S::distinct_bricks)
      .required("cells_read", &S::cells_read)
      .required("cells_decoded", &S::cells_decoded)
      .required("bytes_touched", &S::bytes_touched, "of the encoding")
      .required("decoded_over_needed", &S::decoded_over_needed, "cells_decoded / distinct_cells");
}

template <>
FieldTable<Parts::LabelStatistics> table_of() {
  using S = Parts::LabelStatistics;
  return FieldTable<S>()
      .required("labels", &S::labels, "distinct labels, background included", kFrom1)
      .required("by", &S::by, "what is decoded where decoding is needed",
                R"({"enum": ["bricks", "volume"]})")
      .required("bricks", &S::bricks, "0: the codec has none", kFrom0)
      .required("bricks_decoded", &S::bricks_decoded,
                "the others have one label, which is told without decoding", kFrom0)
      .optional("ns_per_voxel", &S::ns_per_voxel, "from the median of the seconds", kFrom0);
}

template <>
FieldTable<Parts::Memory> table_of() {
  using S = Parts::Memory;
  return FieldTable<S>()
      .optional("gpu_bytes", &S::gpu_bytes, "of the device, all uses together")
      .optional("gpu_uses", &S::gpu_uses)
      .required("peak_bytes", &S::peak_bytes,
                "largest resident memory of the worker after its check, mapped input included")
      .required("peak_over_input", &S::peak_over_input,
                "peak_bytes without the bytes of the mapped input, in bytes")
      .optional("check_peak_bytes", &S::check_peak_bytes,
                "largest resident memory of the worker up to the end of its check");
}

template <>
FieldTable<Parts::Time> table_of() {
  using S = Parts::Time;
  return FieldTable<S>()
      .required("rounds", &S::rounds)
      .required("stop", &S::stop, "why no more rounds: target, largest number, time-out")
      .required("relative_interval", &S::relative_interval,
                "width of the 95 % interval of the median / median; null where it does not exist")
      .optional("seconds", &S::seconds)
      .optional("cpu_seconds", &S::cpu_seconds)
      .optional("gb_per_s", &S::gb_per_s, "10^9 bytes of the original per second, from the median")
      .optional("mvoxel_per_s", &S::mvoxel_per_s);
}

template <>
FieldTable<Parts::Access> table_of() {
  using S = Parts::Access;
  return FieldTable<S>()
      .required("points", &S::points, "", R"({"enum": ["uniform", "clustered", "one-label"]})")
      .required("lod", &S::lod)
      .required("count", &S::count)
      .required("ns_per_voxel", &S::ns_per_voxel)
      .required("cpu_ns_per_voxel", &S::cpu_ns_per_voxel);
}

template <>
FieldTable<Parts> table_of() {
  using S = Parts;
  return FieldTable<S>()
      .optional("device", &S::device, "that drew; times compare only where it is the same")
      .optional("verification", &S::verification, "",
                R"({"anyOf": [{"required": ["voxels_compared", "mismatches"]},
                        {"required": ["pixels_compared"]}, {"required": ["labels_compared"]}]})")
      .optional(
          "error", &S::error,
          "of the decoded finest level, of lossy codecs; in voxel values, over the finite voxels "
          "of the original")
      .optional("steps", &S::steps, "of progressive codecs, coarse to whole")
      .optional("size", &S::size)
      .optional("step", &S::step,
                "of images of a progressive codec: the step that is drawn, and the bytes of the "
                "payload that it needs")
      .optional("start", &S::start, "seconds before the first frame: upload_s, kernels_s, scene_s")
      .optional(
          "held", &S::held,
          "frames of one view once its image is converged and the cache filled, each drawn anew; "
          "statistics as in frames")
      .optional(
          "exact_after_frames", &S::exact_after_frames,
          "most frames of three views until the image was converged, each from an empty cache")
      .optional("pictures", &S::pictures,
                "files in OUT/pictures: the fixed view, and its difference to the reference of the "
                "original")
      .optional(
          "jump", &S::jump,
          "the first frames after the camera has jumped to a view that the cache has not seen, "
          "compared with the converged image")
      .optional(
          "picture_error", &S::picture_error,
          "of labels one view with this cell's levels and samples against the reference with "
          "level bias 0 and many samples; of scalars three views against the reference of the "
          "original")
      .optional(
          "needed", &S::needed,
          "converged images of three views, each from an empty cache, beside the work that the "
          "reference needs for them")
      .optional("counters", &S::counters,
                "work of the path drawn once, by kernels that count and are not timed")
      .optional("destination", &S::destination, "where decoded voxels went",
                R"({"enum": ["whole volume", "one slab"]})")
      .optional("points_per_series", &S::points_per_series)
      .optional("access_by", &S::access_by,
                "stage random-access: what is decoded to answer a point",
                R"({"enum": ["voxel", "brick"]})")
      .optional(
          "label_statistics", &S::label_statistics,
          "stage label-statistics: voxels and bounding box of every label, from the encoded form")
      .optional("time", &S::time)
      .optional("access", &S::access)
      .optional(
          "frames", &S::frames,
          "device time in ms; a round is the camera path from an empty cache; statistics are of "
          "the rounds after the first where there are any")
      .optional("memory", &S::memory);
}

template Row to_json(const Named<double>&);
template Row to_json(const Parts&);
template Row to_json(const Parts::Device&);
template Row to_json(const Parts::Error&);
template Row to_json(const Parts::Size&);
template Row to_json(const Parts::Memory&);
template Row to_json(const Parts::Verification&);
template Parts from_json(const Row&);

}  // namespace cvr::experiments
