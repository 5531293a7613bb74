// SPDX-License-Identifier: Apache-2.0
/* JSON: reads files strictly, with messages that name the place; makes JSON of
 * strings of any bytes. */
#include "core/json.h"

#include "core/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// -- memory ------------------------------------------------------------------

/* jansson omits what it cannot allocate: where it is watched, a failed allocation
 * counts on its thread until the next text or file. */
static _Thread_local bool full;

static void *allocate(size_t size)
{
    void *const p = malloc(size);
    full = full || !p;
    return p;
}

void gp_json_watch_memory(void)
{
    json_set_alloc_funcs(allocate, free);
}

// -- writing -----------------------------------------------------------------

json_t *gp_json_name(const char *s)
{
    static const char replacement[] = "\xef\xbf\xbd"; // U+FFFD
    char *clean = s ? allocate(3 * strlen(s) + 1) : NULL, *to = clean;
    if (!clean) {
        full = true;
        return NULL;
    }
    while (*s) {
        size_t n = gp_utf8_bytes(s);
        memcpy(to, n ? s : replacement, n ? n : 3);
        to += n ? n : 3;
        s += n ? n : 1;
    }
    *to = '\0';
    json_t *value = json_string(clean);
    free(clean);
    return value;
}

/* Returns the text with control characters over U+007E as \uXXXX, and frees
 * `text`. (They are in strings only, where jansson escapes C0 alone.) */
static char *escape_controls(char *text)
{
    enum { ESCAPE = 6 };
    size_t more = 0;
    for (const char *s = text; *s; s += gp_utf8_bytes(s))
        more += (unsigned char) *s > '~' && gp_control_bytes(s) ? ESCAPE : 0;
    if (!more)
        return text;
    char *const clean = allocate(strlen(text) + more + 1), *to = clean;
    for (const char *s = text; clean && *s; s += gp_utf8_bytes(s)) {
        const size_t n = gp_utf8_bytes(s);
        unsigned code = (unsigned char) *s & (n == 1 ? 0x7fu : 0xffu >> n);
        for (size_t i = 1; i < n; i++)
            code = code << 6 | ((unsigned char) s[i] & 0x3fu);
        if (code > '~' && gp_control_bytes(s))
            to += snprintf(to, ESCAPE + 1, "\\u%04X", code);
        else
            to = (char *) memcpy(to, s, n) + n;
    }
    if (clean)
        *to = '\0';
    free(text);
    return clean;
}

char *gp_json_print(json_t *o, size_t flags)
{
    char *text = o ? json_dumps(o, flags) : NULL;
    text = text ? escape_controls(text) : NULL;
    json_decref(o);
    if (full)
        GP_FREE(text);
    full = false;
    return text;
}

// -- words for messages ------------------------------------------------------

struct words {
    char text[512];
};

/* Returns the start of a file's or a library's text. */
static struct words cut_text(const char *text)
{
    struct words s;
    size_t n = strnlen(text, 127);
    // no half of an UTF-8 character at the cut
    while (text[n] && n > 0 && ((unsigned char) text[n] & 0xc0) == 0x80)
        n--;
    memcpy(s.text, text, n);
    s.text[n] = '\0';
    return s;
}

/* Describes a value: "a string", "an array of 2", "0.5". */
static struct words found_text(const json_t *v)
{
    static const char *const names[] = {
        [JSON_OBJECT] = "an object", [JSON_STRING] = "a string",
        [JSON_TRUE] = "true", [JSON_FALSE] = "false", [JSON_NULL] = "null",
    };
    struct words t;
    if (json_is_array(v))
        snprintf(t.text, sizeof t.text, "an array of %zu", json_array_size(v));
    else if (json_is_number(v))
        snprintf(t.text, sizeof t.text, "%.10g", json_number_value(v));
    else
        snprintf(t.text, sizeof t.text, "%s", names[json_typeof(v)]);
    return t;
}

/* "0 to 1"; "a finite number" where any will do. */
static struct words range_text(double lo, double hi)
{
    struct words t;
    if (lo <= -DBL_MAX && hi >= DBL_MAX)
        snprintf(t.text, sizeof t.text, "a finite number");
    else
        snprintf(t.text, sizeof t.text, "%.10g to %.10g", lo, hi);
    return t;
}

/* Lists names: "a", "b", "c". */
static struct words names_text(const char *const names[])
{
    struct words t = {""};
    size_t at = 0;
    for (int i = 0; names[i] && at < sizeof t.text; i++)
        at += (size_t) snprintf(t.text + at, sizeof t.text - at, "%s\"%s\"",
                                i ? ", " : "", names[i]);
    return t;
}

