// SPDX-License-Identifier: Apache-2.0
#include "cli/keys.h"

#include "cli/words.h"
#include "core/maths.h"
#include "core/memory.h"

#include <errno.h>
#include <float.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

// -- numbers -------------------------------------------------------------------

/* The value of an option as a word. */
struct value {
    const struct gp_log *log;
    const struct gp_option *option;
    const char *text;
};

static gp_status out_of_range(const struct value *u)
{
    return gp_fail(u->log, GP_ERR_USAGE,
                   "--%s: out of range (found %s); give %s", u->option->name,
                   u->text, gp_option_range(u->option).text);
}

/* Reads a number, without blanks before it, and moves *s after it. (Its decimal
 * point is a point: nothing calls setlocale().) */
static bool read_double(const char **s, double *out)
{
    if (**s == '\0' || strchr(" \t\n\v\f\r", **s))
        return false;
    char *end;
    *out = strtod(*s, &end);
    bool read = end != *s;
    *s = end;
    return read;
}

static gp_status read_number(const struct value *u, double *out)
{
    const struct gp_option *const o = u->option;
    const bool whole = o->kind == GP_KIND_INT || o->kind == GP_KIND_COUNT;
    char *end;
    const char *s = u->text;
    double v;
    errno = 0;
    const long long n = whole ? strtoll(u->text, &end, 10) : 0;
    if (whole ? end == u->text || *end : !read_double(&s, &v) || *s)
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: not %s (found \"%s\"); give %s", o->name,
                       whole ? "a whole number" : "a number", u->text,
                       gp_option_range(o).text);
    v = whole ? (double) n : v; // (ranges end before 2^53)
    if ((whole && errno == ERANGE) || !(v >= o->lo && v <= o->hi)) // NaN too
        return out_of_range(u);
    *out = v;
    return GP_OK;
}

enum { FACTOR, EV, AUTO };

/* Reads a level: "2", "+3ev" or "auto". */
static gp_status read_level(const struct value *u, double *out, int *unit)
{
    const double most = u->option->hi;
    const char *end = u->text;
    double v = 0.0;
    *unit = strcmp(u->text, "auto") == 0 ? AUTO : FACTOR;
    const bool read = *unit != AUTO && read_double(&end, &v);
    if (read && strcasecmp(end, "ev") == 0)
        *unit = EV;
    const double factor = *unit == EV ? gp_exp2(v) : v;
    if (*unit != AUTO &&
        (!read || (*end && *unit != EV) || !(factor > 0.0 && factor <= most)))
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: not a level (found \"%s\"); "
                       "give a factor over 0 and up to %g, EV such as +6ev, or "
                       "auto",
                       u->option->name, u->text, most);
    *out = v;
    return GP_OK;
}

/* Reads a threshold: "1", "99.9%" or "+3ev". */
static gp_status read_threshold(const struct value *u, double *out, int *unit)
{
    const char *end = u->text;
    double v;
    const bool read = read_double(&end, &v);
    const bool ev = read && strcasecmp(end, "ev") == 0;
    const bool percent = read && strcmp(end, "%") == 0;
    if (!read || (*end && !ev && !percent))
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: not a threshold (found "
                       "\"%s\"); give a luminance such as 1, a percentile such "
                       "as 99.9%%, or +3ev",
                       u->option->name, u->text);
    if (!(v >= (ev ? -64.0 : 0.0) &&
          v <= (ev        ? 64.0
                : percent ? 100.0
                          : (double) FLT_MAX))) // NaN too
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: out of range (found %s); "
                       "give 0 or more, 0%% to 100%%, or -64ev to 64ev",
                       u->option->name, u->text);
    *out = v;
    *unit = ev ? GLAREPP_EV : percent ? GLAREPP_PERCENTILE : GLAREPP_LUMINANCE;
    return GP_OK;
}

