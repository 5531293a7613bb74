// SPDX-License-Identifier: Apache-2.0
#include "io/sequence.h"

#include "core/memory.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static int ascending(const void *a, const void *b)
{
    int x = *(const int *) a, y = *(const int *) b;
    return (x > y) - (x < y);
}

/* The start of a path's last component. */
static size_t name_at(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t) (slash - path) + 1 : 0;
}

// -- views -------------------------------------------------------------------

/* Length of a %V or %v at `s`, 0 when there is none. */
static size_t view_token(const char *s)
{
    return s[0] == '%' && (s[1] == 'V' || s[1] == 'v') ? 2 : 0;
}

/* Bytes of a view's first letter, which in UTF-8 may be several. */
static size_t letter_bytes(const char *view)
{
    size_t n = *view ? 1 : 0;
    while (n && ((unsigned char) view[n] & 0xc0) == 0x80)
        n++;
    return n;
}

// -- patterns ----------------------------------------------------------------

/* Length of a %d or %0Nd at `s`, 0 when there is none; *digits is N or 1. */
static size_t percent_token(const char *s, int *digits)
{
    if (s[0] != '%')
        return 0;
    const size_t n = 1 + strspn(s + 1, "0123456789");
    const long width = n > 1 ? strtol(s + 1, NULL, 10) : 1;
    if (s[n] != 'd' || (n > 1 && s[1] != '0') || width == 0)
        return 0;
    *digits = width < 1000 ? (int) width : 1000; // which is refused
    return n + 1;
}

gp_status gp_pattern_find(const struct gp_log *log, const char *path,
                          struct gp_pattern *out)
{
    static const char signs[] = "%#@";
    struct gp_pattern p = {.path = path};
    for (const char *sign = signs; *sign && !p.len; sign++) {
        for (size_t i = name_at(path); path[i];) {
            const char run[2] = {*sign, '\0'};
            int digits = 0;
            size_t n = *sign == '%' ? percent_token(path + i, &digits)
                                    : strspn(path + i, run);
            if (*sign != '%')
                digits = n < 1000 ? (int) n : 1000;
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
                       "%s: frame number too long (%d digits); use at most %d"
                       , path, p.digits, GP_FRAME_DIGITS);
    for (const char *c = path; *c; c++)
        p.views += view_token(c) > 0;
    *out = p;
    return GP_OK;
}

gp_status gp_pattern_of_input(const struct gp_log *log, const char *path,
                              struct gp_pattern *out)
{
    *out = (struct gp_pattern) {.path = path};
    return access(path, F_OK) == 0 ? GP_OK : gp_pattern_find(log, path, out);
}

enum { NO_FRAME = INT_MIN };

/* gp_pattern_name(), or (NO_FRAME) with the number's signs; it is at *at. */
static char *fill(const struct gp_pattern *p, int frame, const char *view,
                  size_t *at)
{
    char number[24];
    const int digits = snprintf(number, sizeof number, "%0*d", p->digits,
                                frame);
    const bool numbered = frame != NO_FRAME;
    const size_t views = view ? (size_t) p->views : 0;
    char *const name = malloc(strlen(p->path) + sizeof number +
                              (views ? views * strlen(view) : 0));
    char *to = name;
    for (const char *s = p->path; name && *s;) {
        const bool place = p->len && s == p->path + p->at;
        const size_t token = views && !place ? view_token(s) : 0;
        const size_t n = place    ? numbered ? (size_t) digits : p->len
                         : !token ? 1
                         : s[1] == 'V' ? strlen(view) : letter_bytes(view);
        if (place)
            *at = (size_t) (to - name);
        memcpy(to, place && numbered ? number : token ? view : s, n);
        to += n;
        s += place ? p->len : token ? token : 1;
    }
    if (name)
        *to = '\0';
    return name;
}

char *gp_pattern_name(const struct gp_pattern *p, int frame, const char *view)
{
    size_t at;
    return fill(p, frame, view, &at);
}

// -- lists of frames ----------------------------------------------------------

void gp_frames_free(struct gp_frames *f)
{
    free(f->number);
    *f = (struct gp_frames) {0};
}

static bool add_frame(struct gp_frames *f, int number)
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

static int by_key(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *) a, y = *(const int64_t *) b;
    return (x > y) - (x < y);
}

