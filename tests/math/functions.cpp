// Applies one function to the doubles on standard input: functions NAME < arguments > values.
#include <cstdio>
#include <cstring>

#include "fmi/lifted.hpp"

namespace adcs {  // where the laws are, so that the same names find the same functions
namespace {

struct Function {
    const char* name;
    double (*apply)(double);
};
const Function functions[] = {
    {"sin", [](double x) { return sin(x); }},
    {"cos", [](double x) { return cos(x); }},
    {"exp", [](double x) { return exp(x); }},
    {"log", [](double x) { return log(x); }},
    {"sincos.sin", [](double x) { return sincos(x).sin; }},
    {"sincos.cos", [](double x) { return sincos(x).cos; }},
    {"lifted sin", [](double x) { return sin(Dual(x, 1.0)).value; }},
    {"lifted cos", [](double x) { return cos(Dual(x, 1.0)).value; }},
    {"lifted exp", [](double x) { return exp(Dual(x, 1.0)).value; }},
    {"lifted log", [](double x) { return log(Dual(x, 1.0)).value; }},
    {"slope of sin", [](double x) { return sin(Dual(x, 1.0)).tangent; }},
    {"slope of cos", [](double x) { return cos(Dual(x, 1.0)).tangent; }},
    {"slope of exp", [](double x) { return exp(Dual(x, 1.0)).tangent; }},
    {"slope of log", [](double x) { return log(Dual(x, 1.0)).tangent; }},
    {"slope of sincos.sin", [](double x) { return sincos(Dual(x, 1.0)).sin.tangent; }},
    {"slope of sincos.cos", [](double x) { return sincos(Dual(x, 1.0)).cos.tangent; }},
};

}  // namespace
}  // namespace adcs

int main(int argc, char** argv) {
    for (const adcs::Function& f : adcs::functions) {
        if (argc != 2 || std::strcmp(f.name, argv[1]) != 0) continue;
        double block[4096];
        for (std::size_t n = 1; n > 0;) {
            n = std::fread(block, sizeof(double), 4096, stdin);
            for (std::size_t i = 0; i < n; ++i) block[i] = f.apply(block[i]);
            std::fwrite(block, sizeof(double), n, stdout);
        }
        return 0;
    }
    return 2;
}
