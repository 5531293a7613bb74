// SPDX-License-Identifier: Apache-2.0
#include "cli/keys.h"

#include "cli/words.h"
#include "core/json.h"
#include "core/maths.h"
#include "core/memory.h"

#include <errno.h>
#include <float.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

// -- numbers -------------------------------------------------------------------

static gp_status out_of_range(const struct gp_use *u)
{
    return gp_fail(u->log, GP_ERR_USAGE,
                   "--%s: out of range (found %s); give %s", u->option->name,
                   u->value, gp_option_range(u->option).text);
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

static gp_status read_number(const struct gp_use *u, double *out)
{
    const struct gp_option *const o = u->option;
    const bool whole = o->kind == GP_KIND_INT || o->kind == GP_KIND_COUNT;
    char *end;
    const char *s = u->value;
    double v;
    errno = 0;
    const long long n = whole ? strtoll(u->value, &end, 10) : 0;
    if (whole ? end == u->value || *end : !read_double(&s, &v) || *s)
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: not %s (found \"%s\"); give %s", o->name,
                       whole ? "a whole number" : "a number", u->value,
                       gp_option_range(o).text);
    v = whole ? (double) n : v; // (ranges end before 2^53)
    if ((whole && errno == ERANGE) || !(v >= o->lo && v <= o->hi)) // NaN too
        return out_of_range(u);
    *out = v;
    return GP_OK;
}

/* Values whose number has a sign for its unit: "99.9%", "+3ev". */
enum { FACTOR, EV, AUTO };
// clang-format off
static const struct measure {
    enum gp_option_kind kind;
    const char *what, *give, *range; // what to give; out of range, NULL: the same
    struct unit {
        const char *sign;
        int unit;
        double lo, hi;
    } unit[4]; // NULL sign at the end
} measures[] = {
    {GP_KIND_LEVEL, "a level",
     "a factor over 0 and up to 1e+09, EV such as +6ev, or auto", NULL,
     {{"", FACTOR, (double) FLT_MIN, 1e9},
      {"ev", EV, -126.0, 29.897352853986263}}}, // of these factors
    {GP_KIND_THRESHOLD, "a threshold",
     "a luminance such as 1, a percentile such as 99.9%, or +3ev",
     "0 or more, 0% to 100%, or -64ev to 64ev",
     {{"", GLAREPP_LUMINANCE, 0.0, (double) FLT_MAX},
      {"%", GLAREPP_PERCENTILE, 0.0, 100.0}, {"ev", GLAREPP_EV, -64.0, 64.0}}},
    {GP_KIND_SIZE, "a size", "0.1 to 10000 percent of the image's pixels, or its "
     "height as 0.001deg to 180deg", NULL,
     {{"", false, 0.1, 1e4}, {"%", false, 0.1, 1e4}, {"deg", true, 0.001, 180.0}}},
};
// clang-format on

static gp_status read_measure(const struct gp_use *u, double *out, int *unit)
{
    const struct measure *m = measures;
    const char *end = u->value;
    *unit = AUTO;
    *out = 0.0;
    if (u->option->kind == GP_KIND_LEVEL && strcmp(end, "auto") == 0)
        return GP_OK;
    while (m->kind != u->option->kind)
        m++;
    const bool read = read_double(&end, out);
    const char *const sign = strcasecmp(end, "ev") == 0 ? "ev" : end;
    const struct unit *k = m->unit;
    while (k->sign && strcmp(sign, k->sign) != 0)
        k++;
    *unit = k->unit;
    if (read && k->sign && *out >= k->lo && *out <= k->hi) // no NaN
        return GP_OK;
    if (read && k->sign && m->range)
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: out of range (found %s); give %s",
                       u->option->name, u->value, m->range);
    return gp_fail(u->log, GP_ERR_USAGE, "--%s: not %s (found \"%s\"); give %s",
                   u->option->name, m->what, u->value, m->give);
}