/* Keeps the first of equal numbers, in the order they came. */
static gp_status drop_repeats(const struct gp_log *log, struct gp_frames *f)
{
    const int64_t places = 1LL << 31; // longer than any list
    int64_t *key; // a number and its place
    const int n = f->n;
    const gp_status st = gp_alloc(log, "frame list", (size_t) n, sizeof *key,
                                  &key);
    if (st)
        return st;
    for (int i = 0; i < n; i++)
        key[i] = f->number[i] * places + i;
    qsort(key, (size_t) n, sizeof *key, by_key);
    for (int i = 1; i < n; i++) {
        if ((key[i] & -places) == (key[i - 1] & -places))
            f->number[key[i] & (places - 1)] = NO_FRAME;
    }
    f->n = 0;
    for (int i = 0; i < n; i++) {
        if (f->number[i] != NO_FRAME)
            f->number[f->n++] = f->number[i];
    }
    gp_free(key);
    return GP_OK;
}

/* Reads [-]digits at *s, with blanks around, and moves *s after them. */
static bool read_number(const char **s, int *out)
{
    static const char blanks[] = " \t";
    const char *c = *s + strspn(*s, blanks);
    bool minus = *c == '-';
    c += minus;
    int value = 0, digits = 0;
    for (; is_digit(*c) && digits <= GP_FRAME_DIGITS; c++, digits++)
        value = digits < GP_FRAME_DIGITS ? 10 * value + (*c - '0') : value;
    if (digits == 0 || digits > GP_FRAME_DIGITS)
        return false;
    *out = minus ? -value : value;
    *s = c + strspn(c, blanks);
    return true;
}

gp_status gp_frames_parse(const struct gp_log *log, const char *text,
                          struct gp_frames *out)
{
    gp_status st;
    struct gp_frames f = {0};
    for (const char *s = text;; s++) {
        const char *const item = s;
        int from = 0, to, step = 1;
        bool good = read_number(&s, &from);
        to = from;
        if (good && *s == '-') {
            s++;
            good = read_number(&s, &to);
            if (good && (*s == 'x' || *s == ':')) {
                const bool down = *s++ == ':' && to < from;
                good = read_number(&s, &step);
                step = down && step < 0 ? -step : step;
                good = good && step >= 1;
            }
        }
        if (!good || (*s != ',' && *s))
            GP_TRY(gp_fail(log, GP_ERR_USAGE,
                           "--frames: not a list of frames (found %.*s in "
                           "%s); write 7, 1-100, 1-100x2 or 3,4,10-20:2",
                           (int) strcspn(item, ","), item, text));
        const int way = to < from ? -1 : 1;
        const int64_t frames = ((int64_t) to - from) * way / step + 1;
        if (frames > GP_FRAME_LIST_MAX - f.n)
            GP_TRY(gp_fail(log, GP_ERR_USAGE,
                           "--frames: too many frames (over %d in %s); make "
                           "them in several runs", GP_FRAME_LIST_MAX, text));
        for (int64_t i = 0; i < frames; i++) {
            if (!add_frame(&f, (int) (from + way * i * step)))
                GP_TRY(gp_no_memory(log, "--frames"));
        }
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
        if (!add_frame(all, more->number[i]))
            return false;
    }
    if (all->n)
        qsort(all->number, (size_t) all->n, sizeof *all->number, ascending);
    return drop_repeats(NULL, all) == GP_OK;
}

// -- frames on disk ----------------------------------------------------------

