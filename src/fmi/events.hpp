// What happens at an event: how events() is told of it.
#pragma once

namespace adcs {

/// A time that does not come.
inline constexpr double never = 1e300;

/// Why events() is called. It may be called without any of these: what it sets has to depend on how things are.
struct Events {
    static constexpr int capacity = 32;

    unsigned crossed = 0;  ///< event functions, as bits, that have become positive, or are no longer
    bool first = false;    ///< at the start of the run

    /// Whether the i-th event function, in the order of declaration, has changed its sign.
    bool has_crossed(int i) const { return (crossed >> i & 1U) != 0; }
};

}  // namespace adcs