/* Reads a size of a kernel: "50", "50%" or "2deg". */
static gp_status read_size(const struct value *u, double *out, int *unit)
{
    const char *end = u->text;
    double v;
    const bool read = read_double(&end, &v);
    const bool degrees = read && strcmp(end, "deg") == 0;
    const bool percent = read && (!*end || strcmp(end, "%") == 0);
    if (!(percent && v >= 0.1 && v <= 10000.0) &&
        !(degrees && v >= 0.001 && v <= 180.0))
        return gp_fail(
            u->log, GP_ERR_USAGE,
            "--%s: not a size (found \"%s\"); "
            "give 0.1 to 10000 percent of the image's pixels, or its "
            "height as 0.001deg to 180deg",
            u->option->name, u->text);
    *out = v;
    *unit = degrees;
    return GP_OK;
}

/* Reads numbers of "x,y,...". */
static gp_status read_list(const struct value *u, struct gp_numbers *out)
{
    const struct gp_option *const o = u->option;
    struct gp_numbers list = {0};
    const char *s = u->text;
    char range[16] = "";
    bool whole = false;
    while (!whole && list.n < o->most && read_double(&s, &list.v[list.n])) {
        list.n++;
        whole = *s == '\0';
        if (!whole && *s++ != ',')
            break;
    }
    if (o->least < o->most)
        snprintf(range, sizeof range, "%d to ", o->least);
    if (!whole || list.n < o->least)
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: not %s%d numbers (found \"%s\"); write %s",
                       o->name, range, o->most, u->text, o->arg);
    for (int i = 0; i < list.n; i++) {
        if (!(list.v[i] >= o->lo && list.v[i] <= o->hi))
            return out_of_range(u);
    }
    if (o->at == offsetof(struct gp_settings, sun.at) && list.v[2] < 0.0)
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--sun: a negative radius (found "
                       "%g); give 0 or more",
                       list.v[2]);
    *out = list;
    return GP_OK;
}

gp_status gp_quantity_read(const struct gp_log *log, const struct gp_option *o,
                           const char *value, struct gp_quantity *out)
{
    const struct value u = {log, o, value};
    *out = (struct gp_quantity) {.list.n = 1};
    return o->kind == GP_KIND_NUMBERS ? read_list(&u, &out->list)
           : o->kind == GP_KIND_SIZE  ? read_size(&u, out->list.v, &out->unit)
           : o->kind == GP_KIND_LEVEL ? read_level(&u, out->list.v, &out->unit)
           : o->kind == GP_KIND_THRESHOLD
               ? read_threshold(&u, out->list.v, &out->unit)
               : read_number(&u, out->list.v);
}

void gp_quantity_set(const struct gp_option *o, const struct gp_quantity *q,
                     struct gp_settings *s)
{
    void *const field = (char *) s + o->at;
    struct glarepp_sense_params *const sense = field;
    struct glarepp_kernel_params *const kernel = field;
    const double v = q->list.v[0];
    switch (o->kind) {
    case GP_KIND_REAL:
        *(double *) field = v;
        break;
    case GP_KIND_INT:
        *(int *) field = (int) v;
        break;
    case GP_KIND_COUNT:
        *(long long *) field = (long long) v;
        break;
    case GP_KIND_NUMBERS:
        *(struct gp_numbers *) field = q->list;
        break;
    case GP_KIND_THRESHOLD:
        sense->threshold = (float) v;
        sense->unit = (enum glarepp_threshold) q->unit;
        break;
    case GP_KIND_SIZE:
        kernel->degrees = q->unit ? v : 0.0;
        kernel->percent = q->unit ? 100.0 : v;
        break;
    case GP_KIND_LEVEL:
        *(float *) field = (float) (q->unit == EV ? gp_exp2(v) : v);
        break;
    default:
        *(float *) field = (float) v;
    }
}

// -- keys ----------------------------------------------------------------------

enum { MOST_BYTES = 4 << 20 }; // of a file

bool gp_keys_are(const char *value)
{
    return *value == '@' || strchr(value, ':');
}

/* True for options whose value may be another in each frame: what is made once
 * for a run, or known before a frame is read, is in other groups. */
