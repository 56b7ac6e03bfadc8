// What only GCC and Clang understand; other compilers do without.
#pragma once

#if defined(__GNUC__)
#define ADCS_PRINTF_LIKE(FORMAT, FIRST) __attribute__((format(printf, FORMAT, FIRST)))
#define ADCS_FLATTEN __attribute__((flatten))
#else
#define ADCS_PRINTF_LIKE(FORMAT, FIRST)
#define ADCS_FLATTEN
#endif
