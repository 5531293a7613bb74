#include "sun/json.h"

#include "core/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SMALL_FILE = 1 << 20 };

// -- reading -----------------------------------------------------------------

/* Bytes of a file, with room for one more. */
struct text {
    char *at;  // owned
    size_t n, room;
};

/* Twice the room, at most `most` + 2: one byte over the limit tells that the
 * file is too large, for pipes too, and one more ends the text. */
static gp_status widen(const struct gp_log *log, const char *path, size_t most,
                       struct text *t)
{
    const size_t room = 2 * t->room < most + 2 ? 2 * t->room : most + 2;
    void *wider;
    const gp_status st = gp_alloc(log, path, room, 1, &wider);
    if (st)
        return st;
    memcpy(wider, t->at, t->n);
    gp_free(t->at);
    t->at = wider;
    t->room = room;
    return GP_OK;
}

/* Reads to the end of the file, or one byte over `most`. */
static gp_status read_all(const struct gp_log *log, const char *path, int fd,
                          size_t most, struct text *t)
{
    enum { FIRST = 16 << 10 }; // most files
    gp_status st;
    GP_TRY(gp_alloc(log, path, FIRST, 1, (void **) &t->at));
    t->room = FIRST;
    while (t->n <= most) {
        if (t->n + 1 == t->room)
            GP_TRY(widen(log, path, most, t));
        const ssize_t n = read(fd, t->at + t->n, t->room - 1 - t->n);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return gp_fail(log, GP_ERR_IO,
                           "%s: cannot read (%s); check the file", path,
                           strerror(errno));
        if (n == 0)
            break;
        t->n += (size_t) n;
    }
    t->at[t->n] = '\0';
out:
    return st;
}

/* Text of a file or a library as it may stand in a message: one short line
 * without control characters. */
struct shown {
    char text[128];
};

static struct shown show(const char *text)
{
    struct shown s;
    size_t n = strnlen(text, sizeof s.text - 1);
    // no half of an UTF-8 character at the cut
    while (text[n] && n > 0 && ((unsigned char) text[n] & 0xc0) == 0x80)
        n--;
    for (size_t i = 0; i < n; i++) {
        unsigned char c = (unsigned char) text[i];
        s.text[i] = c < 0x20 || c == 0x7f ? '?' : text[i];
    }
    s.text[n] = '\0';
    return s;
}

static gp_status parse(const struct gp_log *log, const char *path,
                       const char *text, size_t bytes, json_t **out)
{
    static const char mark[] = "\xef\xbb\xbf"; // some editors' byte order mark
    if (bytes >= 3 && memcmp(text, mark, 3) == 0) {
        text += 3;
        bytes -= 3;
    }
    if (strspn(text, " \t\r\n") == bytes)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: not JSON (the file is empty); write an array or "
                       "an object", path);
    json_error_t e;
    json_t *root = json_loadb(
        text, bytes, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &e);
    if (!root && json_error_code(&e) == json_error_out_of_memory)
        return gp_no_memory(log, path);
    if (!root)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: not JSON at line %d, column %d (%s); correct it "
                       "there", path, e.line, e.column, show(e.text).text);
    *out = root;
    return GP_OK;
}

gp_status gp_json_read_most(const struct gp_log *log, const char *path,
                            size_t most, json_t **out)
{
    gp_status st;
    struct text text = {0};
    struct stat about;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return gp_fail(log, GP_ERR_IO, "%s: cannot open (%s); check the name",
                       path, strerror(errno));
    if (fstat(fd, &about) == 0 && S_ISDIR(about.st_mode)) {
        st = gp_fail(log, GP_ERR_IO,
                     "%s: cannot read (it is a folder); name a file", path);
        goto out;
    }
    GP_TRY(read_all(log, path, fd, most, &text));
    if (text.n > most) {
        st = gp_fail(log, GP_ERR_DATA,
                     "%s: too large (over %zu KiB); split it", path,
                     most >> 10);
        goto out;
    }
    st = parse(log, path, text.at, text.n, out);
out:
    gp_free(text.at);
    close(fd);
    return st;
}

gp_status gp_json_read(const struct gp_log *log, const char *path,
                       json_t **out)
{
    return gp_json_read_most(log, path, SMALL_FILE, out);
}

// -- messages ----------------------------------------------------------------

/* "lights.json: light 3", "lights.json" */
struct place_text {
    char text[2048];
};

static struct place_text place_text(const struct gp_json_place *p)
{
    struct place_text t;
    if (p->index > 0)
        snprintf(t.text, sizeof t.text, "%s: %s %d", p->path, p->what,
                 p->index);
    else
        snprintf(t.text, sizeof t.text, "%s", p->path);
    return t;
}

/* What a value is: "a text", "an array of 2", "0.5". */
struct found_text {
    char text[48];
};

static struct found_text found_text(const json_t *v)
{
    struct found_text t;
    switch (json_typeof(v)) {
    case JSON_OBJECT:
        snprintf(t.text, sizeof t.text, "an object");
        break;
    case JSON_ARRAY:
        snprintf(t.text, sizeof t.text, "an array of %zu", json_array_size(v));
        break;
    case JSON_STRING:
        snprintf(t.text, sizeof t.text, "a text");
        break;
    case JSON_INTEGER:
    case JSON_REAL:
        snprintf(t.text, sizeof t.text, "%.9g", json_number_value(v));
        break;
    case JSON_TRUE:
    case JSON_FALSE:
        snprintf(t.text, sizeof t.text, "%s",
                 json_is_true(v) ? "true" : "false");
        break;
    default:
        snprintf(t.text, sizeof t.text, "null");
    }
    return t;
}