gp_status gp_json_fail(const struct gp_json_place *p, const char *fmt, ...)
{
    char text[GP_LINE_BYTES], place[64] = "";
    va_list args;
    va_start(args, fmt);
    vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    if (p->index)
        snprintf(place, sizeof place, ": %s %d", p->what,
                 p->index > 0 ? p->index : -1 - p->index);
    return gp_fail(p->log, GP_ERR_DATA, "%s%s: %s", p->path, place, text);
}

// -- reading -----------------------------------------------------------------

size_t gp_json_memory(const char *text, size_t bytes)
{
    static const unsigned char cost[256] = {
        ['{'] = 210, ['['] = 120, [','] = 40, [':'] = 40, ['"'] = 24};
    size_t sum = bytes;
    bool quoted = false;
    for (size_t i = 0; i < bytes; i++) {
        if (quoted && text[i] == '\\') {
            i++; // an escaped quote ends no string
            continue;
        }
        if (quoted && text[i] != '"')
            continue;
        quoted ^= text[i] == '"';
        sum += cost[(unsigned char) text[i]];
    }
    return sum;
}

gp_status gp_json_parse(const struct gp_log *log, const char *path,
                        const char *text, size_t bytes, json_t **out)
{
    static const char mark[] = "\xef\xbb\xbf"; // some editors' byte order mark
    json_error_t e;
    size_t first = 0;
    if (bytes >= 3 && memcmp(text, mark, 3) == 0) {
        text += 3;
        bytes -= 3;
    }
    while (first < bytes && text[first] && strchr(" \t\r\n", text[first]))
        first++;
    if (first == bytes)
        return gp_fail(log, GP_ERR_DATA, "%s: not JSON (the file is empty); "
                       "write an array or an object", path);
    full = false;
    errno = 0; // bad JSON and a full memory are one code of jansson's
    json_t *const root = json_loadb(
        text, bytes, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &e);
    if (full || (!root && errno == ENOMEM)) {
        json_decref(root);
        full = false;
        return gp_no_memory(log, path);
    }
    if (!root)
        return gp_fail(log, GP_ERR_DATA, "%s: not JSON at line %d, column %d "
                       "(%s); correct it there", path, e.line, e.column,
                       cut_text(e.text).text);
    *out = root;
    return GP_OK;
}

gp_status gp_open_regular(const struct gp_log *log, const char *path, int *fd,
                          uint64_t *size)
{
    struct stat about = {0};
    gp_status st = GP_OK;
    const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    // a socket cannot be opened (ENXIO)
    if (file < 0 ? errno != ENXIO : fstat(file, &about) != 0)
        st = gp_fail(log, GP_ERR_IO, "%s: cannot open (%s); check the name",
                     path, strerror(errno));
    else if (S_ISDIR(about.st_mode))
        st = gp_fail(log, GP_ERR_IO,
                     "%s: cannot read (it is a folder); name a file", path);
    else if (!S_ISREG(about.st_mode))
        st = gp_fail(log, GP_ERR_DATA,
                     "%s: no regular file (found a FIFO, "
                     "device or socket); give a file",
                     path);
    if (st && file >= 0)
        close(file);
    if (st)
        return st;
    *fd = file;
    *size = (uint64_t) about.st_size;
    return GP_OK;
}

gp_status gp_load_regular(const struct gp_log *log, const char *path,
                          size_t most, void **out, uint64_t *size)
{
    char *block = NULL;
    uint64_t all = 0;
    int fd = -1;
    gp_status st = gp_open_regular(log, path, &fd, &all);
    if (st)
        return st;
    const size_t wanted = all < most ? (size_t) all : most;
    size_t bytes = 0;
    GP_TRY(gp_alloc(log, path, wanted + 1, 1, &block));
    while (bytes < wanted) {
        const ssize_t n = read(fd, block + bytes, wanted - bytes);
        if (n == 0 || (n < 0 && errno != EINTR))
            GP_TRY(gp_fail(log, GP_ERR_IO,
                           "%s: cannot read (%s); check the file", path,
                           n ? strerror(errno) : "it shrank meanwhile"));
        bytes += n > 0 ? (size_t) n : 0;
    }
    block[bytes] = '\0';
    *out = block;
    *size = all;
    block = NULL; // the caller's
out:
    gp_free(block);
    close(fd);
    return st;
}

gp_status gp_json_read(const struct gp_log *log, const char *path, size_t most,
                       json_t **out)
{
    void *text = NULL;
    uint64_t bytes = 0;
    gp_status st = gp_load_regular(log, path, most, &text, &bytes);
    if (st)
        return st;
    st = bytes > most ? gp_fail(log, GP_ERR_DATA,
                                "%s: too large (over %zu KiB); split it", path,
                                most >> 10)
                      : gp_json_parse(log, path, text, (size_t) bytes, out);
    gp_free(text);
    return st;
}

// -- structure ---------------------------------------------------------------

