// Applies one function to the doubles on standard input: functions NAME < arguments > values. Those of several
// arguments take them one after the other.
#include <cstdio>
#include <cstring>

#include "fmi/lifted.hpp"

namespace adcs {  // where the laws are, so that the same names find the same functions
namespace {

struct Function {
    const char* name;
    int arguments;
    double (*apply)(const double*);
};

#define OF_ONE(NAME)                                                                         \
    {#NAME, 1, [](const double* x) { return NAME(x[0]); }},                                  \
        {"lifted " #NAME, 1, [](const double* x) { return NAME(Dual(x[0], 1.0)).value; }}, { \
        "slope of " #NAME, 1, [](const double* x) { return NAME(Dual(x[0], 1.0)).tangent; }  \
    }
#define OF_TWO(NAME)                                                                                        \
    {#NAME, 2, [](const double* x) { return NAME(x[0], x[1]); }},                                           \
        {"lifted " #NAME, 2, [](const double* x) { return NAME(Dual(x[0], 1.0), Dual(x[1], 1.0)).value; }}, \
        {"slope of " #NAME, 2, [](const double* x) { return NAME(Dual(x[0], 1.0), x[1]).tangent; }}, {      \
        "second slope of " #NAME, 2, [](const double* x) { return NAME(x[0], Dual(x[1], 1.0)).tangent; }    \
    }

const Function functions[] = {
    OF_ONE(sin),
    OF_ONE(cos),
    OF_ONE(tan),
    OF_ONE(asin),
    OF_ONE(acos),
    OF_ONE(atan),
    OF_ONE(sinh),
    OF_ONE(cosh),
    OF_ONE(tanh),
    OF_ONE(exp),
    OF_ONE(log),
    OF_ONE(sqrt),
    OF_ONE(cbrt),
    OF_ONE(floor),
    OF_ONE(ceil),
    OF_ONE(abs),
    {"sincos.sin", 1, [](const double* x) { return sincos(x[0]).sin; }},
    {"sincos.cos", 1, [](const double* x) { return sincos(x[0]).cos; }},
    {"slope of sincos.sin", 1, [](const double* x) { return sincos(Dual(x[0], 1.0)).sin.tangent; }},
    {"slope of sincos.cos", 1, [](const double* x) { return sincos(Dual(x[0], 1.0)).cos.tangent; }},
    OF_TWO(atan2),
    OF_TWO(pow),
    OF_TWO(hypot),
    OF_TWO(fmod),
    OF_TWO(min),
    OF_TWO(max),
    OF_TWO(copysign),
    {"clamp", 3, [](const double* x) { return clamp(x[0], x[1], x[2]); }},
    {"lifted clamp", 3, [](const double* x) { return clamp(Dual(x[0], 1.0), Dual(x[1], 1.0), x[2]).value; }},
    {"slope of clamp", 3, [](const double* x) { return clamp(Dual(x[0], 1.0), x[1], x[2]).tangent; }},
};

}  // namespace
}  // namespace adcs

int main(int argc, char** argv) {
    for (const adcs::Function& f : adcs::functions) {
        if (argc != 2 || std::strcmp(f.name, argv[1]) != 0) continue;
        double block[3 * 4096], values[4096];
        const std::size_t n = static_cast<std::size_t>(f.arguments);
        for (std::size_t got = 1; got > 0;) {
            got = std::fread(block, n * sizeof(double), 4096, stdin);
            for (std::size_t i = 0; i < got; ++i) values[i] = f.apply(block + n * i);
            std::fwrite(values, sizeof(double), got, stdout);
        }
        return 0;
    }
    return 2;
}
