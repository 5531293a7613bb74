/* Lists of frames: the gp_frames_ part of sequence.h that needs no disk. */
#include "io/sequence.h"

#include "core/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

void gp_frames_free(struct gp_frames *f)
{
    free(f->number);
    *f = (struct gp_frames) {0};
}

bool gp_frames_add(struct gp_frames *f, int number)
{
    if (!(f->n & (f->n - 1))) { // doubles at powers of two
        int *grown = realloc(f->number, (size_t) (f->n ? 2 * f->n : 1) *
                                            sizeof *grown);
        if (!grown)
            return false;
        f->number = grown;
    }
    f->number[f->n++] = number;
    return true;
}

static int ascending(const void *a, const void *b)
{
    int x = *(const int *) a, y = *(const int *) b;
    return (x > y) - (x < y);
}

struct place {
    int number, at;
};

/* Sorts by number, byte by byte from the lowest; equal ones stay in order.
 * (Comparing took a second for the longest lists.) `spare` has as much room. */
static void sort_by_number(struct place *place, struct place *spare, int n)
{
    for (int shift = 0; shift < 32; shift += 8) { // an even number of times
        int start[257] = {0};
        struct place *const from = shift / 8 % 2 ? spare : place;
        struct place *const to = shift / 8 % 2 ? place : spare;
        for (int pass = 0; pass < 2; pass++) {
            for (int i = 0; i < n; i++) {
                // the sign's bit turned: negative numbers come first
                const uint32_t key = (uint32_t) from[i].number ^ 0x80000000u;
                const uint32_t byte = key >> shift & 0xff;
                if (pass)
                    to[start[byte]++] = from[i];
                else
                    start[byte + 1]++;
            }
            for (int k = 0; !pass && k < 256; k++)
                start[k + 1] += start[k];
        }
    }
}

/* Whether all numbers go one way, as those of a single range do. */
static bool goes_one_way(const struct gp_frames *f)
{
    const bool down = f->n > 1 && f->number[1] < f->number[0];
    for (int i = 1; i < f->n; i++) {
        if (down ? f->number[i] >= f->number[i - 1]
                 : f->number[i] <= f->number[i - 1])
            return false;
    }
    return true;
}

/* Keeps the first of equal numbers, in the order they came. */
static gp_status drop_repeats(const struct gp_log *log, struct gp_frames *f)
{
    void *block;
    if (goes_one_way(f)) // sorting a million frames takes a while
        return GP_OK;
    const int n = f->n;
    gp_status st = gp_alloc(log, "frame list", 2 * (size_t) n,
                            sizeof(struct place), &block);
    if (st)
        return st;
    struct place *const place = block;
    for (int i = 0; i < n; i++)
        place[i] = (struct place) {f->number[i], i};
    sort_by_number(place, place + n, n);
    bool *const again = (bool *) (place + n); // of the frame at that place
    for (int i = 0; i < n; i++)
        again[place[i].at] = i > 0 && place[i].number == place[i - 1].number;
    f->n = 0;
    for (int i = 0; i < n; i++) {
        if (!again[i])
            f->number[f->n++] = f->number[i];
    }
    gp_free(block);
    return GP_OK;
}

/* Reads [-]digits at *s and moves *s behind it. */
static bool read_number(const char **s, int *out)
{
    const char *c = *s;
    bool minus = *c == '-';
    c += minus;
    int value = 0, digits = 0;
    for (; is_digit(*c) && digits <= GP_FRAME_DIGITS; c++, digits++)
        value = digits < GP_FRAME_DIGITS ? 10 * value + (*c - '0') : value;
    if (digits == 0 || digits > GP_FRAME_DIGITS)
        return false;
    *out = minus ? -value : value;
    *s = c;
    return true;
}

struct range {
    int from, to, step;  // step >= 1, whatever the direction
};

/* Reads one item at *s, up to its comma or the end. */
static bool read_range(const char **s, struct range *r)
{
    r->step = 1;
    if (!read_number(s, &r->from))
        return false;
    r->to = r->from;
    if (**s == '-') {
        ++*s;
        if (!read_number(s, &r->to))
            return false;
        if (**s == 'x') {
            ++*s;
            if (!read_number(s, &r->step) || r->step < 1)
                return false;
        }
    }
    return **s == ',' || **s == '\0';
}

static gp_status append_range(const struct gp_log *log, const char *text,
                              struct range r, struct gp_frames *f)
{
    int way = r.to < r.from ? -1 : 1;
    int64_t frames = ((int64_t) r.to - r.from) * way / r.step + 1;
    if (frames > GP_FRAME_LIST_MAX - f->n)
        return gp_fail(log, GP_ERR_USAGE,
                       "--frames: too many frames (over %d in %s); make "
                       "them in several runs", GP_FRAME_LIST_MAX, text);
    for (int64_t i = 0; i < frames; i++) {
        if (!gp_frames_add(f, (int) (r.from + way * i * r.step)))
            return gp_fail(log, GP_ERR_BUG, "--frames: out of memory; close "
                           "other programs");
    }
    return GP_OK;
}

gp_status gp_frames_parse(const struct gp_log *log, const char *text,
                          struct gp_frames *out)
{
    gp_status st;
    struct gp_frames f = {0};
    for (const char *s = text;; s++) {
        struct range r;
        const char *item = s;
        if (!read_range(&s, &r)) {
            st = gp_fail(log, GP_ERR_USAGE,
                         "--frames: not a list of frames (found %.*s in %s); "
                         "write 7, 1-100, 1-100x2 or 3,4,10-20x2",
                         (int) strcspn(item, ","), item, text);
            goto out;
        }
        GP_TRY(append_range(log, text, r, &f));
        if (!*s)
            break;
    }
    GP_TRY(drop_repeats(log, &f));
    *out = f;
    return GP_OK;
out:
    gp_frames_free(&f);
    return st;
}

bool gp_frames_join(struct gp_frames *all, const struct gp_frames *more)
{
    for (int i = 0; i < more->n; i++) {
        if (!gp_frames_add(all, more->number[i]))
            return false;
    }
    if (all->n)
        qsort(all->number, (size_t) all->n, sizeof *all->number, ascending);
    int kept = 0;
    for (int i = 0; i < all->n; i++) {
        if (i == 0 || all->number[i] != all->number[kept - 1])
            all->number[kept++] = all->number[i];
    }
    all->n = kept;
    return true;
}
