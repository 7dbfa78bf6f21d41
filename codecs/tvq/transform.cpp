#include "codecs/tvq/transform.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "codecs/tvq/lanes.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs::tvq {

namespace {

constexpr double kStoredUnit = 0x1p-14;
constexpr std::uint64_t kChunk =
    4096;  // blocks whose sums are added up before they meet the others

using Matrix4 = std::array<std::array<double, 4>, 4>;

/// Zone (in partition order) of the coefficient u + 4v + 16w.
unsigned zone_of(unsigned o) {
  static constexpr std::array<std::uint8_t, kZones> kPlace{
      0, 1, 2, 4, 3, 5, 6, 7};  // octant -> place: h0 h1 h2 h4 h3 h5 h6 h7
  const unsigned octant =
      ((o & 3) >= 2 ? 1u : 0u) + ((o >> 2 & 3) >= 2 ? 2u : 0u) + ((o >> 4) >= 2 ? 4u : 0u);
  return kPlace[octant];
}

Matrix4 dct_matrix() {
  Matrix4 t{};
  for (unsigned u = 0; u < 4; ++u) {
    for (unsigned x = 0; x < 4; ++x) {
      t[u][x] = (u == 0 ? 0.5 : std::numbers::sqrt2 / 2) *
                std::cos(std::numbers::pi * (2 * x + 1) * u / 8);
    }
  }
  return t;
}

std::int16_t to_stored(double value) {
  return static_cast<std::int16_t>(std::lround(std::clamp(value, -1.0, 1.0) / kStoredUnit));
}

/// The largest component of each row becomes positive; of equals (to 10^-6) the first.
void fix_signs(std::vector<double>& rows, unsigned n) {
  for (unsigned r = 0; r < n; ++r) {
    double* row = rows.data() + r * n;
    double largest = 0;
    for (unsigned i = 0; i < n; ++i) largest = std::max(largest, std::abs(row[i]));
    const double* first = std::find_if(
        row, row + n, [largest](double v) { return std::abs(v) >= (1 - 1e-6) * largest; });
    if (*first < 0) std::transform(row, row + n, row, std::negate<>());
  }
}

/// Adds a little more variance to lower orders, so that equal variances leave the vectors where
/// they are.
void regularise(std::vector<double>& matrix, unsigned n) {
  double trace = 0;
  for (unsigned i = 0; i < n; ++i) trace += matrix[i * n + i];
  if (!(trace > 0)) {
    std::ranges::fill(matrix, 0.0);
    trace = 1e9;
  }
  for (unsigned i = 0; i < n; ++i)
    matrix[i * n + i] += 1e-9 * trace / n * (1.0 - static_cast<double>(i) / n);
}

/// Sums over all blocks of body(block, sums), chunk by chunk, the same for any number of threads.
template <class F>
std::vector<double> sum_blocks(std::span<const float> blocks, unsigned threads, std::size_t sums,
                               F&& body) {
  const std::uint64_t count = blocks.size() / kBlockVoxels;
  const std::uint64_t chunks = (count + kChunk - 1) / kChunk;
  std::vector<std::vector<double>> partial(chunks);
  volumes::parallel_for(threads, chunks, [&](unsigned, std::uint64_t c) {
    partial[c].assign(sums, 0.0);
    for (std::uint64_t b = c * kChunk; b < std::min(count, (c + 1) * kChunk); ++b)
      body(blocks.data() + b * kBlockVoxels, partial[c].data());
  });
  std::vector<double> total(sums, 0.0);
  for (const auto& part : partial) {
    for (std::size_t i = 0; i < sums; ++i) total[i] += part[i];
  }
  return total;
}

std::vector<std::int16_t> fit_separable(std::span<const float> blocks, unsigned threads) {
  // Second moments of the lines of each axis, in samples: exact for integers; the rotation to the
  // DCT comes after the sum.
  const std::vector<double> moments =
      sum_blocks(blocks, threads, 3 * 16, [](const float* block, double* sums) {
        static constexpr unsigned kStep[3] = {1, 4, 16}, kFirst[3] = {4, 1, 1},
                                  kSecond[3] = {16, 16, 4};
        for (unsigned axis = 0; axis < 3; ++axis) {
          for (unsigned line = 0; line < 16; ++line) {
            const float* at = block + (line & 3) * kFirst[axis] + (line >> 2) * kSecond[axis];
            double v[4];
            for (unsigned i = 0; i < 4; ++i) v[i] = static_cast<double>(at[i * kStep[axis]]);
            for (unsigned i = 0; i < 4; ++i) {
              for (unsigned j = 0; j < 4; ++j) sums[axis * 16 + i * 4 + j] += v[i] * v[j];
            }
          }
        }
      });
  const Matrix4 t = dct_matrix();
  std::vector<std::int16_t> stored;
  for (unsigned axis = 0; axis < 3; ++axis) {
    std::vector<double> c(9, 0.0);
    for (unsigned u = 1; u < 4; ++u) {
      for (unsigned v = 1; v < 4; ++v) {
        for (unsigned i = 0; i < 4; ++i) {
          for (unsigned j = 0; j < 4; ++j)
            c[(u - 1) * 3 + v - 1] += t[u][i] * moments[axis * 16 + i * 4 + j] * t[v][j];
        }
      }
    }
    for (unsigned u = 0; u < 3; ++u) {
      for (unsigned v = 0; v < u; ++v) c[u * 3 + v] = c[v * 3 + u];
    }
    regularise(c, 3);
    std::vector<double> q = eigenvectors(std::move(c), 3);
    fix_signs(q, 3);
    for (unsigned x = 0; x < 4; ++x) stored.push_back(to_stored(0.5));
    for (unsigned r = 0; r < 3; ++r) {
      for (unsigned x = 0; x < 4; ++x) {
        double value = 0;
        for (unsigned u = 0; u < 3; ++u) value += q[r * 3 + u] * t[u + 1][x];
        stored.push_back(to_stored(value));
      }
    }
  }
  return stored;
}

std::vector<std::int16_t> fit_full(std::span<const float> blocks, unsigned threads) {
  // In the coordinates of the DCT, where leaving out the mean is leaving out the first.
  const Basis dct = Basis::dct();
  constexpr unsigned n = kBlockVoxels - 1;
  std::vector<float> coefficients(blocks.begin(), blocks.end());
  dct.forward(coefficients, threads);
  std::vector<double> c =
      sum_blocks(coefficients, threads, n * n, [](const float* block, double* sums) {
        for (unsigned i = 0; i < n; ++i) {
          const double v = static_cast<double>(block[i + 1]);
          for (unsigned j = 0; j < n; ++j) sums[i * n + j] += v * static_cast<double>(block[j + 1]);
        }
      });
  regularise(c, n);
  std::vector<double> q = eigenvectors(std::move(c), n);
  fix_signs(q, n);
  std::array<std::uint8_t, kBlockVoxels> place{};
  std::array<unsigned, kZones> taken{1};  // DC lies in zone 0
  for (unsigned k = 0; k < n; ++k) {
    std::array<double, kZones> energy{};
    for (unsigned i = 0; i < n; ++i) energy[(i + 1) / 8] += q[k * n + i] * q[k * n + i];
    unsigned best = kZones;
    for (unsigned t = 0; t < kZones; ++t) {
      if (taken[t] < 8 && (best == kZones || energy[t] > energy[best])) best = t;
    }
    place[k] = static_cast<std::uint8_t>(8 * best + taken[best]++);
  }
  std::vector<std::int16_t> stored(n * kBlockVoxels);
  for (unsigned k = 0; k < n; ++k) {
    for (unsigned i = 0; i < kBlockVoxels; ++i) {
      double value = 0;
      for (unsigned j = 0; j < n; ++j)
        value += q[k * n + j] * static_cast<double>(dct.fixed(j + 1, i)) * 0x1p-24;
      stored[(place[k] - 1) * kBlockVoxels + i] = to_stored(value);
    }
  }
  return stored;
}

}  // namespace

