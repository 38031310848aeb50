#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace atropos::scenes {

/// A named stream of random numbers: the same seed and name give the same numbers on every machine, and a new
/// stream changes no other. Generator: xoshiro256++ (Blackman and Vigna 2019), seeded through splitmix64 from
/// FNV-1a of the name. The distributions are our own, because those of <random> differ between libraries.
class RandomStream {
  public:
    RandomStream(std::uint64_t seed, std::string_view name);

    std::uint64_t next();

    /// Uniform in [0, 1), 53 bits.
    double uniform();
    double uniform(double low, double high) { return low + (high - low) * uniform(); }

    /// Uniform in {0, ..., count - 1}, count >= 1, without modulo bias.
    std::uint64_t integer(std::uint64_t count);

    /// Standard normal (Box-Muller, one value a call).
    double normal();
    double normal(double mean, double sigma) { return mean + sigma * normal(); }

  private:
    std::array<std::uint64_t, 4> state_;
};

/// The seed of job `index` of an experiment: hash of both.
std::uint64_t derive_seed(std::uint64_t seed, std::uint64_t index);

}  // namespace atropos::scenes