/* "0 to 1"; "a finite number" where any will do. */
struct range_text {
    char text[64];
};

static struct range_text range_text(double lo, double hi)
{
    struct range_text t;
    if (lo <= -DBL_MAX && hi >= DBL_MAX)
        snprintf(t.text, sizeof t.text, "a finite number");
    else
        snprintf(t.text, sizeof t.text, "%.9g to %.9g", lo, hi);
    return t;
}

/* A list of names for a message: "a", "b", "c". */
struct names_text {
    char text[512];
};

static struct names_text names_text(const char *const names[])
{
    struct names_text t = {""};
    size_t at = 0;
    for (int i = 0; names[i] && at < sizeof t.text; i++)
        at += (size_t) snprintf(t.text + at, sizeof t.text - at, "%s\"%s\"",
                                i ? ", " : "", names[i]);
    return t;
}

// -- structure ---------------------------------------------------------------

gp_status gp_json_array(const struct gp_json_place *p, json_t *root,
                        const char *key, size_t most, json_t **out)
{
    json_t *a = json_is_object(root) ? json_object_get(root, key) : root;
    if (!a)
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: no \"%s\" (found an object without it); give "
                       "{\"%s\": [...]}", place_text(p).text, key, key);
    if (!json_is_array(a))
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: \"%s\" is no array (found %s); give "
                       "{\"%s\": [...]}", place_text(p).text, key,
                       found_text(a).text, key);
    if (json_array_size(a) > most)
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: too many in \"%s\" (found %zu); at most %zu",
                       place_text(p).text, key, json_array_size(a), most);
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
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: no object (found %s); give {...} with %s",
                       place_text(p).text, found_text(o).text,
                       names_text(keys).text);
    json_object_foreach (o, key, value) { // in the file's order
        if (!in_list(key, keys, &at))
            return gp_fail(p->log, GP_ERR_DATA,
                           "%s: unknown key (found \"%s\"); there are %s",
                           place_text(p).text, show(key).text,
                           names_text(keys).text);
    }
    return GP_OK;
}

// -- values ------------------------------------------------------------------

/* The value of a key, or NULL; tells *found where the caller asks. */
static json_t *value_of(json_t *o, const char *key, bool *found)
{
    json_t *v = json_object_get(o, key);
    if (found)
        *found = v != NULL;
    return v;
}

static gp_status check_number(const struct gp_json_place *p, const char *key,
                              const json_t *v, double lo, double hi,
                              double *out)
{
    if (!json_is_number(v))
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: \"%s\" is no number (found %s); give %s",
                       place_text(p).text, key, found_text(v).text,
                       range_text(lo, hi).text);
    double d = json_number_value(v);
    if (!(isfinite(d) && d >= lo && d <= hi))
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: \"%s\" out of range (found %s); give %s",
                       place_text(p).text, key, found_text(v).text,
                       range_text(lo, hi).text);
    *out = d;
    return GP_OK;
}

gp_status gp_json_number(const struct gp_json_place *p, json_t *o,
                         const char *key, double lo, double hi, double *out,
                         bool *found)
{
    const json_t *v = value_of(o, key, found);
    return v ? check_number(p, key, v, lo, hi, out) : GP_OK;
}

gp_status gp_json_int(const struct gp_json_place *p, json_t *o,
                      const char *key, int lo, int hi, int *out, bool *found)
{
    const json_t *v = value_of(o, key, found);
    double d;
    if (!v)
        return GP_OK;
    gp_status st = check_number(p, key, v, lo, hi, &d);
    if (st)
        return st;
    if (d != floor(d))
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: \"%s\" is no whole number (found %s); give %d to "
                       "%d", place_text(p).text, key, found_text(v).text, lo,
                       hi);
    *out = (int) d;
    return GP_OK;
}

gp_status gp_json_numbers(const struct gp_json_place *p, json_t *o,
                          const char *key, int count, bool grey, double lo,
                          double hi, double *out, bool *found)
{
    const json_t *v = value_of(o, key, found);
    if (!v)
        return GP_OK;
    const bool lone = grey && !json_is_array(v);
    if (!lone && json_array_size(v) != (size_t) count) // 0 of what is none
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: \"%s\" is no array of %d numbers (found %s); give "
                       "%d of them%s", place_text(p).text, key, count,
                       found_text(v).text, count, grey ? ", or one" : "");
    double read = 0.0;
    // all are looked at before any is written
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
                       const char *key, const char **out, bool *found)
{
    const json_t *v = value_of(o, key, found);
    if (!v)
        return GP_OK;
    if (!json_is_string(v))
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: \"%s\" is no text (found %s); put it in quotes",
                       place_text(p).text, key, found_text(v).text);
    *out = json_string_value(v);
    return GP_OK;
}

gp_status gp_json_choice(const struct gp_json_place *p, json_t *o,
                         const char *key, const char *const names[], int *out,
                         bool *found)
{
    const char *text = NULL;
    int at;
    gp_status st = gp_json_text(p, o, key, &text, found);
    if (st || !text)
        return st;
    if (!in_list(text, names, &at))
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: unknown \"%s\" (found \"%s\"); there are %s",
                       place_text(p).text, key, show(text).text,
                       names_text(names).text);
    *out = at;
    return GP_OK;
}