std::array<std::uint8_t, kBlockVoxels> partition_order() {
  std::array<std::uint8_t, kBlockVoxels> place{};
  std::array<unsigned, kZones> taken{};
  for (unsigned o = 0; o < kBlockVoxels; ++o) {
    const unsigned zone = zone_of(o);
    place[o] = static_cast<std::uint8_t>(8 * zone + taken[zone]++);
  }
  return place;
}

std::size_t Basis::stored_values(TransformKind kind) {
  switch (kind) {
    case TransformKind::kDct:
      return 0;
    case TransformKind::kKltSeparable:
      return 48;
    case TransformKind::kKltFull:
      return (kBlockVoxels - 1) * kBlockVoxels;
  }
  return 0;
}

Basis::Basis(TransformKind kind, std::span<const std::int16_t> stored)
    : kind_(kind), stored_(stored.begin(), stored.end()), fixed_(kBlockVoxels * kBlockVoxels) {
  if (kind == TransformKind::kKltFull) {
    for (unsigned i = 0; i < kBlockVoxels; ++i) fixed_[i] = 1 << (kFractionBits - 3);
    for (std::size_t i = 0; i < stored_.size(); ++i)
      fixed_[kBlockVoxels + i] = stored_[i] * (1 << (kFractionBits - 14));
    return;
  }
  std::array<std::array<std::int64_t, 16>, 3> axis{};
  const Matrix4 t = dct_matrix();
  for (unsigned a = 0; a < 3; ++a) {
    for (unsigned i = 0; i < 16; ++i)
      axis[a][i] = kind == TransformKind::kDct ? to_stored(t[i / 4][i % 4]) : stored_[a * 16 + i];
  }
  const auto place = partition_order();
  for (unsigned o = 0; o < kBlockVoxels; ++o) {
    for (unsigned i = 0; i < kBlockVoxels; ++i) {
      const std::int64_t product = axis[0][(o & 3) * 4 + (i & 3)] *
                                   axis[1][(o >> 2 & 3) * 4 + (i >> 2 & 3)] *
                                   axis[2][(o >> 4) * 4 + (i >> 4)];
      fixed_[place[o] * kBlockVoxels + i] =
          static_cast<std::int32_t>((product + (std::int64_t{1} << 17)) >> 18);  // 2^42 -> 2^24
    }
  }
}

