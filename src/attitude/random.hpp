// Random numbers as a pure function of (stream, seed, draw): nothing to save, the same on every platform.
#pragma once

#include <cstdint>

#include "attitude/eigen.hpp"

namespace adcs {

/// What SplitMix64 (Steele, Lea, Flood 2014) gives in the state z: one to one, and a bit of z that changes turns over
/// about half the bits of the result.
constexpr std::uint64_t mixed(std::uint64_t z) {
    z += 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
}

/// The SplitMix64 generator.
class Random {
public:
    explicit Random(std::uint64_t state) : state_(state) {}

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
    std::uint64_t next() {
        const std::uint64_t value = mixed(state_);
        state_ += 0x9e3779b97f4a7c15U;
        return value;
    }

    std::uint64_t state_;
};

/// What draws: a component, by its name, or one of the several things that it draws, a channel. Equal seeds in two
/// components, or in two channels, have nothing to do with each other.
///
/// A component that draws has a member `stream` with its own name; the build refuses another's. The name is not told by
/// whoever makes an FMU of the component, so that the header draws the same numbers wherever it is used.
class Stream {
public:
    constexpr explicit Stream(const char* component) : key_(after(0xcbf29ce484222325U, component)) {}

    constexpr Stream operator[](const char* channel) const { return Stream(after(after(key_, "."), channel)); }
    constexpr Stream operator[](int channel) const { return Stream(after(after(key_, "."), channel)); }

    /// The numbers of the k-th draw. Seed and draw are mixed before they are added: else one seed could give the numbers
    /// of another some draws later.
    Random draw(std::int64_t seed, std::int64_t k) const {
        const std::uint64_t sequence = mixed(key_ + mixed(static_cast<std::uint64_t>(seed)));
        return Random(mixed(sequence + mixed(static_cast<std::uint64_t>(k))));
    }

    constexpr bool is_of(const char* component) const { return key_ == Stream(component).key_; }

private:
    constexpr explicit Stream(std::uint64_t key) : key_(key) {}

    /// The FNV-1a hash (Fowler, Noll, Vo), of the bytes of a text that goes on.
    static constexpr std::uint64_t after(std::uint64_t hash, const char* text) {
        for (; *text != '\0'; ++text) hash = after(hash, *text);
        return hash;
    }
    static constexpr std::uint64_t after(std::uint64_t hash, int number) {
        if (number > 9) hash = after(hash, number / 10);
        return after(hash, static_cast<char>('0' + number % 10));
    }
    static constexpr std::uint64_t after(std::uint64_t hash, char letter) {
        return (hash ^ static_cast<unsigned char>(letter)) * 0x100000001b3U;
    }

    std::uint64_t key_;
};

}  // namespace adcs
