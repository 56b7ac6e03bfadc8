// The functions that laws may call, by their bare names: for double those of math, for scalars that carry something
// along those of fmi/lifted.hpp. They use nothing but operations that IEEE 754 rounds exactly, so they give the same
// bits everywhere, which the functions of the platform's C library do not. Those that are no arithmetic are off by less
// than 0.9 units in the last place (tests/math), for every double.
#pragma once

#include "math/arcus.hpp"
#include "math/choice.hpp"
#include "math/hyperbolic.hpp"
#include "math/logarithm.hpp"
#include "math/power.hpp"
#include "math/rounding.hpp"
#include "math/trigonometric.hpp"

namespace adcs {

using math::abs;
using math::acos;
using math::asin;
using math::atan;
using math::atan2;
using math::cbrt;
using math::ceil;
using math::clamp;
using math::copysign;
using math::cos;
using math::cosh;
using math::exp;
using math::floor;
using math::fmod;
using math::hypot;
using math::log;
using math::max;
using math::min;
using math::pow;
using math::select;
using math::sin;
using math::sincos;
using math::SinCos;
using math::sinh;
using math::sqrt;
using math::tan;
using math::tanh;

}  // namespace adcs