void Basis::forward(std::span<float> blocks, unsigned threads) const {
  std::vector<float> columns(kBlockVoxels *
                             kBlockVoxels);  // voxel-major: all coefficients of one voxel together
  for (unsigned i = 0; i < kBlockVoxels; ++i) {
    for (unsigned k = 0; k < kBlockVoxels; ++k) columns[i * kBlockVoxels + k] = value(k, i);
  }
  constexpr unsigned kRow = kBlockVoxels / kLanes;
  const std::uint64_t count = blocks.size() / kBlockVoxels;
  volumes::parallel_for(threads, (count + kChunk - 1) / kChunk, [&](unsigned, std::uint64_t c) {
    for (std::uint64_t b = c * kChunk; b < std::min(count, (c + 1) * kChunk); ++b) {
      float* block = blocks.data() + b * kBlockVoxels;
      double sum = 0;
      for (unsigned i = 0; i < kBlockVoxels; ++i) sum += static_cast<double>(block[i]);
      const double mean = sum / kBlockVoxels;
      Lanes out[kRow] = {};
      for (unsigned i = 0; i < kBlockVoxels; ++i) {
        const float s = static_cast<float>(static_cast<double>(block[i]) - mean);
        for (unsigned r = 0; r < kRow; ++r) {
          Lanes column;
          load(column, &columns[i * kBlockVoxels + r * kLanes]);
          out[r] += s * column;
        }
      }
      std::memcpy(block, out, sizeof out);
      block[0] = static_cast<float>(8 * mean);
    }
  });
}

