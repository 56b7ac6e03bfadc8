// Nanoseconds per call of the elementary functions: of src/math and of the C library, in turn.
// For each function a line: name, ours and theirs one after the other, ours and theirs independent of each other.
#include <cmath>
#include <cstdio>
#include <ctime>

#include "attitude/random.hpp"

namespace {

constexpr int n = 1024, repetitions = 200;

double now() { return static_cast<double>(std::clock()) * (1e9 / CLOCKS_PER_SEC); }

/// Per call. In a chain each argument waits for the value before, which changes it by nothing that matters.
template <class F>
double time_of(F f, const double* x, bool chained) {
    double values[n], last = 0.0, sum = 0.0;
    const double wait = chained ? 1e-300 : 0.0, began = now();
    for (int r = 0; r < repetitions; ++r) {
        if (chained) {
            for (int i = 0; i < n; ++i) last = f(x[i] + wait * last);
            sum += last;
        } else {
            for (int i = 0; i < n; ++i) values[i] = f(x[i]);
            sum += values[r % n];
        }
    }
    const double time = now() - began;
    return sum == 0.1 ? 0.0 : time / (n * repetitions);  // sum: so that something depends on the calls
}

template <class Ours, class Theirs>
void compare(const char* name, double low, double high, Ours ours, Theirs theirs) {
    adcs::Random random = adcs::Stream("elementary").draw(1, 1);
    double x[n];
    for (double& element : x) element = low + (high - low) * random.uniform();
    std::printf("%s", name);
    for (const bool chained : {true, false}) {
        const double a = time_of(ours, x, chained), b = time_of(theirs, x, chained);
        std::printf(" %.4f %.4f", a, b);
    }
    std::printf("\n");
}

}  // namespace

int main() {
    namespace math = adcs::math;
    compare("sin", -10, 10, [](double x) { return math::sin(x); }, [](double x) { return std::sin(x); });
    compare("cos", -10, 10, [](double x) { return math::cos(x); }, [](double x) { return std::cos(x); });
    const auto both = [](double x) {
        const auto [s, c] = math::sincos(x);
        return s + c;
    };
    compare("sincos", -10, 10, both, [](double x) { return std::sin(x) + std::cos(x); });
    compare("exp", -10, 10, [](double x) { return math::exp(x); }, [](double x) { return std::exp(x); });
    compare("log", 0.1, 10, [](double x) { return math::log(x); }, [](double x) { return std::log(x); });
    return 0;
}
