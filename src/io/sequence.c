#include "io/sequence.h"

#include "core/memory.h"

#include <dirent.h>
#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Where the last component of a path starts. */
static size_t name_at(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t) (slash - path) + 1 : 0;
}

// -- patterns ----------------------------------------------------------------

/* Length of a %d or %0Nd at `s`, 0 when there is none; *digits is N or 1. */
static size_t percent_token(const char *s, int *digits)
{
    if (s[0] != '%')
        return 0;
    size_t n = 1;
    int width = 0;
    if (s[n] == '0') {
        for (n++; is_digit(s[n]); n++) {
            if (width < 1000) // enough to be refused, never overflows
                width = 10 * width + (s[n] - '0');
        }
        if (width == 0)
            return 0;
    }
    *digits = width ? width : 1;
    return s[n] == 'd' ? n + 1 : 0;
}

/* Length of a run of `sign` at `s`. */
static size_t run_token(const char *s, char sign, int *digits)
{
    size_t n = 0;
    while (s[n] == sign)
        n++;
    *digits = n < 1000 ? (int) n : 1000;
    return n;
}

static size_t token(const char *s, char sign, int *digits)
{
    return sign == '%' ? percent_token(s, digits) : run_token(s, sign, digits);
}

gp_status gp_pattern_find(const struct gp_log *log, const char *path,
                          struct gp_pattern *out)
{
    static const char signs[] = "%#@";
    struct gp_pattern p = {.path = path};
    for (const char *sign = signs; *sign && !p.len; sign++) {
        for (size_t i = name_at(path); path[i];) {
            int digits;
            size_t n = token(path + i, *sign, &digits);
            if (n && p.len)
                return gp_fail(log, GP_ERR_USAGE,
                               "%s: two places for the frame number (%.*s and "
                               "%.*s); leave one", path, (int) p.len,
                               path + p.at, (int) n, path + i);
            if (n) {
                p.at = i;
                p.len = n;
                p.digits = digits;
            }
            i += n ? n : 1;
        }
    }
    if (p.digits > GP_FRAME_DIGITS)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: frame numbers this long do not exist (%d digits); "
                       "use at most %d", path, p.digits, GP_FRAME_DIGITS);
    *out = p;
    return GP_OK;
}

char *gp_pattern_name(const struct gp_pattern *p, int frame)
{
    if (!p->len)
        return gp_strdup(p->path);
    char number[24];
    int n = snprintf(number, sizeof number, "%0*d", p->digits, frame);
    size_t tail = strlen(p->path + p->at + p->len) + 1;
    char *name = malloc(p->at + (size_t) n + tail);
    if (!name)
        return NULL;
    memcpy(name, p->path, p->at);
    memcpy(name + p->at, number, (size_t) n);
    memcpy(name + p->at + n, p->path + p->at + p->len, tail);
    return name;
}

// -- lists of frames ---------------------------------------------------------

void gp_frames_free(struct gp_frames *f)
{
    free(f->number);
    *f = (struct gp_frames) {0};
}

