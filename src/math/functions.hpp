// The functions that laws may call, by their bare names: for double those of math, for scalars that carry something
// along those of fmi/lifted.hpp. They use nothing but operations that IEEE 754 rounds exactly, so they give the same
// bits everywhere, which the functions of the platform's C library do not. sin, cos, exp and log are off by less than
// 0.9 units in the last place (tests/math), for every double.
#pragma once

#include "math/logarithm.hpp"
#include "math/trigonometric.hpp"

namespace adcs {

using math::abs;
using math::cos;
using math::exp;
using math::log;
using math::sin;
using math::sincos;
using math::SinCos;
using math::sqrt;

}  // namespace adcs
