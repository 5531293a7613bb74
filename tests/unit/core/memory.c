// SPDX-License-Identifier: Apache-2.0
/* core/memory: sizes that overflow, alignment, and large blocks
 * that stay from frame to frame without adding to what was in use. */
#include "unit.h"
#include "core/image.h"
#include "core/memory.h"
#include "fail.h"
#include "kept_log.h"

#include <pthread.h>
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

enum { MIB = 1 << 20 };

static void *alloc_block(size_t bytes)
{
    void *p;
    assert_ok(gp_alloc(NULL, "test", bytes, 1, &p));
    assert_int_equal((uintptr_t) p % GP_ALIGN, 0);
    memset(p, 0x5a, bytes);
    return p;
}

static void small_and_none(void **state)
{
    void *p, *none;
    assert_ok(gp_alloc(NULL, "t", 0, 8, &none));
    assert_non_null(none);
    assert_ok(gp_alloc_zero(NULL, "t", 1000, 3, &p));
    for (int i = 0; i < 3000; i++)
        assert_int_equal(((uint8_t *) p)[i], 0);
    gp_free(none);
    GP_FREE(p);
    assert_null(p);
    GP_FREE(p);
}

static void zero_of_a_used_block(void **state)
{
    void *p;
    gp_free(alloc_block(40 * MIB));
    assert_ok(gp_alloc_zero(NULL, "t", 40 * MIB, 1, &p));
    for (size_t i = 0; i < 40 * MIB; i += 4093)
        assert_int_equal(((uint8_t *) p)[i], 0);
    gp_free(p);
}

static void resized(void **state)
{
    static const size_t size[] = {
        1, 100, 65536, 3 * MIB, 64 * MIB, 65 * MIB, 5 * MIB, 300 << 10, 10,
    };
    void *p = NULL, *before;
    size_t held = 0;
    for (size_t i = 0; i < COUNT(size); i++) {
        assert_ok(gp_resize(NULL, "t", size[i], &p));
        for (size_t k = 0; k < held && k < size[i]; k += 997)
            assert_int_equal(((uint8_t *) p)[k], 0x5a);
        held = size[i];
        memset(p, 0x5a, held);
    }
    before = p;
    assert_int_equal(gp_resize(NULL, "t", SIZE_MAX / 2, &p), GP_ERR_BUG);
    assert_ptr_equal(p, before);
    assert_int_equal(((uint8_t *) p)[9], 0x5a);
    gp_free(p);
}

/* Sanitizers are to see what is freed: no block is kept for them. */
static void need_kept_blocks(void)
{
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    skip_for("a sanitizer");
#endif
}

/* Pages that the process has, in bytes. */
static size_t resident(void)
{
    size_t pages = 0, held = 0;
    FILE *const f = fopen("/proc/self/statm", "r");
    assert_non_null(f);
    assert_int_equal(fscanf(f, "%zu %zu", &pages, &held), 2);
    fclose(f);
    return held * (size_t) sysconf(_SC_PAGESIZE);
}

/* Blocks that a large one does not fit into go back to the system before the
 * peak grows by more than an eighth. First of all tests, since the
 * peak is that of the process. */
static void pages_return(void **state)
{
    enum { BLOCKS = 6, EACH = 64 * MIB, LARGE = 150 * MIB };
    void *block[BLOCKS];
    need_kept_blocks();
    const size_t before = resident();
    for (int i = 0; i < BLOCKS; i++)
        block[i] = alloc_block(EACH);
    for (int i = 0; i < BLOCKS; i += 2)
        gp_free(block[i]);
    void *const large = alloc_block(LARGE);
    assert_true(resident() - before <= (size_t) BLOCKS * EACH / 8 * 9 +
                                       4 * MIB);
    for (int i = 1; i < BLOCKS; i += 2) {
        for (size_t k = 0; k < EACH; k += 4093)
            assert_int_equal(((uint8_t *) block[i])[k], 0x5a);
        gp_free(block[i]);
    }
    gp_free(large);
}

/* Small blocks are parts of one page: each keeps its bytes. */
static void parts_are_apart(void **state)
{
    enum { PARTS = 24 };
    uint8_t *part[PARTS];
    need_kept_blocks();
    for (int round = 0; round < 3; round++) {
        for (int i = 0; i < PARTS; i++) {
            const size_t bytes = (size_t) (130 + 37 * (i % 20)) << 10;
            if (round == 0 || i % (round + 1) == 0)
                part[i] = alloc_block(bytes);
            memset(part[i], i, bytes);
        }
        for (int i = 0; i < PARTS; i++) {
            for (size_t k = 0; k < (size_t) (130 + 37 * (i % 20)) << 10; k++)
                assert_int_equal(part[i][k], i);
            if (round == 2 || i % (round + 2) == 0)
                gp_free(part[i]);
        }
    }
}

/* Blocks that wait are each taken once, and go when nobody keeps them. */
static void blocks_are_apart(void **state)
{
    enum { BLOCKS = 4, EACH = 20 * MIB };
    uint8_t *block[BLOCKS];
    need_kept_blocks();
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < BLOCKS; i++) {
            block[i] = alloc_block(EACH);
            block[i][0] = (uint8_t) i;
        }
        for (int i = 0; i < BLOCKS; i++) {
            assert_int_equal(block[i][0], i);
            gp_free(block[i]);
        }
    }
    const size_t before = resident();
    gp_keep_memory(false);
    assert_true(before - resident() >= (size_t) BLOCKS * EACH);
    gp_free(alloc_block(EACH));
    gp_keep_memory(true);
}