gp_status gp_frames_on_disk(const struct gp_log *log,
    const struct gp_pattern *p, const char *view, struct gp_frames *out)
{
    gp_status st;
    struct gp_frames f = {0};
    size_t at = 0;
    char *const path = fill(p, NO_FRAME, view, &at);
    const size_t start = path ? name_at(path) : 0;
    char *const name = start ? strndup(path, start) : gp_strdup(".");
    DIR *const folder = path && name ? opendir(name) : NULL;
    const int reason = errno;
    if (!path || !name || (!folder && reason == ENOMEM))
        GP_TRY(gp_no_memory(log, p->path));
    if (!folder)
        GP_TRY(gp_fail(log, GP_ERR_IO,
                       "%s: cannot list the folder (%s); check the path",
                       path, strerror(reason)));
    const size_t head = at - start;
    const char *const tail = path + at + p->len;
    for (const struct dirent *e; (e = readdir(folder));) {
        int n = 0, number = 0;
        if (strncmp(e->d_name, path + start, head) != 0)
            continue;
        const char *const digits = e->d_name + head;
        for (; n < GP_FRAME_DIGITS && is_digit(digits[n]); n++)
            number = 10 * number + (digits[n] - '0');
        // only names with the pattern's own padding match
        if (n == 0 || strcmp(digits + n, tail) != 0 ||
            snprintf(NULL, 0, "%0*d", p->digits, number) != n)
            continue;
        if (f.n == GP_FRAME_LIST_MAX)
            GP_TRY(gp_fail(log, GP_ERR_USAGE,
                           "%s: too many frames (over %d); choose some with "
                           "--frames", path, f.n));
        if (!add_frame(&f, number))
            GP_TRY(gp_no_memory(log, path));
    }
    if (f.n == 0)
        GP_TRY(gp_fail(log, GP_ERR_IO,
                       "%s: no frame on disk (found no file of that name); "
                       "check the folder and the number of digits", path));
    qsort(f.number, (size_t) f.n, sizeof *f.number, ascending);
    *out = f;
    f = (struct gp_frames) {0};
    st = GP_OK;
out:
    if (folder)
        closedir(folder);
    free(name);
    free(path);
    gp_frames_free(&f);
    return st;
}

bool gp_frame_number(const char *path, int *out)
{
    const char *name = path + name_at(path);
    const char *dot = strrchr(name, '.');
    // the ending is after the last dot, unless that is the number
    size_t end = dot && dot != name && !is_digit(dot[1])
                     ? (size_t) (dot - name) : strlen(name);
    while (end > 0 && !is_digit(name[end - 1]))
        end--;
    size_t at = end;
    while (at > 0 && is_digit(name[at - 1]))
        at--;
    if (at == end || end - at > GP_FRAME_DIGITS)
        return false;
    *out = (int) strtol(name + at, NULL, 10);
    return true;
}

// -- lists of views -----------------------------------------------------------

void gp_views_free(struct gp_views *v)
{
    for (int i = 0; i < v->n; i++)
        gp_free(v->name[i]);
    *v = (struct gp_views) {0};
}

gp_status gp_views_parse(const struct gp_log *log, const char *text,
                         struct gp_views *out)
{
    gp_status st;
    struct gp_views v = {0};
    for (const char *at = text, *end; at; at = *end ? end + 1 : NULL) {
        end = at + strcspn(at, ",");
        if (v.n == GP_VIEWS_MAX)
            GP_TRY(gp_fail(log, GP_ERR_USAGE,
                           "--views: too many (over %d); make them in several "
                           "runs", GP_VIEWS_MAX));
        char *const name = gp_strdup(at);
        if (!name)
            GP_TRY(gp_no_memory_bare(log, "view list"));
        name[end - at] = '\0';
        bool good = *name && !strchr(name, '/');
        for (int i = 0; i < v.n; i++)
            good = good && strcmp(v.name[i], name) != 0;
        v.name[v.n++] = name;
        if (!good)
            GP_TRY(gp_fail(log, GP_ERR_USAGE,
                           "--views: not a list of views (found \"%s\" in "
                           "\"%s\"); write each name once and without a "
                           "slash, e.g. left,right", name, text));
    }
    *out = v;
    return GP_OK;
out:
    gp_views_free(&v);
    return st;
}

gp_status gp_views_check(const struct gp_log *log, const struct gp_pattern *p,
                         const struct gp_views *v)
{
    bool longs = false;
    for (const char *s = p->path; p->views && (s = strchr(s, '%')); s++)
        longs = longs || s[1] == 'V';
    for (int i = 1; p->views && !longs && i < v->n; i++) {
        const size_t n = letter_bytes(v->name[i]);
        for (int k = 0; k < i; k++) {
            if (strncmp(v->name[i], v->name[k], n) == 0)
                return gp_fail(log, GP_ERR_USAGE,
                               "%s: %%v is the same letter for two views "
                               "(found %s and %s); write %%V", p->path,
                               v->name[k], v->name[i]);
        }
    }
    return GP_OK;
}