gp_status gp_json_array(const struct gp_json_place *p, json_t *root,
                        const char *key, size_t most, json_t **out)
{
    json_t *a = json_is_object(root) ? json_object_get(root, key) : root;
    if (!a)
        return gp_json_fail(p, "no \"%s\" (found an object without it); give "
                            "{\"%s\": [...]}", key, key);
    if (!json_is_array(a))
        return gp_json_fail(p, "\"%s\" is not an array (found %s); give "
                            "{\"%s\": [...]}", key, found_text(a).text, key);
    if (json_array_size(a) > most)
        return gp_json_fail(p, "too many in \"%s\" (found %zu); give at most "
                            "%zu", key, json_array_size(a), most);
    *out = a;
    return GP_OK;
}

static bool in_list(const char *name, const char *const list[], int *at)
{
    for (*at = 0; list[*at]; ++*at) {
        if (strcmp(name, list[*at]) == 0)
            return true;
    }
    return false;
}

gp_status gp_json_keys(const struct gp_json_place *p, json_t *o,
                       const char *const keys[])
{
    const char *key;
    json_t *value;
    int at;
    if (!json_is_object(o))
        return gp_json_fail(p, "not an object (found %s); give {...} with %s",
                            found_text(o).text, names_text(keys).text);
    json_object_foreach (o, key, value) { // in the file's order
        if (!in_list(key, keys, &at))
            return gp_json_fail(p, "unknown key (found \"%s\"); use one of %s",
                                cut_text(key).text, names_text(keys).text);
    }
    return GP_OK;
}

// -- values ------------------------------------------------------------------

static gp_status check_number(const struct gp_json_place *p, const char *key,
    const json_t *v, double lo, double hi, double *out)
{
    if (!json_is_number(v))
        return gp_json_fail(p, "\"%s\" is not a number (found %s); give %s",
                            key, found_text(v).text, range_text(lo, hi).text);
    double d = json_number_value(v);
    if (!(isfinite(d) && d >= lo && d <= hi))
        return gp_json_fail(p, "\"%s\" out of range (found %s); give %s", key,
                            found_text(v).text, range_text(lo, hi).text);
    *out = d;
    return GP_OK;
}

gp_status gp_json_number(const struct gp_json_place *p, json_t *o,
    const char *key, double lo, double hi, double *out)
{
    const json_t *v = json_object_get(o, key);
    return v ? check_number(p, key, v, lo, hi, out) : GP_OK;
}

gp_status gp_json_int(const struct gp_json_place *p, json_t *o,
                      const char *key, int lo, int hi, int *out)
{
    const json_t *v = json_object_get(o, key);
    double d = 0.0;
    if (!v)
        return GP_OK;
    gp_status st = check_number(p, key, v, lo, hi, &d);
    if (st)
        return st;
    if (d != floor(d))
        return gp_json_fail(p, "\"%s\" is not a whole number (found %s); give "
                            "%d to %d", key, found_text(v).text, lo, hi);
    *out = (int) d;
    return GP_OK;
}

gp_status gp_json_numbers(const struct gp_json_place *p, json_t *o,
                          const char *key, int count, double lo, double hi,
                          double *out)
{
    const json_t *v = json_object_get(o, key);
    if (!v)
        return GP_OK;
    const bool grey = count < 0, lone = grey && !json_is_array(v);
    count = abs(count);
    if (!lone && json_array_size(v) != (size_t) count) // 0 of no array
        return gp_json_fail(p, "\"%s\" is not an array of %d numbers (found "
                            "%s); give %d of them%s", key, count,
                            found_text(v).text, count, grey ? ", or one" : "");
    double read = 0.0;
    // checks all before it writes any
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < count; i++) {
            const json_t *item = lone ? v : json_array_get(v, (size_t) i);
            gp_status st = check_number(p, key, item, lo, hi, &read);
            if (st)
                return st;
            if (pass)
                out[i] = read;
        }
    }
    return GP_OK;
}

gp_status gp_json_text(const struct gp_json_place *p, json_t *o,
                       const char *key, const char **out)
{
    const json_t *v = json_object_get(o, key);
    if (!v)
        return GP_OK;
    if (!json_is_string(v))
        return gp_json_fail(p, "\"%s\" is not a string (found %s); put it in "
                            "quotes", key, found_text(v).text);
    *out = json_string_value(v);
    return GP_OK;
}

gp_status gp_json_choice(const struct gp_json_place *p, json_t *o,
    const char *key, const char *const names[], int *out)
{
    const char *text = NULL;
    int at;
    gp_status st = gp_json_text(p, o, key, &text);
    if (st || !text)
        return st;
    if (!in_list(text, names, &at))
        return gp_json_fail(p, "unknown \"%s\" (found \"%s\"); use one of %s",
                            key, cut_text(text).text, names_text(names).text);
    *out = at;
    return GP_OK;
}
