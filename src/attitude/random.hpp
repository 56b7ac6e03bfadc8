// Random numbers as a pure function of (seed, draw): nothing to save, the same on every platform.
#pragma once

#include <cstdint>

#include "attitude/eigen.hpp"

namespace adcs {

/// The SplitMix64 generator (Steele, Lea, Flood 2014), started from a hash of seed and draw.
class Random {
public:
    Random(std::uint64_t seed, std::uint64_t draw) : state_(mix(mix(seed) + draw)) {}

    /// Uniform on [0, 1), 53 bits.
    double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

    /// Uniform on the unit sphere (Marsaglia 1972); square root only, so equal on every platform.
    Vec3<double> direction() {
        for (;;) {
            const double x = 2.0 * uniform() - 1.0;
            const double y = 2.0 * uniform() - 1.0;
            const double s = x * x + y * y;
            if (s < 1.0) {
                const double r = 2.0 * sqrt(1.0 - s);
                return {x * r, y * r, 1.0 - 2.0 * s};
            }
        }
    }

private:
    static std::uint64_t mix(std::uint64_t z) {
        z += 0x9e3779b97f4a7c15U;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
        return z ^ (z >> 31);
    }
    std::uint64_t next() {
        const std::uint64_t value = mix(state_);
        state_ += 0x9e3779b97f4a7c15U;
        return value;
    }

    std::uint64_t state_;
};

}  // namespace adcs
