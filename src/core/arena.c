/* Memory for planes and other large blocks, from stage to stage and from frame
 * to frame.
 *
 * The C library returns a large block to the system when it is freed; the
 * system then clears pages again for the next one, with a page fault for each
 * 4 KiB: a fifth of the CPU time of one frame of 1920x1080, and a sixth of a
 * sequence of 3840x2160. In the library's heap, frames in flight would leave
 * holes, and a thousand frames grow it by a fifth. Here huge pages are mapped
 * as a run comes to need them, and stay. What a stage frees is joined with its
 * free neighbours, and the next stage's blocks, of whatever size, go there: a
 * frame of 3840x2160 maps 0.3 to 0.9 % more than its stages hold at once.
 *
 * Each block and each free span has a `struct span` in a table, not in its
 * pages: to write there would clear a huge page on the thread that allocates, 1
 * to 5 % of a frame's CPU time, where the threads that fill a block share this. */
#include "core/core_priv.h"
#include "core/memory.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/mman.h>

enum {
    HUGE_PAGE = 2 << 20,
    GROWS = 256 << 10,   // a smaller block takes what is free, no new pages
    LEAST = 32 << 10,    // bytes of a free span that is worth an entry
    SPANS = 4096,
    RANGES = 64,
    SLACK = 8,           // free pages that wait, over the peak that was in use:
                         // 1 of so many
};

struct span {
    uintptr_t at;
    size_t bytes;
    struct span *before, *after; // by addresses; `after`: of unused entries
    struct span *next, *last;    // of the list of free ones
    bool free;
    bool touched;                // free, and the system has pages for it
};

/* Pages without a gap. New ones come below, where the system maps the next. */
struct range {
    atomic_uintptr_t begin, end;
};

static struct {
    pthread_mutex_t lock;
    struct span span[SPANS];
    int spans;            // entries that were ever used
    struct span *unused;  // of them, those that are not now
    struct span *lowest;  // by address
    struct span *free;
    struct range range[RANGES];
    atomic_int ranges;
    size_t used, most;  // bytes of blocks, and at most so far
    size_t waiting;     // bytes of free spans that are touched
    size_t mapped;      // bytes of ranges
} arena = {.lock = PTHREAD_MUTEX_INITIALIZER};

// -- spans -------------------------------------------------------------------

/* Adds a span to the table, before `after` or as the highest; NULL when the
 * table is full. */
static struct span *make_span(uintptr_t at, size_t bytes, struct span *before,
                              struct span *after)
{
    struct span *s = arena.unused;
    if (s)
        arena.unused = s->after;
    else if (arena.spans < SPANS)
        s = &arena.span[arena.spans++];
    else
        return NULL;
    *s = (struct span) {
        .at = at, .bytes = bytes, .before = before, .after = after,
    };
    *(before ? &before->after : &arena.lowest) = s;
    if (after)
        after->before = s;
    return s;
}

/* Removes a span that is in no list from the table. */
static void drop_span(struct span *s)
{
    *(s->before ? &s->before->after : &arena.lowest) = s->after;
    if (s->after)
        s->after->before = s->before;
    s->after = arena.unused;
    arena.unused = s;
}

/* Returns the span that begins there, or NULL. */
static struct span *span_at(uintptr_t at)
{
    struct span *s = arena.lowest;
    while (s && s->at != at)
        s = s->after;
    return s;
}

static void list_span(struct span *s)
{
    s->free = true;
    s->last = NULL;
    s->next = arena.free;
    if (s->next)
        s->next->last = s;
    arena.free = s;
    arena.waiting += s->touched ? s->bytes : 0;
}

static void unlist_span(struct span *s)
{
    s->free = false;
    if (s->last)
        s->last->next = s->next;
    else
        arena.free = s->next;
    if (s->next)
        s->next->last = s->last;
    arena.waiting -= s->touched ? s->bytes : 0;
}

/* Adds a span that is in no list to the free ones, with its neighbours. */
static void free_span(struct span *s)
{
    struct span *const after = s->after, *const before = s->before;
    if (after && after->free && s->at + s->bytes == after->at) {
        unlist_span(after);
        s->touched = s->touched || after->touched;
        s->bytes += after->bytes;
        drop_span(after);
    }
    if (before && before->free && before->at + before->bytes == s->at) {
        unlist_span(before);
        before->touched = before->touched || s->touched;
        before->bytes += s->bytes;
        drop_span(s);
        s = before;
    }
    list_span(s);
}

/* Returns the smallest free span of that many bytes, or NULL. */
static struct span *find_span(size_t bytes)
{
    struct span *best = NULL;
    for (struct span *s = arena.free; s; s = s->next) {
        if (s->bytes >= bytes && (!best || s->bytes < best->bytes))
            best = s;
    }
    return best;
}

/* Takes `bytes` from the end of a free span, or all of it. */
static struct span *cut_span(struct span *s, size_t bytes)
{
    unlist_span(s);
    const size_t rest = s->bytes - bytes;
    struct span *const end =
        rest < LEAST ? NULL
                     : make_span(s->at + rest, bytes, s, s->after);
    if (!end)
        return s;
    s->bytes = rest;
    list_span(s);
    return end;
}

