// Before all other code: a product and a sum stay two roundings. Fused into one, as compilers like to do where the
// processor can, they give other last bits, and nothing here would be the same on two platforms.
#pragma once

#if defined(__FAST_MATH__)
#error "-ffast-math reorders arithmetic: results would differ from those of every other build"
#endif

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#endif
