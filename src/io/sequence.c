#include "io/sequence.h"

#include "core/memory.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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

// -- views -------------------------------------------------------------------

/* Length of a %V or %v at `s`, 0 when there is none. */
static size_t view_token(const char *s)
{
    return s[0] == '%' && (s[1] == 'V' || s[1] == 'v') ? 2 : 0;
}

static int count_views(const char *path)
{
    int n = 0;
    for (; *path; path++)
        n += view_token(path) > 0;
    return n;
}

size_t gp_view_letter(const char *view)
{
    size_t n = *view ? 1 : 0;
    while (n && ((unsigned char) view[n] & 0xc0) == 0x80)
        n++;
    return n;
}

/* `p` with its places for views filled; NULL for `view` leaves them. The new
 * path is the caller's (free()); NULL when memory is full. */
static char *fill_views(const struct gp_pattern *p, const char *view,
                        struct gp_pattern *out)
{
    const size_t places = view ? (size_t) p->views : 0;
    char *const path = malloc(strlen(p->path) + places *
                              (view ? strlen(view) : 0) + 1);
    size_t to = 0, from = 0;
    if (!path)
        return NULL;
    *out = *p;
    out->path = path;
    out->views = 0;
    while (p->path[from]) {
        const size_t n = places ? view_token(p->path + from) : 0;
        const size_t bytes = !n ? 1 : p->path[from + 1] == 'V'
                                ? strlen(view) : gp_view_letter(view);
        if (p->len && from == p->at)
            out->at = to;
        memcpy(path + to, n ? view : p->path + from, bytes);
        to += bytes;
        from += n ? n : 1;
    }
    path[to] = '\0';
    return path;
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
    p.views = count_views(path);
    *out = p;
    return GP_OK;
}

gp_status gp_pattern_of_input(const struct gp_log *log, const char *path,
                              struct gp_pattern *out)
{
    *out = (struct gp_pattern) {.path = path};
    return access(path, F_OK) == 0 ? GP_OK : gp_pattern_find(log, path, out);
}

char *gp_pattern_name(const struct gp_pattern *p, int frame, const char *view)
{
    struct gp_pattern filled;
    char number[24];
    char *const path = fill_views(p, view, &filled);
    if (!path || !filled.len)
        return path;
    const int n = snprintf(number, sizeof number, "%0*d", p->digits, frame);
    const size_t tail = strlen(path + filled.at + filled.len) + 1;
    char *const name = malloc(filled.at + (size_t) n + tail);
    if (name) {
        memcpy(name, path, filled.at);
        memcpy(name + filled.at, number, (size_t) n);
        memcpy(name + filled.at + n, path + filled.at + filled.len, tail);
    }
    free(path);
    return name;
}

// -- what is on disk ---------------------------------------------------------

static int ascending(const void *a, const void *b)
{
    int x = *(const int *) a, y = *(const int *) b;
    return (x > y) - (x < y);
}

/* The number of `name` when it is a frame of the pattern whose component
 * starts at `start`; -1 else. */
static int frame_of(const struct gp_pattern *p, size_t start, const char *name)
{
    const size_t head = p->at - start;
    if (strncmp(name, p->path + start, head) != 0)
        return -1;
    const char *const digits = name + head;
    int n = 0, number = 0;
    for (; n < GP_FRAME_DIGITS && is_digit(digits[n]); n++)
        number = 10 * number + (digits[n] - '0');
    if (n == 0 || strcmp(digits + n, p->path + p->at + p->len) != 0)
        return -1;
    // only the padding that would be written is a match
    return snprintf(NULL, 0, "%0*d", p->digits, number) == n ? number : -1;
}

static gp_status scan(const struct gp_log *log, const struct gp_pattern *p,
                      DIR *folder, struct gp_frames *f)
{
    const size_t start = name_at(p->path);
    for (const struct dirent *e; (e = readdir(folder));) {
        int number = frame_of(p, start, e->d_name);
        if (number < 0)
            continue;
        if (f->n == GP_FRAME_LIST_MAX)
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: too many frames (over %d); choose some with "
                           "--frames", p->path, f->n);
        if (!gp_frames_add(f, number))
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

/* The frames of a pattern whose views are filled. */
static gp_status list_folder(const struct gp_log *log,
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
        return gp_fail(log, reason == ENOMEM ? GP_ERR_BUG : GP_ERR_IO,
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

gp_status gp_frames_on_disk(const struct gp_log *log,
                            const struct gp_pattern *p, const char *view,
                            struct gp_frames *out)
{
    struct gp_pattern filled;
    char *const path = fill_views(p, view, &filled);
    if (!path)
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory", p->path);
    gp_status st = list_folder(log, &filled, out);
    free(path);
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
