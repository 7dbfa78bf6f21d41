#include "codecs/tvq/tvq.hpp"

#include "codecs/tvq/encoder.hpp"

namespace cvr::codecs {

namespace {

using namespace tvq;

ParameterSpec integer(std::string_view name, std::string_view value, std::int64_t minimum,
                      std::int64_t maximum, std::string_view description) {
  return {.name = name,
          .type = ParameterType::kInteger,
          .default_value = value,
          .minimum = minimum,
          .maximum = maximum,
          .description = description};
}
ParameterSpec text(std::string_view name, std::vector<std::string_view> names,
                   std::string_view description) {
  const std::string_view first = names.front();
  return {.name = name,
          .type = ParameterType::kText,
          .default_value = first,
          .names = std::move(names),
          .description = description};
}

ParameterSpec rate_parameter(std::string_view value) {
  return integer(
      "rate", value, 0, 8000,
      "planes and books, about, in 1/1000 bit per voxel: bits are chosen for it; 0: bits as given");
}

/// What all three take, after their own.
std::vector<ParameterSpec> with_common(std::vector<ParameterSpec> own) {
  own.push_back(
      text("count", {"file", "device"},
           "whose books `rate` counts: those in the file, or the entries that a device holds"));
  own.push_back(
      text("alloc", {"operational", "paper"},
           "chooses bits for `rate` by measured distortion, or by the paper's model of variances"));
  own.push_back(
      text("init", {"split", "random", "scalar", "pnn"},
           "where the LBG iteration begins: splits across principal axes, random vectors, grids of "
           "scalar quantisers, pairwise nearest neighbours"));
  own.push_back(
      text("effort", {"fast", "best"},
           "trains with a sample of the vectors, or with all of them and more iterations"));
  ParameterSpec edge = integer(
      "edge", "0", 0, 0,
      "voxels per side of sub-volumes with books of their own; 0: the whole volume, or time step");
  edge.choices = {0, 32, 64, 128, 256, 512};
  own.push_back(std::move(edge));
  own.push_back(text("books", {"step", "shared"},
                     "of a series: each time step has books of its own, or all have one set"));
  own.push_back(
      text("zero", {"zero", "least", "mode"},
           "value of the zero blocks, which are exact: 0 (or the least where 0 does not occur), "
           "the least, the most frequent (not f32)"));
  own.push_back(text("nonfinite", {"refuse", "mask"},
                     "voxels that are NaN or infinite: refused, or kept aside bit by bit"));
  own.push_back(text("codes", {"trained", "random"},
                     "trained, or random codes into random books of the given bits, whatever "
                     "`rate` says: nothing of the volume is seen, to "
                     "time decoders"));
  own.push_back(integer("seed", "1", 0, 1000000, "of init=random and codes=random"));
  return own;
}

template <class T>
T choice_of(const Parameters& parameters, std::string_view name,
            std::initializer_list<std::pair<std::string_view, T>> values) {
  for (const auto& [text, value] : values) {
    if (parameters.text(name) == text) return value;
  }
  return values.begin()->second;
}

EncoderSettings common_settings(const Parameters& parameters) {
  EncoderSettings settings;
  Options& options = settings.options;
  options.rate = static_cast<double>(parameters.integer("rate")) / 1000;
  options.count_device = parameters.text("count") == "device";
  options.operational = parameters.text("alloc") == "operational";
  options.initialisation = choice_of<Initialisation>(parameters, "init",
                                                     {{"split", Initialisation::kSplit},
                                                      {"random", Initialisation::kRandom},
                                                      {"scalar", Initialisation::kScalar},
                                                      {"pnn", Initialisation::kPnn}});
  options.best = parameters.text("effort") == "best";
  options.random_codes = parameters.text("codes") == "random";
  options.seed = static_cast<std::uint64_t>(parameters.integer("seed"));
  settings.edge = static_cast<std::uint32_t>(parameters.integer("edge"));
  settings.zero = choice_of<ZeroValue>(
      parameters, "zero",
      {{"zero", ZeroValue::kZero}, {"least", ZeroValue::kLeast}, {"mode", ZeroValue::kMode}});
  settings.shared_books = parameters.text("books") == "shared";
  settings.mask = parameters.text("nonfinite") == "mask";
  return settings;
}

class BlockCodec : public Codec {
 public:
  BlockCodec(const Scheme& scheme, std::string_view summary, std::vector<ParameterSpec> parameters)
      : scheme_(scheme),
        traits_{.id = scheme.id,
                .version = 1,
                .family = "tvq",
                .summary = summary,
                .lossless = false,
                .types = volumes::kScalarTypes,
                .access = Granularity::kVoxel,
                .levels_of_detail = false,
                .stored_compressed = false,
                .gpu_scalars = true},
        parameters_(with_common(std::move(parameters))) {}

