// SPDX-License-Identifier: Apache-2.0
/* Run-time choice of wider vectors.
 *
 * GP_CLONES before a function makes the compiler build it twice, for the
 * baseline and for AVX2, and choose at load time. a * b + c stays unfused in both
 * (-ffp-contract=off), so both give the same bits. (Not "arch=haswell", which is
 * chosen on that model only, not on later ones.) */
#ifndef GP_CORE_CPU_H
#define GP_CORE_CPU_H

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define GP_SANITIZED 1 // ifuncs are resolved before their run time starts
#endif

#include <stdbool.h>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) &&        \
    !defined(GP_SANITIZED) && !defined(GP_NO_CLONES)
#define GP_CLONES __attribute__((target_clones("avx2", "default")))
#define GP_CLONES_WIDE \
    __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#define GP_WIDE __attribute__((target("arch=x86-64-v4")))
/* Returns true where functions of GP_WIDE can run. */
static inline bool gp_cpu_wide(void)
{
    return __builtin_cpu_supports("avx512f") &&
           __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512cd");
}
#else
#define GP_CLONES
#define GP_CLONES_WIDE
#define GP_WIDE
static inline bool gp_cpu_wide(void)
{
    return false;
}
#endif

#endif