// -- pages -------------------------------------------------------------------

static uintptr_t page_up(uintptr_t at)
{
    return (at + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
}

/* Returns the pages of free spans to the system, the largest first, until the
 * arena holds no more than its limit. */
static void return_pages(void)
{
    while (arena.used + arena.waiting > arena.most + arena.most / SLACK) {
        struct span *large = NULL;
        for (struct span *s = arena.free; s; s = s->next) {
            if (s->touched && (!large || s->bytes > large->bytes))
                large = s;
        }
        if (!large)
            return;
        const uintptr_t begin = page_up(large->at);
        const uintptr_t end =
            (large->at + large->bytes) / HUGE_PAGE * HUGE_PAGE;
        if (end > begin)
            madvise((void *) begin, end - begin, MADV_DONTNEED);
        large->touched = false;
        arena.waiting -= large->bytes;
    }
}

/* Maps whole huge pages, below `end` where that is free; 0 when memory is
 * full. */
static uintptr_t map_pages(size_t bytes, uintptr_t end)
{
    const int use = PROT_READ | PROT_WRITE, kind = MAP_PRIVATE | MAP_ANONYMOUS;
    void *const hint = end > bytes ? (void *) (end - bytes) : NULL;
    void *at = mmap(hint, bytes, use, kind, -1, 0);
    if (at != MAP_FAILED && (uintptr_t) at % HUGE_PAGE) {
        munmap(at, bytes);
        at = mmap(NULL, bytes + HUGE_PAGE, use, kind, -1, 0);
        if (at != MAP_FAILED) { // cut what is before and after whole pages
            const uintptr_t first = page_up((uintptr_t) at);
            const size_t before = first - (uintptr_t) at;
            if (before)
                munmap(at, before);
            munmap((void *) (first + bytes), HUGE_PAGE - before);
            at = (void *) first;
        }
    }
    if (at == MAP_FAILED)
        return 0;
#ifdef MADV_HUGEPAGE
    madvise(at, bytes, MADV_HUGEPAGE);
#endif
    arena.mapped += bytes;
    return (uintptr_t) at;
}

static void unmap_pages(uintptr_t at, size_t bytes)
{
    munmap((void *) at, bytes);
    arena.mapped -= bytes;
}

/* Returns a free span of that many bytes, of pages that are new as far as free
 * ones do not reach; NULL when memory or the list of ranges is full. */
static struct span *add_pages(size_t bytes)
{
    const int n = atomic_load(&arena.ranges);
    struct range *const last = n ? &arena.range[n - 1] : NULL;
    const uintptr_t below = last ? atomic_load(&last->begin) : 0;
    struct span *const first = below ? span_at(below) : NULL;
    const size_t there = first && first->free ? first->bytes : 0;
    size_t more = page_up(bytes - there);
    uintptr_t at = map_pages(more, below);
    if (at && at + more != below) { // a range of its own
        const size_t whole = page_up(bytes);
        if (whole > more) {
            unmap_pages(at, more);
            at = map_pages(whole, 0);
            more = whole;
        }
    }
    if (!at)
        return NULL;
    const bool joins = at + more == below;
    struct span *after = arena.lowest, *before = NULL;
    for (; after && after->at < at; after = after->after)
        before = after;
    struct span *const s =
        joins || n < RANGES ? make_span(at, more, before, after) : NULL;
    if (!s) {
        unmap_pages(at, more);
        return NULL;
    }
    if (joins) {
        atomic_store(&last->begin, at);
    } else {
        atomic_store(&arena.range[n].begin, at);
        atomic_store(&arena.range[n].end, at + more);
        atomic_store(&arena.ranges, n + 1);
    }
    free_span(s);
    return find_span(bytes);
}

// -- blocks ------------------------------------------------------------------

void *gp_arena_take(size_t bytes)
{
    const size_t whole = (bytes + GP_ALIGN - 1) / GP_ALIGN * GP_ALIGN;
    pthread_mutex_lock(&arena.lock);
    struct span *s = find_span(whole);
    if (!s && bytes >= GROWS)
        s = add_pages(whole);
    if (s) {
        s = cut_span(s, whole);
        arena.used += s->bytes;
        if (arena.used > arena.most)
            arena.most = arena.used;
        return_pages();
    }
    pthread_mutex_unlock(&arena.lock);
    return s ? (void *) s->at : NULL;
}

bool gp_arena_has(const void *block)
{
    const uintptr_t at = (uintptr_t) block;
    for (int i = 0; i < atomic_load(&arena.ranges); i++) {
        if (at >= atomic_load(&arena.range[i].begin) &&
            at < atomic_load(&arena.range[i].end))
            return true;
    }
    return false;
}

void gp_arena_give(void *block)
{
    pthread_mutex_lock(&arena.lock);
    struct span *const s = span_at((uintptr_t) block);
    arena.used -= s->bytes;
    s->touched = true;
    free_span(s);
    pthread_mutex_unlock(&arena.lock);
}

size_t gp_arena_mapped(void)
{
    pthread_mutex_lock(&arena.lock);
    const size_t bytes = arena.mapped;
    pthread_mutex_unlock(&arena.lock);
    return bytes;
}
