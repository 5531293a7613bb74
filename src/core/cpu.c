#include "core/cpu.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__) && defined(__GNUC__)
#include <cpuid.h>
#endif

bool gp_cpu_has_avx2(void)
{
#if defined(__x86_64__) && defined(__GNUC__)
    // by cpuid: clang 14's __builtin_cpu_supports() has no "f16c". And once: in
    // a virtual machine each cpuid traps, which takes microseconds
    enum { UNKNOWN, MISSING, THERE };
    static atomic_int f16c;
    const char *cpu = getenv("GLAREPP_CPU");
    if (cpu && strcmp(cpu, "base") == 0)
        return false;
    if (atomic_load(&f16c) == UNKNOWN) {
        unsigned a, b, c, d;
        const bool there = __get_cpuid(1, &a, &b, &c, &d) && (c & bit_F16C);
        atomic_store(&f16c, there ? THERE : MISSING);
    }
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
           atomic_load(&f16c) == THERE;
#else
    return false;
#endif
}
