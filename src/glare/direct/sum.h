/* What both forms of the direct sum are made of. */
#ifndef GP_GLARE_DIRECT_SUM_H
#define GP_GLARE_DIRECT_SUM_H

#include "core/cpu.h"

#include <stdint.h>

enum {
    GP_DIRECT_LANES = 8,
    GP_DIRECT_GROUP = 32, // sources summed before the sum is put aside
};

typedef float gp_vec __attribute__((vector_size(4 * GP_DIRECT_LANES)));
typedef float gp_loose __attribute__((vector_size(4 * GP_DIRECT_LANES),
                                      aligned(4), may_alias));

/* Fused multiply-add where the CPU has it: half the instructions of the loops
 * that all direct work spends its time in. Such functions inline none but
 * macros. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) &&        \
    !defined(GP_SANITIZED)
#define GP_FUSED                                                              \
    __attribute__((target_clones("fma", "default"),                           \
                   optimize("fp-contract=fast")))
#else
#define GP_FUSED
#endif

/* Adds a group's sum to the total; `lost` keeps what rounding loses (Kahan
 * 1965). */
#define GP_ADD_KEPT(total, lost, group)                                       \
    do {                                                                      \
        const gp_vec more_ = (group) - (lost);                                \
        const gp_vec next_ = (total) + more_;                                 \
        (lost) = (next_ - (total)) - more_;                                   \
        (total) = next_;                                                      \
    } while (0)

/* First index in [lo, hi) whose column is >= x. */
static inline uint32_t gp_first_from(const int32_t *col, uint32_t lo,
                                     uint32_t hi, int x)
{
    while (lo < hi) {
        const uint32_t mid = lo + (hi - lo) / 2;
        if (col[mid] < x)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo;
}

#endif
