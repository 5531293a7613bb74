/* Memory for planes and other large blocks, from stage to stage and from frame
 * to frame.
 *
 * The C library returns a large block to the system when it is freed; the
 * system then clears pages again for the next one, with a page fault for each
 * 4 KiB: a fifth of the CPU time of one frame of 1920x1080, and a sixth of a
 * sequence of 3840x2160. Here blocks are pages, huge ones where they are large,
 * and one that is freed waits for the next of about its size. When those in use
 * and those that wait would be an eighth more than ever were in use, the largest
 * that wait go back to the system.
 *
 * The list of blocks is not in their pages: to write there would clear a huge
 * page on the thread that allocates, where the threads that fill a block share
 * this. */
#include "core/core_priv.h"
#include "core/memory.h"

#include <pthread.h>
#include <stdint.h>
#include <sys/mman.h>

enum {
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

static size_t page_of(size_t bytes)
{
    return bytes < HUGE_PAGE / 2 ? PAGE : HUGE_PAGE;
}

/* Returns the smallest free block for that many bytes, or NULL. */
static struct block *find_free(size_t bytes)
{
    struct block *best = NULL;
    for (struct block *b = arena.block; b < arena.block + arena.blocks; b++) {
        if (b->free && b->bytes >= bytes && b->bytes <= bytes + bytes / FIT &&
            (!best || b->bytes < best->bytes))
            best = b;
    }
    return best;
}

/* Maps a block that begins with a page of its kind; NULL when memory or the list
 * is full. */
static struct block *map_block(size_t bytes)
{
    const size_t page = page_of(bytes);
    if (arena.blocks == BLOCKS)
        return NULL;
    char *const all = mmap(NULL, bytes + page, PROT_READ | PROT_WRITE,
                           MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (all == MAP_FAILED)
        return NULL;
    const size_t before = -(uintptr_t) all % page;
    if (before)
        munmap(all, before);
    munmap(all + before + bytes, page - before);
#ifdef MADV_HUGEPAGE
    if (page == HUGE_PAGE)
        madvise(all + before, bytes, MADV_HUGEPAGE);
#endif
    struct block *const b = &arena.block[arena.blocks++];
    *b = (struct block) {.at = all + before, .bytes = bytes};
    return b;
}

/* Returns free blocks to the system, the largest first, until the arena holds no
 * more than its limit. */
static void return_pages(void)
{
    while (arena.used + arena.waiting > arena.most + arena.most / SLACK) {
        struct block *large = NULL;
        for (struct block *b = arena.block; b < arena.block + arena.blocks; b++) {
            if (b->free && (!large || b->bytes > large->bytes))
                large = b;
        }
        munmap(large->at, large->bytes);
        arena.waiting -= large->bytes;
        *large = arena.block[--arena.blocks];
    }
}

void *gp_arena_take(size_t bytes)
{
    const size_t page = page_of(bytes), whole = (bytes + page - 1) / page * page;
    void *at = NULL;
    pthread_mutex_lock(&arena.lock);
    struct block *b = find_free(whole);
    if (b) {
        b->free = false;
        arena.waiting -= b->bytes;
    } else {
        b = map_block(whole);
    }
    if (b) {
        at = b->at;
        arena.used += b->bytes;
        if (arena.used > arena.most)
            arena.most = arena.used;
        return_pages();
    }
    pthread_mutex_unlock(&arena.lock);
    return at;
}

bool gp_arena_give(void *block)
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
    pthread_mutex_unlock(&arena.lock);
    return found;
}