/* Reads numbers of "x,y,...". */
static gp_status read_list(const struct gp_use *u, struct gp_numbers *out)
{
    const struct gp_option *const o = u->option;
    struct gp_numbers list = {0};
    const char *s = u->value;
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
                       o->name, range, o->most, u->value, o->arg);
    for (int i = 0; i < list.n; i++) {
        if (!(list.v[i] >= o->lo && list.v[i] <= o->hi))
            return out_of_range(u);
    }
    if (o->at == offsetof(struct gp_settings, sun.at) && list.v[2] < 0.0)
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--sun: a negative radius (found %g); give 0 or more",
                       list.v[2]);
    *out = list;
    return GP_OK;
}

gp_status gp_quantity_read(const struct gp_use *u, struct gp_quantity *out)
{
    const enum gp_option_kind kind = u->option->kind;
    *out = (struct gp_quantity) {.list.n = 1};
    return kind == GP_KIND_NUMBERS ? read_list(u, &out->list)
           : kind == GP_KIND_SIZE || kind == GP_KIND_LEVEL ||
                   kind == GP_KIND_THRESHOLD
               ? read_measure(u, out->list.v, &out->unit)
               : read_number(u, out->list.v);
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

/* Adds a key, of a frame and a value as words. */
static gp_status add_key(const struct gp_log *log, const char *frame,
                         const char *value, struct gp_keyed *k)
{
    const char *const name = k->option->name;
    void *block = k->key;
    char *end;
    const long n = strtol(frame, &end, 10);
    struct gp_key key = {.frame = (int) n};
    const struct gp_key *const last = k->n ? &k->key[k->n - 1] : NULL;
    // (strtol takes blanks and a plus, too)
    if (!*frame || *end || !strchr("-0123456789", *frame) ||
        labs(n) > 1000000000)
        return gp_fail(log, GP_ERR_USAGE,
                       "--%s: not a frame number (found \"%s\"); write keys as "
                       "FRAME:VALUE, a line of a file as FRAME,VALUE",
                       name, frame);
    if (last && last->frame >= key.frame)
        return gp_fail(log, GP_ERR_USAGE,
                       "--%s: frames of keys must rise (found %d after %d); "
                       "sort them",
                       name, key.frame, last->frame);
    if (k->n == GP_KEYS_MOST)
        return gp_fail(log, GP_ERR_USAGE,
                       "--%s: too many keys (over %d); leave some out", name,
                       GP_KEYS_MOST);
    gp_status st;
    GP_TRY(gp_quantity_read(&(struct gp_use) {log, k->option, value}, &key.v));
    if (last && (last->v.unit != key.v.unit || last->v.list.n != key.v.list.n))
        GP_TRY(gp_fail(log, GP_ERR_USAGE,
                       "--%s: keys of two kinds (found \"%s\" after others); "
                       "give each the same %s",
                       name, value,
                       last->v.list.n != key.v.list.n ? "count of numbers"
                                                      : "unit"));
    GP_TRY(gp_resize(log, "keys", ((size_t) k->n + 1) * sizeof key, &block));
    k->key = block;
    k->key[k->n++] = key;
out:
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

/* Reads "1001:0.5,1050:2", of lists "1001:3/4,1050:5/6"; or of a file lines
 * "frame,value", of which the first may be a heading. Changes `text`. */
static gp_status read_keys(const struct gp_log *log, const char *file,
                           char *text, struct gp_keyed *k)
{
    const bool list = k->option->kind == GP_KIND_NUMBERS;
    bool heading = file;
    int n = 1;
    gp_status st = GP_OK;
    if (file && strncmp(text, "\xef\xbb\xbf", 3) == 0) // byte order mark
        text += 3;
    for (char *item = text, *next; item && !st; item = next, n++) {
        struct gp_place place;
        const struct gp_log there = gp_place_log(&place, log, file, n);
        const struct gp_log *const to = file ? &there : log;
        next = strchr(item, file ? '\n' : ',');
        if (next)
            *next++ = '\0';
        if (file)
            strip(item);
        const bool first = heading && *item;
        heading = heading && !first;
        if (file && (!*item || (first && !strchr("-0123456789", *item))))
            continue;
        char *const value = strchr(item, file ? ',' : ':');
        if (value)
            *value = '\0';
        if (value && !file && list)
            for (char *c = value; (c = strchr(c + 1, '/'));)
                *c = ',';
        st = value ? add_key(to, item, value + 1, k)
             : file
                 ? gp_fail(to, GP_ERR_USAGE,
                           "--%s: no value (found \"%s\"); write FRAME,VALUE",
                           k->option->name, item)
                 : gp_fail(to, GP_ERR_USAGE,
                           "--%s: not a key (found \"%s\"); write "
                           "FRAME:VALUE%s",
                           k->option->name, item,
                           list ? ", a list as FRAME:X/Y" : "");
    }
    if (!st && file && !k->n)
        st = gp_fail(log, GP_ERR_USAGE,
                     "%s: no keys of --%s (the file has no line FRAME,VALUE); "
                     "write one a line",
                     file, k->option->name);
    return st == GP_ERR_USAGE && file ? GP_ERR_DATA : st; // the file is wrong
}

gp_status gp_keys_read(const struct gp_use *u, struct gp_settings *s)
{
    const struct gp_log *const log = u->log;
    const char *const value = u->value, *const path = value + 1;
    const struct gp_option *const o = u->option;
    struct gp_keyed k = {.option = o, .file = *value == '@' ? path : NULL};
    void *block = s->keyed, *text = NULL;
    uint64_t size = 0;
    gp_status st;
    // (what is made once, or known before a frame is read, is in other groups)
    if (o->kind == GP_KIND_INT || o->kind == GP_KIND_COUNT ||
        (o->group != GP_GROUP_LIGHT && o->group != GP_GROUP_SUN &&
         o->group != GP_GROUP_TONE) ||
        s->command != GP_COMMAND_MAIN)
        return gp_fail(log, GP_ERR_USAGE,
                       "--%s: takes no keys here (found %s), as it is the same "
                       "for all frames; give one value",
                       o->name, value);
    if (k.file) {
        GP_TRY(gp_load_regular(log, k.file, MOST_BYTES, &text, &size));
        if (size > MOST_BYTES)
            GP_TRY(gp_fail(log, GP_ERR_DATA,
                           "%s: too large (over %d MiB); leave some keys out",
                           k.file, MOST_BYTES >> 20));
    } else if (!(text = gp_strdup(value)))
        GP_TRY(gp_no_memory_bare(log, "keys"));
    GP_TRY(read_keys(log, k.file, text, &k));
    GP_TRY(gp_resize(log, "keys", ((size_t) s->keyeds + 1) * sizeof *s->keyed,
                     &block));
    s->keyed = block;
    s->keyed[s->keyeds++] = k;
    gp_quantity_set(o, &k.key[0].v, s);
    k.key = NULL; // the settings'
out:
    gp_free(k.key);
    gp_free(text);
    return st;
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

void gp_settings_at(const struct gp_settings *s, int frame,
                    struct gp_settings *out)
{
    *out = *s;
    for (const struct gp_keyed *k = s->keyed; k < s->keyed + s->keyeds; k++) {
        int i = 0;
        while (i < k->n && k->key[i].frame <= frame)
            i++;
        const struct gp_key *const after = &k->key[i < k->n ? i : i - 1];
        const struct gp_key *const before = &k->key[i > 0 ? i - 1 : 0];
        // a key's own value as it was written, between two keys by double
        struct gp_quantity v = before->v;
        const double from = before->frame, way = after->frame - from;
        const double t = way > 0.0 ? (frame - from) / way : 0.0;
        for (int c = 0; c < v.list.n && t != 0.0; c++)
            v.list.v[c] += t * (after->v.list.v[c] - v.list.v[c]);
        gp_quantity_set(k->option, &v, out);
    }
    gp_settings_point(out);
}
