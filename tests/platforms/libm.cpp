// A digest of what the C library of this platform computes: it is not the same everywhere.
#include <cmath>
#include <cstdio>

#include "attitude/random.hpp"

int main() {
    adcs::Random random = adcs::Stream("libm").draw(1, 1);
    std::uint64_t hash = 0xcbf29ce484222325U;
    for (int i = 0; i < 100000; ++i) {
        const double x = 20.0 * random.uniform() - 10.0;
        for (const double y : {std::sin(x), std::cos(x), std::exp(x), std::log(x * x)}) {
            hash = (hash ^ adcs::math::bits_of(y)) * 0x100000001b3U;
        }
    }
    std::printf("%016llx\n", static_cast<unsigned long long>(hash));
    return 0;
}
