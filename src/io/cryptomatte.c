// SPDX-License-Identifier: Apache-2.0
/* Cryptomatte: the coverage of objects by their names.
 *
 * A type (objects, materials, ...) NAME has layers NAME00, NAME01, ..., each of
 * two ranks: an id in R and its coverage in G, an id in B and its coverage in A.
 * Source: Friedman and Jones, "Cryptomatte specification", version 1.2.0. */
#include "io/plane.h"

#include "core/bytes.h"
#include "core/json.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/murmur.h"
#include "core/parallel.h"
#include "io/channels.h"
#include "io/exr/exr.h"

#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

// -- ids ----------------------------------------------------------------------

/* The bits of the float that stands for a name in a pixel: its hash, with an
 * exponent that is neither 0 nor all ones. */
static uint32_t id_of(const char *name)
{
    const uint32_t hash = gp_murmur3(name, strlen(name), 0);
    const uint32_t exponent = hash >> 23 & 255;
    return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

// -- what is asked for ----------------------------------------------------------

struct wish {
    const char *text; // as given, with its escapes
    char *name;       // without them
    bool wild;
    bool listed; // a manifest has it
};

/* The layer of two ranks: channels R, G, B, A of a part, -1 where none. */
enum { RANKS = 100 };
struct rank {
    bool there;
    int part, channel[4];
};

struct type {
    const char *name;  // borrowed
    json_t *manifest;  // owned; NULL: none
    struct rank *rank; // RANKS of them
};

struct reading {
    const struct gp_log *log;
    const struct gp_read_params *p;
    const struct gp_frame *f;
    const struct gp_input *in;
    struct wish *wish;
    int wishes;
    char *words; // of the wishes
    struct type type[GP_CRYPTO_LAYERS];
    int types, bare;             // ... without a manifest
    struct rank *rank;           // of all types
    uint32_t *id;                // that are wanted, sorted; `ids` of them, from
    size_t ids, room;            // gp_resize()
    atomic_bool *seen;           // a pixel has the id
    char names[GP_CHANNEL_LIST]; // that are taken
};

/* Splits the list into wishes. */
static gp_status read_wishes(struct reading *c, const char *names)
{
    const size_t n = strlen(names);
    gp_status st;
    GP_TRY(gp_alloc_zero(c->log, "names", n + 1, sizeof *c->wish, &c->wish));
    GP_TRY(gp_alloc(c->log, "names", 2 * (n + 2), 1, &c->words));
    char *text = c->words, *name = c->words + n + 2;
    struct wish *w = c->wish;
    *w = (struct wish) {.text = text, .name = name};
    for (const char *s = names;; s++) {
        if (*s == ',' || !*s) {
            *text++ = *name++ = '\0';
            if (!*w->name)
                GP_TRY(gp_fail(c->log, GP_ERR_USAGE,
                               "%s: an empty name of Cryptomatte (found "
                               "\"%s\"); give crypto:NAME,NAME",
                               c->f->path, names));
            c->wishes++;
            if (!*s)
                break;
            *++w = (struct wish) {.text = text, .name = name};
            continue;
        }
        w->wild |= *s == '*' || *s == '?';
        if (*s == '\\' && s[1])
            *text++ = *s++;
        *text++ = *name++ = *s;
    }
out:
    return st;
}

/* Matches a whole name with a text of * and ?. */
static bool matches(const char *text, const char *name)
{
    const char *star = NULL, *back = NULL; // after the last *; its end so far
    while (*name) {
        const bool quoted = *text == '\\' && text[1];
        const char is = text[quoted];
        if (!quoted && is == '*') {
            star = ++text;
            back = name;
        } else if (!quoted && is == '?') {
            const size_t n = gp_utf8_bytes(name);
            name += n ? n : 1;
            text++;
        } else if (is == *name) {
            text += 1 + quoted;
            name++;
        } else if (star) {
            text = star;
            name = ++back;
        } else {
            return false;
        }
    }
    while (*text == '*')
        text++;
    return !*text;
}

static gp_status add_id(struct reading *c, const char *name)
{
    if (c->ids == c->room) {
        void *block = c->id;
        c->room = 2 * c->room + 64;
        const gp_status st = gp_resize(c->log, "ids of Cryptomatte",
                                       c->room * sizeof *c->id, &block);
        if (st)
            return st;
        c->id = block;
    }
    c->id[c->ids++] = id_of(name);
    gp_channel_list_add(c->names, NULL, name);
    return GP_OK;
}

// -- types and manifests --------------------------------------------------------

/* A text beside an attribute cryptomatte/KEY/name; NULL where there is none. */
static const char *text_of(const struct gp_input *in, int part,
                           const char *attribute, const char *field)
{
    char name[256];
    const char *text;
    int32_t bytes;
    snprintf(name, sizeof name, "%.*s%s",
             (int) (strlen(attribute) - strlen("name")), attribute, field);
    return exr_attr_get_string(in->exr, part, name, &bytes, &text) ? NULL
                                                                   : text;
}

/* Loads the manifest of a type from its header or the file beside; *left are the
 * bytes that it may have. */
static gp_status load_manifest(const struct reading *c, struct type *t,
                               const char *text, const char *file, size_t *left)
{
    char path[PATH_MAX];
    void *own = NULL;
    uint64_t bytes = text ? strlen(text) : 0;
    gp_status st = GP_OK;
    if (!bytes && file && *file) {
        const char *const slash = strrchr(c->f->path, '/');
        const int folder = slash ? (int) (slash + 1 - c->f->path) : 0;
        const int n =
            snprintf(path, sizeof path, "%.*s%s", folder, c->f->path, file);
        if (*file == '/' || strstr(file, "..") || n >= (int) sizeof path)
            return gp_fail(
                c->log, GP_ERR_DATA,
                "%s: the manifest of %s is not in the frame's folder "
                "(found %.200s); put it there",
                c->f->path, t->name, file);
        if (access(path, R_OK) != 0) // names work without it
            return GP_OK;
        GP_TRY(gp_load_regular(c->log, path, *left, &own, &bytes));
        text = own;
    } else {
        snprintf(path, sizeof path, "%s: manifest of %s", c->f->path, t->name);
    }
    if (bytes > *left)
        GP_TRY(gp_fail(c->log, GP_ERR_DATA,
                       "%s: too large for the frame (found %llu bytes, of %zu "
                       "that it may have); list fewer objects in it",
                       path, (unsigned long long) bytes, *left));
    *left -= (size_t) bytes;
    if (bytes)
        GP_TRY(gp_json_parse(c->log, path, text, (size_t) bytes, &t->manifest));
    if (t->manifest && !json_is_object(t->manifest))
        GP_TRY(gp_fail(c->log, GP_ERR_DATA,
                       "%s: not an object; write {\"NAME\": \"ID\"}", path));
out:
    gp_free(own);
    return st;
}

/* Finds the types of all parts, and their manifests. */
static gp_status find_types(struct reading *c)
{
    static const char *const facts[][2] = {
        {"hash", "MurmurHash3_32"},
        {"conversion", "uint32_to_float32"},
    };
    const struct gp_crypto *const found = &c->in->crypto;
    size_t left = GP_JSON_SMALL + 4 * gp_frame_pixels(c->f);
    gp_status st = GP_OK;
    for (int i = 0; i < found->n && !st; i++) {
        const char *const key = found->key[i];
        const int part = found->part[i];
        struct type *const t = &c->type[c->types++];
        t->name = found->layer[i];
        for (int k = 0; k < 2; k++) {
            const char *const is = text_of(c->in, part, key, facts[k][0]);
            if (is && strcmp(is, facts[k][1]) != 0)
                return gp_fail(c->log, GP_ERR_DATA,
                               "%s: the %s of Cryptomatte %s is not known "
                               "(found %.100s); only %s is",
                               c->f->path, facts[k][0], t->name, is,
                               facts[k][1]);
        }
        st = load_manifest(c, t, text_of(c->in, part, key, "manifest"),
                           text_of(c->in, part, key, "manif_file"), &left);
        c->bare += !t->manifest;
    }
    return st;
}

// -- names ----------------------------------------------------------------------

/* Writes a name as the option takes it. */
static void write_name(const char *name, char *out, size_t size)
{
    size_t n = 0;
    for (; *name && n + 3 < size; name++) {
        if (strchr("\\,*?", *name))
            out[n++] = '\\';
        out[n++] = *name;
    }
    out[n] = '\0';
}

/* Fails for a name that is not there, with the nearest three. */
static gp_status fail_nearest(const struct reading *c, const char *name)
{
    const char *near[3] = {NULL};
    char list[GP_CHANNEL_LIST] = "";
    for (int k = 0; k < 3; k++) {
        struct gp_nearest search = {
            .word = name,
            .length = strlen(name),
            .most = INT_MAX,
        };
        for (int i = 0; i < c->types; i++) {
            const char *key;
            json_t *value;
            json_object_foreach(c->type[i].manifest, key, value)
            {
                bool taken = false;
                for (int j = 0; j < k; j++)
                    taken = taken || strcmp(near[j], key) == 0;
                if (!taken)
                    gp_nearest_try(&search, key);
            }
        }
        if (!search.name)
            break;
        near[k] = search.name;
        char word[2 * GP_CHANNEL_NAME + 3] = "\"";
        write_name(near[k], word + 1, sizeof word - 2);
        strcat(word, "\"");
        gp_channel_list_add(list, NULL, word);
    }
    return gp_fail(c->log, GP_ERR_DATA,
                   "%s: its Cryptomatte has no %s (nearest are %s); give one "
                   "of those",
                   c->f->path, name, *list ? list : "none");
}

/* Looks the wishes up in the manifests: adds the ids of those that match. */
static gp_status find_names(struct reading *c)
{
    gp_status st = GP_OK;
    for (int w = 0; w < c->wishes && !st; w++) {
        struct wish *const wish = &c->wish[w];
        for (int i = 0; i < c->types; i++) {
            const char *key;
            json_t *value;
            json_object_foreach(c->type[i].manifest, key, value)
            {
                if (wish->wild ? !matches(wish->text, key)
                               : strcmp(wish->name, key) != 0)
                    continue;
                wish->listed = true;
                if (wish->wild)
                    GP_TRY(add_id(c, key));
            }
        }
        if (!wish->wild)
            st = add_id(c, wish->name);
        else if (c->bare == c->types)
            st = gp_fail(
                c->log, GP_ERR_DATA,
                "%s: its Cryptomatte has no manifest, in which %s would "
                "be looked up; give whole names",
                c->f->path, wish->text);
        else if (!wish->listed)
            st = fail_nearest(c, wish->text);
    }
out:
    return st;
}

static int compare_ids(const void *a, const void *b)
{
    const uint32_t *const p = a, *const q = b;
    return (*p > *q) - (*p < *q);
}

/* Returns the place of an id among those wanted, or -1. */
static long long find_id(const struct reading *c, uint32_t id)
{
    const uint32_t *const at =
        bsearch(&id, c->id, c->ids, sizeof id, compare_ids);
    return at ? at - c->id : -1;
}

/* Sorts the ids, each once. */
static gp_status sort_ids(struct reading *c)
{
    size_t n = 0;
    qsort(c->id, c->ids, sizeof *c->id, compare_ids);
    for (size_t i = 0; i < c->ids; i++) {
        if (i == 0 || c->id[i] != c->id[i - 1])
            c->id[n++] = c->id[i];
    }
    c->ids = n;
    return gp_alloc_zero(c->log, "ids of Cryptomatte", n, sizeof *c->seen,
                         &c->seen);
}

/* Checks that a pixel has the id of each whole name that no manifest has. */
static gp_status check_seen(const struct reading *c)
{
    for (int w = 0; w < c->wishes; w++) {
        const struct wish *const wish = &c->wish[w];
        if (wish->listed ||
            atomic_load(&c->seen[find_id(c, id_of(wish->name))]))
            continue;
        if (!c->bare)
            return fail_nearest(c, wish->name);
        gp_say(c->log, GP_LEVEL_WARN,
               "%s: no pixel is of %s, and no manifest says whether it exists; "
               "check the name",
               c->f->path, wish->name);
    }
    return GP_OK;
}

// -- layers -----------------------------------------------------------------------

/* The channel of a layer by its own name, 0 to 3; -1: another. */
static int component(const char *name)
{
    static const char *const words[] = {"red", "green", "blue", "alpha"};
    for (int k = 0; k < 4; k++) {
        if (strcasecmp(name, words[k]) == 0 ||
            (strlen(name) == 1 && strncasecmp(name, words[k], 1) == 0))
            return k;
    }
    return -1;
}

/* The number at the end of a type's layer; -1: it is another's. */
static int rank_of(const char *type, const char *layer, size_t length)
{
    const size_t n = strlen(type);
    if (length != n + 2 || strncmp(type, layer, n) != 0 ||
        strspn(layer + n, "0123456789") < 2)
        return -1;
    return 10 * (layer[n] - '0') + layer[n + 1] - '0';
}

/* Finds the layers of a part, whose channels are called as in the view of the
 * colour. A layer is of the first part that has it. */
static gp_status list_part(struct reading *c, int part)
{
    const char *const colour = gp_frame_colour(c->f);
    const char *const view = part == c->in->part && colour
                                 ? gp_exr_view_of(c->in, part, colour)
                                 : NULL;
    const char **name;
    const struct gp_exr_part *const own = &c->in->each[part];
    const int n = own->channel->num_channels;
    const gp_status st = gp_exr_names_in(c->log, c->in, part, view, &name);
    for (int i = 0; i < n && !st; i++) {
        const size_t dot = gp_layer_length(name[i]);
        const int k = component(name[i] + dot);
        for (int t = 0; t < c->types && k >= 0; t++) {
            const int at = rank_of(c->type[t].name, dot ? name[i] : own->layer,
                                   dot ? dot - 1 : own->length);
            struct rank *const r = at < 0 ? NULL : &c->type[t].rank[at];
            if (r && !r->there)
                *r = (struct rank) {true, part, {-1, -1, -1, -1}};
            if (r && r->part == part && r->channel[k] < 0)
                r->channel[k] = i;
        }
    }
    gp_free(name);
    return st;
}

/* Checks that ids are whole floats, and have coverage. */
static gp_status check_rank(const struct reading *c, const struct rank *r)
{
    const exr_attr_chlist_entry_t *const e =
        c->in->each[r->part].channel->entries;
    for (int k = 0; k < 4; k += 2) {
        const int id = r->channel[k];
        if (id < 0)
            continue;
        if (e[id].pixel_type != EXR_PIXEL_FLOAT || e[id].x_sampling != 1 ||
            e[id].y_sampling != 1)
            return gp_fail(c->log, GP_ERR_DATA,
                           "%s: channel %s has no whole ids (Cryptomatte's are "
                           "32-bit floats, one a pixel); render it so",
                           c->f->path, e[id].name.str);
        if (r->channel[k + 1] < 0)
            return gp_fail(c->log, GP_ERR_DATA,
                           "%s: channel %s has ids without coverage; keep both",
                           c->f->path, e[id].name.str);
    }
    return GP_OK;
}

/* Finds the layers of all types, in the colour's part, then the others of its
 * view or of none. */
static gp_status find_layers(struct reading *c)
{
    const struct gp_input *const in = c->in;
    bool some = false;
    gp_status st;
    GP_TRY(gp_alloc_zero(c->log, "layers of Cryptomatte",
                         (size_t) c->types * RANKS, sizeof *c->rank, &c->rank));
    for (int i = 0; i < c->types; i++)
        c->type[i].rank = c->rank + (size_t) i * RANKS;
    GP_TRY(list_part(c, in->part));
    for (int part = 0; part < in->parts; part++) {
        if (part != in->part && !in->each[part].deep &&
            !gp_exr_other_view(in, part, in->part))
            GP_TRY(list_part(c, part));
    }
    for (int i = 0; i < c->types * RANKS; i++) {
        some = some || c->rank[i].there;
        if (c->rank[i].there)
            GP_TRY(check_rank(c, &c->rank[i]));
    }
    if (!some)
        st = gp_fail(c->log, GP_ERR_DATA,
                     "%s: its Cryptomatte has no channels (%s00.R, G, B, A); "
                     "keep them beside the colour",
                     c->f->path, c->type[0].name);
out:
    return st;
}

// -- coverage ---------------------------------------------------------------------

/* Planes of a layer, and the sum that they are added to. */
struct adding {
    const struct reading *c;
    struct gp_rect both;      // the part of their window in the sum's
    struct gp_plane plane[4]; // of the layer
    float *sum;               // of the frame's window
};

static void add_row(void *ctx, int i, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_rect to = a->c->f->data, both = a->both;
    const int y = both.y0 + i, n = gp_rect_w(both);
    float *const sum =
        gp_row(a->sum, gp_rect_w(to), y - to.y0) + (both.x0 - to.x0);
    (void) thread;
    for (int k = 0; k < 4; k += 2) {
        const struct gp_plane *const id = &a->plane[k], *const cover = id + 1;
        const size_t from =
            (size_t) (y - id->window.y0) * (size_t) gp_rect_w(id->window) +
            (size_t) (both.x0 - id->window.x0);
        for (int x = 0; id->v && x < n; x++) {
            const float share = cover->v[from + (size_t) x];
            const long long at =
                share > 0.0f
                    ? find_id(a->c, gp_bits_of(id->v[from + (size_t) x]))
                    : -1;
            if (at < 0)
                continue;
            sum[x] += share;
            if (!atomic_load_explicit(&a->c->seen[at], memory_order_relaxed))
                atomic_store_explicit(&a->c->seen[at], true,
                                      memory_order_relaxed);
        }
    }
}

/* Adds up the layers of a type, then takes what is over `largest` into that. */
static gp_status add_type_up(const struct reading *c, const struct type *t,
                             float *sum, float *largest)
{
    const size_t n = gp_frame_pixels(c->f);
    gp_status st = GP_OK;
    memset(sum, 0, n * sizeof *sum);
    for (int i = 0; i < RANKS && !st; i++) {
        struct adding a = {.c = c, .sum = sum};
        const struct rank *const r = &t->rank[i];
        if (!r->there)
            continue;
        st = gp_read_channels(c->log, c->p, c->f, r->part, r->channel, 4,
                              a.plane);
        for (int k = 0; k < 4; k += 2) {
            if (a.plane[k].v)
                a.both = gp_rect_meet(a.plane[k].window, c->f->data);
        }
        if (!st && !gp_rect_empty(a.both))
            gp_parallel_do(gp_rect_h(a.both), add_row, &a);
        for (int k = 0; k < 4; k++)
            gp_plane_free(&a.plane[k]);
    }
    for (size_t i = 0; i < n && !st; i++)
        largest[i] = gp_maxf(largest[i], gp_minf(sum[i], 1.0f));
    return st;
}

gp_status gp_read_crypto(const struct gp_log *log,
                         const struct gp_read_params *p,
                         const struct gp_frame *f, const char *names,
                         struct gp_plane *out)
{
    struct reading c = {.log = log, .p = p, .f = f, .in = gp_input_of(f)};
    const size_t n = gp_frame_pixels(f);
    struct gp_plane plane = {.window = f->data};
    float *sum = NULL;
    gp_status st;
    GP_TRY(read_wishes(&c, names));
    if (c.in)
        GP_TRY(find_types(&c));
    if (!c.types)
        GP_TRY(
            gp_fail(log, GP_ERR_DATA,
                    "%s: has no Cryptomatte (no cryptomatte/KEY/name); render "
                    "it into the frame",
                    f->path));
    GP_TRY(find_names(&c));
    GP_TRY(sort_ids(&c));
    GP_TRY(find_layers(&c));
    GP_TRY(gp_alloc(log, "Cryptomatte", n, sizeof *sum, &sum));
    GP_TRY(gp_alloc_zero(log, "Cryptomatte", n, sizeof *plane.v, &plane.v));
    for (int i = 0; i < c.types; i++)
        GP_TRY(add_type_up(&c, &c.type[i], sum, plane.v));
    GP_TRY(check_seen(&c));
    plane.name = gp_strdup(c.names);
    if (!plane.name)
        GP_TRY(gp_no_memory(log, f->path));
    *out = plane;
    plane = (struct gp_plane) {0};
out:
    gp_plane_free(&plane);
    gp_free(sum);
    gp_free(c.seen);
    gp_free(c.id);
    gp_free(c.rank);
    for (int i = 0; i < c.types; i++)
        json_decref(c.type[i].manifest);
    gp_free(c.words);
    gp_free(c.wish);
    return st;
}
