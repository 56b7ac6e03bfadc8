// Independent standard normal numbers from a pure function of (seed, draw).
#pragma once

#include "attitude/random.hpp"

namespace adcs {

/// Three of them, with the mean 0 and the standard deviation 1 (Box and Muller 1958).
inline Vec3<double> gaussian(Random& random) {
    Vec3<double> x;
    for (int i = 0; i < 3; ++i) {
        const double radius = sqrt(-2.0 * log(1.0 - random.uniform()));
        x[i] = radius * cos(6.2831853071795865 * random.uniform());
    }
    return x;
}

}  // namespace adcs
