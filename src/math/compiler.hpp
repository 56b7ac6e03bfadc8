// Before all other code: what compilers must be told. A product and a sum stay two roundings. Fused into one, as
// compilers like to do where the processor can, they give other last bits, and nothing here would be the same on two
// platforms.
#pragma once

#if defined(__FAST_MATH__)
#error "-ffast-math reorders arithmetic: results would differ from those of every other build"
#endif

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off", "no-tree-slp-vectorize")  // which fuses in spite of the former (GCC 12)
#endif

#if defined(__GNUC__)
#define ADCS_RARELY_CALLED __attribute__((noinline, cold))
#else
#define ADCS_RARELY_CALLED
#endif
