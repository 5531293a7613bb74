// SPDX-License-Identifier: Apache-2.0
#include "core/memory.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

// -- large blocks -------------------------------------------------------------

/* The C library returns a large block to the system when it is freed; the
 * system then clears pages again for the next one, with a page fault for each
 * 4 KiB: a fifth of the CPU time of one frame of 1920x1080, and a sixth of a
 * sequence of 3840x2160. Here blocks are huge pages, or parts of one, and one
 * that is freed waits for the next of about its size. When those in use and
 * those that wait would be a page and an eighth more than ever were in use, the
 * largest that wait go back to the system.
 *
 * The list of blocks is not in their pages: to write there would clear a huge
 * page on the thread that allocates, where the threads that fill a block share
 * this. */

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

static atomic_int keepers;     // of gp_keep_memory()
static atomic_bool has_blocks; // some may be the arena's

static bool has_arena(void)
{
    return ARENA && atomic_load_explicit(&keepers, memory_order_relaxed) > 0;
}

enum {
    ARENA_LEAST = 128 << 10, // bytes of a block of the arena
    PAGE = 64 << 10,      // no system has larger ones of its own
    HUGE_PAGE = 2 << 20,
    BLOCKS = 1024,
    SLACK = 8, // bytes that wait, over the peak in use: 1 of so many
    FIT = 2,   // a block that waits is taken for one smaller by 1 of so many
};

struct block {
    char *at;
    size_t bytes;
    bool free;
};

static struct {
    pthread_mutex_t lock;
    struct block block[BLOCKS];
    int blocks;
    size_t used, most, waiting; // bytes; in use at most so far
} arena = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* Returns the smallest free block for that many bytes, or NULL. */
static struct block *find_free(size_t bytes)
{
    const size_t most = bytes < HUGE_PAGE ? HUGE_PAGE : bytes + bytes / FIT;
    struct block *best = NULL;
    for (struct block *b = arena.block; b < arena.block + arena.blocks; b++) {
        if (b->free && b->bytes >= bytes && b->bytes <= most &&
            (!best || b->bytes < best->bytes))
            best = b;
    }
    return best;
}

/* Maps a free block of huge pages, or returns NULL. */
static struct block *map_block(size_t bytes)
{
    char *const all = mmap(NULL, bytes + HUGE_PAGE, PROT_READ | PROT_WRITE,
                           MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (all == MAP_FAILED)
        return NULL;
    const size_t before = -(uintptr_t) all % HUGE_PAGE;
    if (before)
        munmap(all, before);
    munmap(all + before + bytes, HUGE_PAGE - before);
#ifdef MADV_HUGEPAGE
    madvise(all + before, bytes, MADV_HUGEPAGE);
#endif
    struct block *const b = &arena.block[arena.blocks++];
    *b = (struct block) {all + before, bytes, true};
    arena.waiting += bytes;
    return b;
}

/* Returns free blocks to the system, the largest first, down to the limit. */
static void return_pages(void)
{
    while (arena.used + arena.waiting >
           arena.most + arena.most / SLACK + (has_arena() ? HUGE_PAGE : 0)) {
        struct block *large = NULL;
        for (struct block *b = arena.block; b < arena.block + arena.blocks; b++) {
            if (b->free && (!large || b->bytes > large->bytes))
                large = b;
        }
        if (!large)
            return;
        munmap(large->at, large->bytes);
        arena.waiting -= large->bytes;
        *large = arena.block[--arena.blocks];
    }
}

/* Takes a block at a page, not cleared; NULL when there is no memory. */
static void *take_block(size_t bytes)
{
    const bool part = bytes < HUGE_PAGE / 2;
    const size_t page = part ? PAGE : HUGE_PAGE;
    const size_t whole = (bytes + page - 1) / page * page;
    void *at = NULL;
    pthread_mutex_lock(&arena.lock);
    struct block *b = find_free(whole);
    if (!b && arena.blocks < BLOCKS - 1)
        b = map_block(part ? HUGE_PAGE : whole);
    if (b && part && b->bytes > whole && arena.blocks < BLOCKS) {
        arena.block[arena.blocks++] =
            (struct block) {b->at + whole, b->bytes - whole, true};
        b->bytes = whole;
    }
    if (b) {
        b->free = false;
        arena.waiting -= b->bytes;
        at = b->at;
        arena.used += b->bytes;
        if (arena.used > arena.most)
            arena.most = arena.used;
        return_pages();
    }
    pthread_mutex_unlock(&arena.lock);
    return at;
}

/* Gives a block back; false where it is none of take_block(). */
static bool give_block(void *block)
{
    bool found = false;
    if (!block || (uintptr_t) block % PAGE)
        return false;
    pthread_mutex_lock(&arena.lock);
    for (int i = 0; i < arena.blocks && !found; i++) {
        struct block *const b = &arena.block[i];
        found = b->at == block;
        if (found) {
            b->free = true;
            arena.used -= b->bytes;
            arena.waiting += b->bytes;
        }
    }
    if (!has_arena())
        return_pages();
    pthread_mutex_unlock(&arena.lock);
    return found;
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
        block = take_block(bytes);
    if (!block && posix_memalign(&block, GP_ALIGN, bytes) != 0)
        return no_memory(log, what, bytes);
    memcpy(out, &block, sizeof block);
    return GP_OK;
}

void gp_free(void *p)
{
    if (!atomic_load_explicit(&has_blocks, memory_order_relaxed) ||
        !give_block(p))
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

void gp_keep_memory(bool keeps)
{
    pthread_mutex_lock(&arena.lock);
    atomic_fetch_add(&keepers, keeps ? 1 : -1);
    if (has_arena()) {
        atomic_store(&has_blocks, true);
    } else {
        arena.most = 0;
        return_pages();
    }
    pthread_mutex_unlock(&arena.lock);
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
