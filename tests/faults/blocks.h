// SPDX-License-Identifier: Apache-2.0
/* The addresses of blocks of memory that were allocated and not yet freed: a
 * hash table that allocates nothing itself, as malloc() fills it. A removed
 * entry stays in it as REMOVED. */
#ifndef GP_TESTS_BLOCKS_H
#define GP_TESTS_BLOCKS_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

enum { BLOCKS = 1 << 16 };
static atomic_long block_count;
static const void *block_table[BLOCKS];
static const char REMOVED[1];
static pthread_mutex_t blocks_lock = PTHREAD_MUTEX_INITIALIZER;

static size_t slot_of(const void *p)
{
    return (size_t) ((uintptr_t) p / 16 * 0x9e3779b97f4a7c15u >> 48) % BLOCKS;
}

static void *add_block(void *p)
{
    if (!p)
        return NULL;
    size_t i = slot_of(p);
    pthread_mutex_lock(&blocks_lock);
    if (++block_count == BLOCKS / 2)
        abort();
    while (block_table[i] && block_table[i] != REMOVED)
        i = (i + 1) % BLOCKS;
    block_table[i] = p;
    pthread_mutex_unlock(&blocks_lock);
    return p;
}

/* Returns whether `p` was in the table. */
static bool remove_block(const void *p)
{
    if (!p || !atomic_load(&block_count))
        return false;
    size_t i = slot_of(p);
    pthread_mutex_lock(&blocks_lock);
    int tried_slots = 0;
    while (block_table[i] && block_table[i] != p && tried_slots++ < BLOCKS)
        i = (i + 1) % BLOCKS;
    const bool found = block_table[i] == p;
    if (found) {
        block_table[i] = REMOVED;
        block_count--;
    }
    pthread_mutex_unlock(&blocks_lock);
    return found;
}

static long count_blocks(void)
{
    return atomic_load(&block_count);
}

#endif
