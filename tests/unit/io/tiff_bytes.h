/* Small TIFFs for tests, made byte by byte: one directory behind the pixels,
 * Intel's order, each field with the one value that fits into it. */
#ifndef TIFF_BYTES_H
#define TIFF_BYTES_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>

enum { TIFF_FIELDS = 16, TIFF_PIXELS = 8, TIFF_ROOM = 8192 };

/* Ends with tag 0. A value of short goes into two bytes, two of them into
 * four. */
struct tiff_field {
    int tag, type, count;
    uint32_t value;
};
#define TIFF_SHORT(tag, value) {tag, 3, 1, value}
#define TIFF_LONG(tag, value) {tag, 4, 1, value}

static size_t tiff_put(uint8_t *to, uint64_t v, int n)
{
    for (int i = 0; i < n; i++)
        to[i] = (uint8_t) (v >> 8 * i);
    return (size_t) n;
}

/* `pixels` of `size` bytes at TIFF_PIXELS; returns the bytes of it all. */
static size_t tiff_make(const struct tiff_field *field, const void *pixels,
                        size_t size, uint8_t to[TIFF_ROOM])
{
    int n = 0;
    while (field[n].tag)
        n++;
    assert_true(n <= TIFF_FIELDS && size < TIFF_ROOM - 256);
    size_t at = TIFF_PIXELS + (size + 1) / 2 * 2;
    memset(to, 0, TIFF_ROOM);
    memcpy(to, "II*\0", 4);
    tiff_put(to + 4, at, 4);
    memcpy(to + TIFF_PIXELS, pixels, size);
    at += tiff_put(to + at, (uint64_t) n, 2);
    for (int i = 0; i < n; i++) {
        at += tiff_put(to + at, (uint64_t) field[i].tag, 2);
        at += tiff_put(to + at, (uint64_t) field[i].type, 2);
        at += tiff_put(to + at, (uint64_t) field[i].count, 4);
        at += tiff_put(to + at, field[i].value, 4);
    }
    return at + tiff_put(to + at, 0, 4);
}

#endif
