#include "volumes/io/text_voxels.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstring>
#include <type_traits>

namespace cvr::volumes {

namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

template <class T>
void read_numbers(const std::string& file, std::string_view text, const StoredType& type,
                  std::span<std::byte> out) {
  const std::uint64_t expected = out.size() / sizeof(T);
  std::uint64_t count = 0;
  for (std::size_t at = text.find_first_not_of(kBlanks); at != std::string_view::npos; ++count) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    std::string_view word = text.substr(at, end - at);
    if (word.starts_with('+')) word.remove_prefix(1);
    T value{};
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || stop != word.data() + word.size()) {
      throw_input_error(file, fmt::format("voxel number {}", count),
                        fmt::format("a number of type {}", name_of(type)),
                        fmt::format("'{}'", word.substr(0, 40)));
    }
    if (count < expected) std::memcpy(out.data() + count * sizeof(T), &value, sizeof value);
    at = text.find_first_not_of(kBlanks, end);
  }
  if (count != expected)
    throw_input_error(file, "voxels", fmt::format("{} numbers", expected),
                      fmt::format("{}", count));
}

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

void check_digits(const std::string& file, std::uint64_t characters, std::uint64_t bytes) {
  if (bytes <= characters / 2) return;
  throw_input_error(file, "voxels", fmt::format("{} digits, two a byte", 2 * bytes),
                    fmt::format("{} characters", characters));
}

void check_numbers(const std::string& file, std::uint64_t characters, std::uint64_t numbers) {
  if (numbers <= characters / 2 + 1) return;
  throw_input_error(file, "voxels", fmt::format("{} numbers", numbers),
                    fmt::format("{} characters", characters));
}

void read_hex_voxels(const std::string& file, std::string_view text, std::span<std::byte> out) {
  std::uint64_t digits = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (kBlanks.find(text[at]) != std::string_view::npos) continue;
    const int digit = digit_of(text[at]);
    if (digit < 0) {
      throw_input_error(file, fmt::format("character {} of the voxels", at), "a hexadecimal digit",
                        fmt::format("the byte {:#04x}", static_cast<unsigned char>(text[at])));
    }
    if (const std::uint64_t byte = digits / 2; byte < out.size()) {
      out[byte] = digits % 2 == 0 ? std::byte(digit << 4) : out[byte] | std::byte(digit);
    }
    ++digits;
  }
  if (digits != 2 * out.size()) {
    throw_input_error(file, "voxels", fmt::format("{} hexadecimal digits", 2 * out.size()),
                      fmt::format("{}", digits));
  }
}

void read_text_voxels(const std::string& file, std::string_view text, const StoredType& type,
                      std::span<std::byte> out) {
  if (type.is_float64) return read_numbers<double>(file, text, type, out);
  if (type.type == VoxelType::kF32) return read_numbers<float>(file, text, type, out);
  if (type.type == VoxelType::kI16) return read_numbers<std::int16_t>(file, text, type, out);
  with_label_type(type.type, [&]<class T>() {
    if (type.is_signed) return read_numbers<std::make_signed_t<T>>(file, text, type, out);
    read_numbers<T>(file, text, type, out);
  });
}

}  // namespace cvr::volumes
