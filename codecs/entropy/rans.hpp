// Byte-wise range asymmetric numeral systems over at most 16 symbols with static tables (Duda 2013;
// the byte-wise form is a public-domain technique of F. Giesen).
//
// State of 32 bits, lower bound 2^23, probabilities in units of 2^-14. What surprises first: the
// encoder runs backwards over the symbols and writes its bytes from the end of the buffer to the
// front, so that the decoder runs forwards over both. A stream begins with the final state (u32,
// little endian) and is followed by the renormalisation bytes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace cvr::codecs::entropy {

inline constexpr unsigned kRansSymbols = 16;
inline constexpr unsigned kRansProbabilityBits = 14;
inline constexpr std::uint32_t kRansProbabilitySum = 1u << kRansProbabilityBits;
inline constexpr std::uint32_t kRansLowerBound = 1u << 23;

/// Frequencies that sum to 2^14; what can never occur has none.
class RansTable {
 public:
  RansTable() = default;
  /// Scales counts; every symbol in the mask `possible` gets at least 1. `possible` must not be 0.
  static RansTable fit(const std::array<std::uint64_t, kRansSymbols>& counts,
                       std::uint32_t possible);
  /// False if the frequencies do not sum to 2^14.
  static bool from_frequencies(const std::array<std::uint16_t, kRansSymbols>& frequencies,
                               RansTable& table);

  const std::array<std::uint16_t, kRansSymbols>& frequencies() const { return frequencies_; }

  /// One word a slot, as shaders/shared/csgv_serial.glsl reads them: bits 0..3 the symbol, 4..17
  /// its frequency - 1, 18..31 the slot's place among those of the symbol.
  std::vector<std::uint32_t> packed_slots() const;

  /// Appends the stream of `symbols` to `out`, nothing for no symbols. Every symbol must have a
  /// frequency.
  void encode(std::span<const std::uint8_t> symbols, std::vector<std::uint8_t>& out) const;

 private:
  friend class RansDecoder;
  struct Step {
    std::uint64_t reciprocal =
        0;  ///< ceil(2^(31 + shift) / frequency): divides states below 2^31 exactly
    std::uint32_t shift = 0;
    std::uint32_t limit = 0;  ///< a state at or above it sheds a byte first
    std::uint32_t frequency = 0;
    std::uint32_t start = 0;
  };
  void build();

  std::array<std::uint16_t, kRansSymbols> frequencies_{};
  std::array<Step, kRansSymbols> steps_{};
  std::vector<std::uint8_t> symbol_of_slot_;
};

/// Reads one stream forwards. Reading past its end gives zero bytes and sets failed().
class RansDecoder {
 public:
  RansDecoder() = default;
  RansDecoder(const RansTable& table, std::span<const std::uint8_t> bytes)
      : table_(&table), at_(bytes.data()), end_(bytes.data() + bytes.size()) {
    for (unsigned i = 0; i < 4; ++i) state_ |= std::uint32_t{next_byte()} << (8 * i);
  }

  std::uint8_t next() {
    const std::uint32_t slot = state_ & (kRansProbabilitySum - 1);
    const std::uint8_t symbol = table_->symbol_of_slot_[slot];
    const RansTable::Step& step = table_->steps_[symbol];
    state_ = step.frequency * (state_ >> kRansProbabilityBits) + slot - step.start;
    while (state_ < kRansLowerBound) {
      if (at_ == end_) {
        failed_ = true;
        state_ |= kRansLowerBound;
        return symbol;
      }
      state_ = state_ << 8 | *at_++;
    }
    return symbol;
  }
  bool failed() const { return failed_; }

 private:
  std::uint8_t next_byte() {
    if (at_ != end_) return *at_++;
    failed_ = true;
    return 0;
  }

  const RansTable* table_ = nullptr;
  const std::uint8_t* at_ = nullptr;
  const std::uint8_t* end_ = nullptr;
  std::uint32_t state_ = 0;
  bool failed_ = false;
};

}  // namespace cvr::codecs::entropy
