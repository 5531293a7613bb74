#include "core/cpu.h"

#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__) && defined(__GNUC__)
#include <cpuid.h>

/* Asked of the CPU itself: clang 14 knows no "f16c". */
static bool has_f16c(void)
{
    unsigned a, b, c, d;
    return __get_cpuid(1, &a, &b, &c, &d) && (c & bit_F16C);
}
#endif

bool gp_cpu_has_avx2(void)
{
#if defined(__x86_64__) && defined(__GNUC__)
    const char *cpu = getenv("GLAREPP_CPU");
    if (cpu && strcmp(cpu, "base") == 0)
        return false;
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
           has_f16c();
#else
    return false;
#endif
}