static bool may_change(const struct gp_option *o)
{
    return o->kind != GP_KIND_INT && o->kind != GP_KIND_COUNT &&
           (o->group == GP_GROUP_LIGHT || o->group == GP_GROUP_SUN ||
            o->group == GP_GROUP_TONE);
}

/* Keys being read. */
struct reading {
    const struct gp_log *log; // says where
    struct gp_keyed k;
};

/* Adds a key, of a frame and a value as words. */
static gp_status add_key(struct reading *r, const char *frame,
                         const char *value)
{
    struct gp_keyed *const k = &r->k;
    const char *const name = k->option->name;
    void *block = k->key;
    char *end;
    const long n = strtol(frame, &end, 10);
    struct gp_key key = {.frame = (int) n};
    const struct gp_key *const last = k->n ? &k->key[k->n - 1] : NULL;
    // (strtol takes blanks and a plus, too)
    if (!*frame || *end || !strchr("-0123456789", *frame) ||
        labs(n) > 1000000000)
        return gp_fail(r->log, GP_ERR_USAGE,
                       "--%s: not a frame number (found "
                       "\"%s\"); write keys as FRAME:VALUE, a line of a file "
                       "as FRAME,VALUE",
                       name, frame);
    if (last && last->frame >= key.frame)
        return gp_fail(r->log, GP_ERR_USAGE,
                       "--%s: frames of keys must rise "
                       "(found %d after %d); sort them",
                       name, key.frame, last->frame);
    if (k->n == GP_KEYS_MOST)
        return gp_fail(r->log, GP_ERR_USAGE,
                       "--%s: too many keys (over %d); "
                       "leave some out",
                       name, GP_KEYS_MOST);
    gp_status st = gp_quantity_read(r->log, k->option, value, &key.v);
    if (!st && last &&
        (last->v.unit != key.v.unit || last->v.list.n != key.v.list.n))
        st = gp_fail(r->log, GP_ERR_USAGE,
                     "--%s: keys of two kinds (found "
                     "\"%s\" after others); give each the same %s",
                     name, value,
                     last->v.list.n != key.v.list.n ? "count of numbers"
                                                    : "unit");
    if (!st)
        st =
            gp_resize(r->log, "keys", ((size_t) k->n + 1) * sizeof key, &block);
    if (st)
        return st;
    k->key = block;
    k->key[k->n++] = key;
    return GP_OK;
}

/* Reads "1001:0.5,1050:2", of lists "1001:3/4,1050:5/6"; changes `text`. */
static gp_status read_inline(struct reading *r, char *text)
{
    const bool list = r->k.option->kind == GP_KIND_NUMBERS;
    gp_status st = GP_OK;
    for (char *item = text, *next; item && !st; item = next) {
        next = strchr(item, ',');
        if (next)
            *next++ = '\0';
        char *const value = strchr(item, ':');
        if (value)
            *value = '\0';
        if (value && list)
            for (char *c = value + 1; (c = strchr(c, '/'));)
                *c = ',';
        st = value ? add_key(r, item, value + 1)
                   : gp_fail(r->log, GP_ERR_USAGE,
                             "--%s: not a key (found "
                             "\"%s\"); write FRAME:VALUE%s",
                             r->k.option->name, item,
                             list ? ", a list as FRAME:X/Y" : "");
    }
    return st;
}

/* Removes blanks at both ends of a line and beside commas, and a comment. */
static void strip(char *line)
{
    char *to = line;
    line[strcspn(line, "#")] = '\0';
    for (const char *c = line; *c; c++) {
        const size_t blanks = strspn(c, " \t\r");
        const char next = c[blanks];
        if (blanks && (to == line || to[-1] == ',' || next == ',' || !next))
            c += blanks - 1;
        else
            *to++ = *c;
    }
    *to = '\0';
}