  const Traits& traits() const override { return traits_; }
  std::span<const ParameterSpec> parameters() const override { return parameters_; }
  Expected<Payload> encode(const VolumeSource& source, const Parameters& parameters,
                           unsigned threads) const override {
    return tvq::encode(scheme_, source, settings(parameters), threads);
  }
  Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const override {
    return tvq::open(scheme_, stream);
  }

 private:
  virtual EncoderSettings settings(const Parameters& parameters) const = 0;

  const Scheme& scheme_;
  Traits traits_;
  std::vector<ParameterSpec> parameters_;
};

class VqCodec final : public BlockCodec {
 public:
  VqCodec()
      : BlockCodec(kVq, "vector quantisation of blocks of 4x4x4 voxels: one read per voxel",
                   {integer("bits", "10", 0, kMaxBookBits, "of a code, where rate=0"),
                    rate_parameter("0")}) {}

 private:
  EncoderSettings settings(const Parameters& parameters) const override {
    EncoderSettings settings = common_settings(parameters);
    settings.options.bits = {static_cast<unsigned>(parameters.integer("bits")), 0, 0};
    return settings;
  }
};

class HvqCodec final : public BlockCodec {
 public:
  HvqCodec()
      : BlockCodec(
            kHvq,
            "hierarchical vector quantisation: mean, octants, voxels (Schneider & Westermann 2003)",
            {integer("octants", "8", 0, kMaxBookBits,
                     "bits of a code of the eight octant means, where rate=0"),
             integer("voxels", "8", 0, kMaxBookBits,
                     "bits of a code of the 64 voxels, where rate=0"),
             rate_parameter("0"),
             text("loop", {"closed", "open"},
                  "voxels relative to the coded octants, or to the octants' own means"),
             integer("dc", "0", 0, kMaxDcBits,
                     "bits of a block's mean; 0: 8 for u8, else by the error of the books")}) {}

 private:
  EncoderSettings settings(const Parameters& parameters) const override {
    EncoderSettings settings = common_settings(parameters);
    settings.options.bits = {static_cast<unsigned>(parameters.integer("octants")),
                             static_cast<unsigned>(parameters.integer("voxels")), 0};
    settings.options.closed_loop = parameters.text("loop") == "closed";
    settings.options.dc_bits = static_cast<unsigned>(parameters.integer("dc"));
    return settings;
  }
};

class TvqCodec final : public BlockCodec {
 public:
  TvqCodec()
      : BlockCodec(
            kTvq,
            "transform vector quantisation: DC, LP, BP, HP with classified codebooks (Fout & Ma "
            "2007)",
            {{.name = "bits",
              .type = ParameterType::kTriple,
              .default_value = "8,8,8",
              .minimum = 0,
              .maximum = kMaxBookBits,
              .description = "of the codes of LP, BP, HP, where rate=0"},
             rate_parameter("550"),
             text("transform", {"klt-sep", "dct", "klt-full"},
                  "Karhunen-Loeve along each axis, cosine, or Karhunen-Loeve of whole blocks"),
             text("classify", {"on", "off"},
                  "a chapter of the books for each class of blocks, or one LBG book a partition"),
             text("assign", {"global", "chapter"},
                  "codes from the whole book, which is refined as a whole, or from the chapter of "
                  "the "
                  "block's class (the paper)"),
             integer("psnr", "0", 0, 120,
                     "dB: the target that tau refers to; 0: what the bits will give"),
             integer("tau", "0", 0, 1000,
                     "what a class may lose, in percent of the target's root mean squared error; "
                     "0: 70 where "
                     "psnr is given, else the best of 25 to 400"),
             integer("dc", "0", 0, kMaxDcBits,
                     "bits of a block's mean; 0: 8 for u8, else by the error of the books"),
             text("book", {"coef", "assoc"},
                  "books in the file as coefficients, or as the voxels that a device holds")}) {}

 private:
  EncoderSettings settings(const Parameters& parameters) const override {
    EncoderSettings settings = common_settings(parameters);
    Options& options = settings.options;
    options.bits = parameters.triple("bits");
    options.transform = choice_of<TransformKind>(parameters, "transform",
                                                 {{"klt-sep", TransformKind::kKltSeparable},
                                                  {"dct", TransformKind::kDct},
                                                  {"klt-full", TransformKind::kKltFull}});
    options.classify = parameters.text("classify") == "on";
    options.global = parameters.text("assign") == "global";
    options.psnr = static_cast<double>(parameters.integer("psnr"));
    options.tau = static_cast<double>(parameters.integer("tau")) / 100;
    options.dc_bits = static_cast<unsigned>(parameters.integer("dc"));
    options.coefficients = parameters.text("book") == "coef";
    return settings;
  }
};

}  // namespace

const Codec& vq_codec() {
  static const VqCodec kCodec;
  return kCodec;
}

const Codec& hvq_codec() {
  static const HvqCodec kCodec;
  return kCodec;
}

const Codec& tvq_codec() {
  static const TvqCodec kCodec;
  return kCodec;
}

}  // namespace cvr::codecs