std::array<float, kBlockVoxels> Basis::inverse(std::span<const float> coefficients) const {
  std::array<float, kBlockVoxels> voxels{};
  for (unsigned k = 0; k < kBlockVoxels; ++k) {
    for (unsigned i = 0; i < kBlockVoxels; ++i) voxels[i] += coefficients[k] * value(k, i);
  }
  return voxels;
}

Basis Basis::fit(TransformKind kind, std::span<const float> blocks, unsigned threads) {
  switch (kind) {
    case TransformKind::kKltSeparable:
      return {kind, fit_separable(blocks, threads)};
    case TransformKind::kKltFull:
      return {kind, fit_full(blocks, threads)};
    case TransformKind::kDct:
      break;
  }
  return dct();
}

std::vector<double> eigenvectors(std::vector<double> a, unsigned n) {
  std::vector<double> v(n * n, 0.0);
  for (unsigned i = 0; i < n; ++i) v[i * n + i] = 1;
  for (unsigned sweep = 0; sweep < 60; ++sweep) {
    double off = 0, diagonal = 0;
    for (unsigned i = 0; i < n; ++i) {
      diagonal += a[i * n + i] * a[i * n + i];
      for (unsigned j = 0; j < i; ++j) off += a[i * n + j] * a[i * n + j];
    }
    if (off <= 1e-30 * diagonal) break;
    for (unsigned p = 0; p + 1 < n; ++p) {
      for (unsigned q = p + 1; q < n; ++q) {
        if (a[p * n + q] == 0) continue;
        const double theta = (a[q * n + q] - a[p * n + p]) / (2 * a[p * n + q]);
        const double t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (unsigned k = 0; k < n; ++k) {
          const double kp = a[k * n + p], kq = a[k * n + q];
          a[k * n + p] = c * kp - s * kq;
          a[k * n + q] = s * kp + c * kq;
        }
        for (unsigned k = 0; k < n; ++k) {
          const double pk = a[p * n + k], qk = a[q * n + k];
          a[p * n + k] = c * pk - s * qk;
          a[q * n + k] = s * pk + c * qk;
          const double vp = v[p * n + k], vq = v[q * n + k];
          v[p * n + k] = c * vp - s * vq;
          v[q * n + k] = s * vp + c * vq;
        }
      }
    }
  }
  std::vector<unsigned> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order,
                           [&](unsigned i, unsigned j) { return a[i * n + i] > a[j * n + j]; });
  std::vector<double> rows;
  rows.reserve(n * n);
  for (const unsigned i : order)
    rows.insert(rows.end(), v.begin() + i * n, v.begin() + (i + 1) * n);
  return rows;
}

std::array<double, kZones> zone_energies(const float* coefficients) {
  std::array<double, kZones> energies{};
  for (unsigned k = 1; k < kBlockVoxels; ++k)
    energies[k / 8] += static_cast<double>(coefficients[k]) * static_cast<double>(coefficients[k]);
  return energies;
}

unsigned classify(const std::array<double, kZones>& energies, double tau_squared) {
  const auto lost = [&](unsigned c) {
    double sum = 0;
    for (unsigned t = 0; t < kZones; ++t) {
      if ((kBlockClasses[c].keeps >> t & 1) == 0) sum += energies[t];
    }
    return sum / kBlockVoxels;
  };
  const auto best_of = [&](unsigned first) {
    unsigned best = first;
    for (unsigned c = first + 1; c < first + 3; ++c) {
      if (lost(c) < lost(best)) best = c;
    }
    return best;
  };
  for (const unsigned c : {0u, 1u, best_of(2), 5u, best_of(6)}) {
    if (lost(c) <= tau_squared) return c;
  }
  return kClasses - 1;
}

}  // namespace cvr::codecs::tvq
