#include "core/cpu.h"

#include <stdlib.h>
#include <string.h>

bool gp_cpu_has_avx2(void)
{
#if defined(__x86_64__) && defined(__GNUC__)
    const char *cpu = getenv("GLAREPP_CPU");
    if (cpu && strcmp(cpu, "base") == 0)
        return false;
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
           __builtin_cpu_supports("f16c");
#else
    return false;
#endif
}
