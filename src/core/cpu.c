#include "core/cpu.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__) && defined(__GNUC__)
#include <cpuid.h>

enum { UNKNOWN, MISSING, THERE };

/* Asked of the CPU itself: clang 14 knows no "f16c". And only once: a virtual
 * machine leaves to its host for each answer, which takes microseconds. */
static bool has_f16c(void)
{
    static atomic_int found;
    if (atomic_load(&found) == UNKNOWN) {
        unsigned a, b, c, d;
        const bool there = __get_cpuid(1, &a, &b, &c, &d) && (c & bit_F16C);
        atomic_store(&found, there ? THERE : MISSING);
    }
    return atomic_load(&found) == THERE;
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