static int by_place(const void *a, const void *b)
{
    const uintptr_t x = *(const uintptr_t *) a, y = *(const uintptr_t *) b;
    return (x > y) - (x < y);
}

/* More blocks than the list has room for, pages and parts of pages, from holes
 * too: none is another. They are not touched, so that they take no memory. */
static void the_list_of_blocks_is_full(void **state)
{
    enum { BLOCKS = 2000, PART = 200 << 10 };
    static void *block[BLOCKS];
    static uintptr_t place[BLOCKS];
    size_t n = 0;
    need_kept_blocks();
    for (int i = 0; i < BLOCKS; i++) {
        const size_t bytes = i < BLOCKS / 2 ? 2 * MIB : PART;
        assert_ok(gp_alloc(NULL, "test", bytes, 1, &block[i]));
        if (i < BLOCKS / 2 && i % 100 == 99)
            GP_FREE(block[i]); // a hole for parts
    }
    for (int i = 0; i < BLOCKS; i++) {
        if (block[i])
            place[n++] = (uintptr_t) block[i];
    }
    qsort(place, n, sizeof *place, by_place);
    for (size_t i = 1; i < n; i++)
        assert_true(place[i] - place[i - 1] >= PART);
    for (int i = 0; i < BLOCKS; i++)
        gp_free(block[i]);
}

static void *use_blocks(void *arg)
{
    for (int i = 0; i < 60; i++) {
        const size_t bytes = (size_t) (17 + (i + *(int *) arg) % 3) * MIB;
        uint8_t *p = alloc_block(bytes);
        p[0] = (uint8_t) i;
        p[bytes - 1] = (uint8_t) *(int *) arg;
        if (p[0] != (uint8_t) i || p[bytes - 1] != (uint8_t) *(int *) arg)
            return arg;
        gp_free(p);
    }
    return NULL;
}

static void threads_share(void **state)
{
    pthread_t id[4];
    int name[4] = {0, 1, 2, 3};
    for (int i = 0; i < 4; i++)
        assert_int_equal(pthread_create(&id[i], NULL, use_blocks, &name[i]), 0);
    for (int i = 0; i < 4; i++) {
        void *wrong;
        pthread_join(id[i], &wrong);
        assert_null(wrong);
    }
}

// -- refusals ------------------------------------------------------------------

static void sizes_are_checked(void **state)
{
    static const struct { size_t count, size; const char *text; } rows[] = {
        {SIZE_MAX, 2, "size overflows"},
        {SIZE_MAX, SIZE_MAX, "size overflows"},
        {SIZE_MAX, 1, "size overflows"},
        {SIZE_MAX / 4 + 1, 4, "size overflows"},
        {(size_t) 1 << 32, (size_t) 1 << 32, "size overflows"},
        {(size_t) 1 << 62, 1, "out of memory"},
        {0, 4, NULL}, {4, 0, NULL}, {1, 1, NULL}, {5 << 20, 1, NULL},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        for (int zero = 0; zero < 2; zero++) {
            void *p = &p;
            kept_clear();
            const gp_status st = (zero ? gp_alloc_zero : gp_alloc)(
                &kept_log, "it", rows[i].count, rows[i].size, &p);
            assert_int_equal(st, rows[i].text ? GP_ERR_BUG : GP_OK);
            assert_true((p != NULL) == !rows[i].text);
            assert_int_equal(kept_errors, rows[i].text ? 1 : 0);
            if (rows[i].text)
                assert_kept(rows[i].text);
            assert_int_equal((uintptr_t) p % GP_ALIGN, 0);
            GP_FREE(p);
            assert_null(p);
        }
    }
}

static void memory_is_full(void **state)
{
    const long blocks = fail_blocks();
    for (int n = 1; n <= 2; n++) {
        struct gp_planes p = {{NULL, NULL, NULL}};
        fail_at(FAIL_ALLOC, n);
        assert_int_equal(gp_planes_make(NULL, "planes", 100, &p),
                         n < 2 ? GP_ERR_BUG : GP_OK);
        fail_end();
        for (int c = 0; c < 3; c++)
            assert_true((p.c[c] != NULL) == (n == 2));
        gp_planes_free(&p);
        gp_planes_free(&p);
        assert_null(p.c[0]);
    }
    fail_at(FAIL_ALLOC, 1);
    assert_null(gp_strdup("a name"));
    fail_end();
    char *copy = gp_strdup("");
    assert_string_equal(copy, "");
    gp_free(copy);
    assert_int_equal(fail_blocks(), blocks);
}

static int keep_memory(void **state)
{
    gp_keep_memory(true);
    return 0;
}

SUITE_OF(memory, keep_memory, NULL, pages_return, blocks_are_apart,
         parts_are_apart, sizes_are_checked, memory_is_full, small_and_none,
         zero_of_a_used_block, resized, threads_share,
         the_list_of_blocks_is_full)