/* Reads lines "frame,value"; the first may be a heading. */
static gp_status read_lines(struct reading *r, const char *path, char *text)
{
    const struct gp_log *const log = r->log;
    gp_status st = GP_OK;
    bool first = true;
    int n = 1;
    text += strncmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0; // byte order mark
    for (char *line = text, *next; line && !st; line = next, n++) {
        struct gp_place place;
        const struct gp_log there = gp_place_log(&place, log, path, n);
        next = strchr(line, '\n');
        if (next)
            *next++ = '\0';
        strip(line);
        if (!*line)
            continue;
        char *const comma = strchr(line, ',');
        const bool heading = first && !strchr("-0123456789", *line);
        first = false;
        if (heading)
            continue;
        if (comma)
            *comma = '\0';
        r->log = &there;
        st = comma ? add_key(r, line, comma + 1)
                   : gp_fail(r->log, GP_ERR_DATA,
                             "--%s: no value (found "
                             "\"%s\"); write FRAME,VALUE",
                             r->k.option->name, line);
    }
    r->log = log;
    if (st == GP_ERR_USAGE) // it is the file that is wrong
        st = GP_ERR_DATA;
    return st || r->k.n ? st
                        : gp_fail(log, GP_ERR_DATA,
                                  "%s: no keys of --%s (the "
                                  "file has no line FRAME,VALUE); write one a "
                                  "line",
                                  path, r->k.option->name);
}

gp_status gp_keys_read(const struct gp_log *log, const struct gp_option *o,
                       const char *value, struct gp_settings *s)
{
    struct reading r = {log, {.option = o, .file = NULL}};
    void *block = s->keyed;
    char *text = NULL;
    uint64_t size;
    gp_status st;
    if (!may_change(o) || s->command != GP_COMMAND_MAIN)
        return gp_fail(log, GP_ERR_USAGE,
                       "--%s: takes no keys here (found "
                       "%s), as it is the same for all frames; give one value",
                       o->name, value);
    if (*value == '@') {
        r.k.file = value + 1;
        st = gp_text_load(log, r.k.file, MOST_BYTES, &text, &size);
        if (!st && size > MOST_BYTES)
            st = gp_fail(log, GP_ERR_DATA,
                         "%s: too large (over %d MiB); leave "
                         "some keys out",
                         r.k.file, MOST_BYTES >> 20);
        if (!st)
            st = read_lines(&r, r.k.file, text);
    } else {
        text = gp_strdup(value);
        st = text ? read_inline(&r, text) : gp_no_memory_bare(log, "keys");
    }
    gp_free(text);
    if (!st)
        st = gp_resize(log, "keys", ((size_t) s->keyeds + 1) * sizeof *s->keyed,
                       &block);
    if (st) {
        gp_free(r.k.key);
        return st;
    }
    s->keyed = block;
    s->keyed[s->keyeds++] = r.k;
    gp_quantity_set(o, &r.k.key[0].v, s);
    return GP_OK;
}

void gp_keys_drop(struct gp_settings *s, const struct gp_option *o)
{
    int i = 0;
    while (i < s->keyeds && s->keyed[i].option != o)
        i++;
    if (i == s->keyeds)
        return;
    gp_free(s->keyed[i].key);
    s->keyed[i] = s->keyed[--s->keyeds];
}

// -- a frame's values ----------------------------------------------------------

/* Returns the value at a frame: a key's own as it was written, between two keys
 * by double. */
static struct gp_quantity value_at(const struct gp_keyed *k, int frame)
{
    int i = 0;
    while (i < k->n && k->key[i].frame <= frame)
        i++;
    const struct gp_key *const after = &k->key[i < k->n ? i : i - 1];
    const struct gp_key *const before = &k->key[i > 0 ? i - 1 : 0];
    struct gp_quantity v = before->v;
    if (before == after || before->frame == frame)
        return v;
    const double t = ((double) frame - before->frame) /
                     ((double) after->frame - before->frame);
    for (int c = 0; c < v.list.n; c++)
        v.list.v[c] += t * (after->v.list.v[c] - v.list.v[c]);
    return v;
}

void gp_settings_at(const struct gp_settings *s, int frame,
                    struct gp_settings *out)
{
    *out = *s;
    for (int i = 0; i < s->keyeds; i++) {
        const struct gp_quantity v = value_at(&s->keyed[i], frame);
        gp_quantity_set(s->keyed[i].option, &v, out);
    }
    gp_settings_point(out);
}
