#include "core/core_priv.h"
#include "core/memory.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Sanitizers must see what is freed: all blocks are the C library's then. */
#ifndef __has_feature
#define __has_feature(x) 0 // clang's; gcc has names for them
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) ||          \
    __has_feature(address_sanitizer)
enum { ARENA = false };
#else
enum { ARENA = true };
#endif

enum { ARENA_LEAST = 128 << 10 }; // bytes of a block of the arena

static atomic_bool arena_on; // never off again

static bool has_arena(void)
{
    return atomic_load_explicit(&arena_on, memory_order_relaxed);
}

// -- allocation --------------------------------------------------------------

static gp_status no_memory(const struct gp_log *log, const char *what,
                           size_t bytes)
{
    return gp_fail_bare(log, GP_ERR_BUG, "%s: out of memory (%zu byte%s); use "
                        "a smaller frame or a machine with more memory", what,
                        bytes, bytes == 1 ? "" : "s");
}

gp_status gp_alloc(const struct gp_log *log, const char *what, size_t count,
                   size_t size, void *out)
{
    void *block = NULL;
    memcpy(out, &block, sizeof block); // of whatever type it points to
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) ||
        bytes > SIZE_MAX / 2)
        return gp_fail_bare(log, GP_ERR_BUG, "%s: size overflows (%zu x %zu "
            "bytes); use a smaller frame", what, count, size);
    bytes += !bytes; // never none: NULL is only for failure
    if (has_arena() && bytes >= ARENA_LEAST)
        block = gp_arena_take(bytes);
    if (!block && posix_memalign(&block, GP_ALIGN, bytes) != 0)
        return no_memory(log, what, bytes);
    memcpy(out, &block, sizeof block);
    return GP_OK;
}

void gp_free(void *p)
{
    if (!has_arena() || !gp_arena_give(p))
        free(p);
}

gp_status gp_resize(const struct gp_log *log, const char *what, size_t bytes,
                    void **block)
{
    void *const moved = realloc(*block, bytes);
    if (!moved)
        return no_memory(log, what, bytes);
    *block = moved;
    return GP_OK;
}

gp_status gp_alloc_zero(const struct gp_log *log, const char *what,
                        size_t count, size_t size, void *out)
{
    void *block;
    const gp_status st = gp_alloc(log, what, count, size, &block);
    if (!st)
        memset(block, 0, count * size);
    memcpy(out, &block, sizeof block);
    return st;
}

void gp_keep_memory(void)
{
    atomic_store_explicit(&arena_on, ARENA, memory_order_relaxed);
}

unsigned long gp_serial_next(void)
{
    static atomic_ulong last;
    return atomic_fetch_add_explicit(&last, 1, memory_order_relaxed) + 1;
}

char *gp_strdup(const char *s)
{
    size_t n = strlen(s) + 1;
    char *copy = malloc(n);
    if (copy)
        memcpy(copy, s, n);
    return copy;
}
