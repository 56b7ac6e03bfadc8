/// # Every function
///
/// What laws may call, each with variables, with constants, and with elements of vectors: so that all of it compiles
/// for every scalar, and rounds alike on every machine.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct EveryFunction {
    static constexpr auto kind = "controller";
    static constexpr auto summary = "every function that laws may call";
    static constexpr auto reference = "";

    T x = 0.4, y = 0.7;
    Vec3<T> v{0.1, -0.2, 0.3}, w{0.5, 0.6, -0.7};
    Eigen::Matrix<T, 16, 1> of_one = Eigen::Matrix<T, 16, 1>::Zero();
    Eigen::Matrix<T, 7, 1> of_two = Eigen::Matrix<T, 7, 1>::Zero();
    Eigen::Matrix<T, 13, 1> mixed = Eigen::Matrix<T, 13, 1>::Zero();
    Eigen::Matrix<T, 5, 1> chosen = Eigen::Matrix<T, 5, 1>::Zero();
    Vec3<T> vector{0.0, 0.0, 0.0};
    Mat3<T> matrix = Mat3<T>::Zero();

    template <class V>
    void declare(V& visitor) {
        visitor.input("x", x, unit::one, "first number");
        visitor.input("y", y, unit::one, "second number");
        visitor.input("v", v, unit::one, "first vector");
        visitor.input("w", w, unit::one, "second vector");
        visitor.output("of_one", of_one, unit::one, "functions of one number");
        visitor.output("of_two", of_two, unit::one, "functions of two numbers");
        visitor.output("mixed", mixed, unit::one, "functions of numbers, constants and elements");
        visitor.output("chosen", chosen, unit::one, "what a condition chooses");
        visitor.output("vector", vector, unit::one, "vector that a condition chooses");
        visitor.output("matrix", matrix, unit::one, "matrix that a condition chooses");
    }

    void outputs() {
        const T sine = clamp(x, -1.0, 1.0);
        of_one << sin(x), cos(x), tan(x), asin(sine), acos(sine), atan(x), sinh(x), cosh(x), tanh(x), exp(x),
            log(hypot(x, 0.5)), sqrt(abs(x)), cbrt(x), floor(3.0 * x), ceil(3.0 * x), abs(x);
        of_two << atan2(y, x), pow(abs(x), y), hypot(x, y), fmod(3.0 * x, y), min(x, y), max(x, y), copysign(x, y);
        mixed << max(0.0, x), min(x, 0), pow(x, 2), pow(2, x), clamp(x, -1, y), clamp(0.5, x, 0.9), atan2(x, 1),
            atan2(1.0, x), hypot(x, 1), fmod(x, 0.25), copysign(1, x), max(v(0), w(1)), pow((v + w)(0), 3);
        chosen << select(x > y, v(0), w(0)), select(x < y && y < 1.0, 1, -1), select(!(x > 0.0), x, 0.0),
            select(true, x, y), select(x > 0.5 || v.norm() > 1.0, 2.0 * x, y);
        vector = select(x > y, v + w, w);
        matrix = select(x < y, v * w.transpose(), Mat3<T>::Identity());
    }
};

}  // namespace adcs