/* Appends one number; `room` is the capacity. False when memory is full. */
static bool append(struct gp_frames *f, int *room, int number)
{
    if (f->n == *room) {
        int more = *room ? 2 * *room : 64;
        int *grown = realloc(f->number, (size_t) more * sizeof *grown);
        if (!grown)
            return false;
        f->number = grown;
        *room = more;
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

static int by_number_then_place(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    int order = ascending(&x->number, &y->number);
    return order ? order : ascending(&x->at, &y->at);
}

static int by_place(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    return ascending(&x->at, &y->at);
}

/* Keeps the first of equal numbers, in the order they came. */
static gp_status drop_repeats(const struct gp_log *log, struct gp_frames *f)
{
    void *block;
    gp_status st = gp_alloc(log, "frame list", (size_t) f->n,
                            sizeof(struct place), &block);
    if (st)
        return st;
    struct place *place = block;
    for (int i = 0; i < f->n; i++)
        place[i] = (struct place) {f->number[i], i};
    qsort(place, (size_t) f->n, sizeof *place, by_number_then_place);
    int kept = 0;
    for (int i = 0; i < f->n; i++) {
        if (i == 0 || place[i].number != place[kept - 1].number)
            place[kept++] = place[i];
    }
    qsort(place, (size_t) kept, sizeof *place, by_place);
    for (int i = 0; i < kept; i++)
        f->number[i] = place[i].number;
    f->n = kept;
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
                              struct range r, struct gp_frames *f, int *room)
{
    int way = r.to < r.from ? -1 : 1;
    int64_t frames = ((int64_t) r.to - r.from) * way / r.step + 1;
    if (frames > GP_FRAME_LIST_MAX - f->n)
        return gp_fail(log, GP_ERR_USAGE,
                       "--frames: too many frames (over %d in %s); make "
                       "them in several runs", GP_FRAME_LIST_MAX, text);
    for (int64_t i = 0; i < frames; i++) {
        if (!append(f, room, (int) (r.from + way * i * r.step)))
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
    int room = 0;
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
        GP_TRY(append_range(log, text, r, &f, &room));
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

// -- what is on disk ---------------------------------------------------------

/* The number of `name` when it is a frame of the pattern whose component
 * starts at `start`; -1 else. */
static int frame_of(const struct gp_pattern *p, size_t start, const char *name)
{
    size_t head = p->at - start;
    const char *tail = p->path + p->at + p->len;
    if (strncmp(name, p->path + start, head) != 0 || !is_digit(name[head]))
        return -1;
    const char *s = name + head;
    int number;
    if (!read_number(&s, &number) || strcmp(s, tail) != 0)
        return -1;
    char again[24]; // only the padding that would be written is a match
    int n = snprintf(again, sizeof again, "%0*d", p->digits, number);
    bool same = s - (name + head) == n &&
                strncmp(again, name + head, (size_t) n) == 0;
    return same ? number : -1;
}

static gp_status scan(const struct gp_log *log, const struct gp_pattern *p,
                      DIR *folder, struct gp_frames *f)
{
    int room = 0;
    size_t start = name_at(p->path);
    for (const struct dirent *e; (e = readdir(folder));) {
        int number = frame_of(p, start, e->d_name);
        if (number < 0)
            continue;
        if (f->n == GP_FRAME_LIST_MAX)
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: too many frames (over %d); choose some with "
                           "--frames", p->path, f->n);
        if (!append(f, &room, number))
            return gp_fail(log, GP_ERR_BUG, "%s: out of memory; close other "
                           "programs", p->path);
    }
    if (f->n == 0)
        return gp_fail(log, GP_ERR_IO,
                       "%s: no frame on disk (found no file of that name); "
                       "check the folder and the number of digits", p->path);
    qsort(f->number, (size_t) f->n, sizeof *f->number, ascending);
    return GP_OK;
}

gp_status gp_frames_on_disk(const struct gp_log *log,
                            const struct gp_pattern *p, struct gp_frames *out)
{
    size_t start = name_at(p->path);
    char *path = start ? strndup(p->path, start) : gp_strdup(".");
    if (!path)
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory", p->path);
    DIR *folder = opendir(path);
    int reason = errno;
    free(path);
    if (!folder)
        return gp_fail(log, GP_ERR_IO,
                       "%s: cannot list the folder (%s); check the path",
                       p->path, strerror(reason));
    struct gp_frames f = {0};
    gp_status st = scan(log, p, folder, &f);
    closedir(folder);
    if (st)
        gp_frames_free(&f);
    else
        *out = f;
    return st;
}

bool gp_frame_number(const char *path, int *out)
{
    const char *name = path + name_at(path);
    const char *dot = strrchr(name, '.');
    // what follows the last dot is the ending, unless it is the number
    size_t end = dot && dot != name && !is_digit(dot[1])
                     ? (size_t) (dot - name) : strlen(name);
    while (end > 0 && !is_digit(name[end - 1]))
        end--;
    size_t at = end;
    while (at > 0 && is_digit(name[at - 1]))
        at--;
    if (at == end || end - at > GP_FRAME_DIGITS)
        return false;
    *out = 0;
    for (size_t i = at; i < end; i++)
        *out = 10 * *out + (name[i] - '0');
    return true;
}
