// SPDX-License-Identifier: Apache-2.0
#include "cli/compare_page.h"

#include "cli/page/page.h"
#include "cli/words.h"
#include "core/json.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "io/file.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Of a page of many: pictures of a pair take at most 1 of SHARES, those of all
// thumbnails STRIP of it, of an index INDEX.
enum { SHARES = 8 };
static const double STRIP = 0.25, INDEX = 0.75;

/* An entry of a page, and how bad it is. */
struct gp_page_entry {
    json_t *entry; // owned
    int result;
    double error; // FLIP, else rel_l2; what cannot be compared is worst
    int order;
    size_t bytes; // of its pictures; 0: it has none
};

// -- gates ----------------------------------------------------------------------

/* The limits of the command line, as the library judged by them. */
static json_t *gates_of(const struct glarepp_compare_params *p,
                        const struct glarepp_compare_facts *f)
{
    static const char pixels[] = "pixels over it", max[] = "largest error";
    static const char *const status[] = {"match", "warning", "failure"};
    const bool eye = f->seen >= 0;
    const struct {
        const char *option;
        float value; // NaN: it has none
        const char *of;
    } gate[] = {
        {eye ? "perceptual" : "fail", eye ? NAN : p->fail,
         eye ? "pixels that an eye sees differ" : pixels},
        {"hardfail", p->hard_fail, max},
        {"fail-rel", p->fail_rel, "rel_l2"},
        {"fail-flip", p->fail_flip, "mean FLIP"},
        {"warn", p->warn, pixels},
        {"hardwarn", p->hard_warn, max},
    };
    json_t *const list = json_array();
    for (size_t i = 0; i < sizeof gate / sizeof *gate; i++) {
        const double limit = f->gate[i].limit;
        const int result = f->gate[i].result;
        char name[48];
        // (NaN fails without a limit)
        if (isnan(limit) || (isinf(gate[i].value) && !result))
            continue;
        const int n = snprintf(name, sizeof name, "--%s", gate[i].option);
        if (!isnan(gate[i].value))
            snprintf(name + n, sizeof name - (size_t) n, " %g",
                     (double) gate[i].value);
        json_array_append_new(list, json_pack("{ss ss so? so? ss}", "gate",
                                              name, "of", gate[i].of, "found",
                                              json_real(f->gate[i].found),
                                              "limit", json_real(limit),
                                              "status", status[result]));
    }
    return list;
}

// -- pictures --------------------------------------------------------------------

/* A file as the page names it, and the command that made it, under its name. */
static gp_status about(const struct gp_log *log, const char *name,
                       const char *path, json_t **out)
{
    char ending[8], *command = NULL;
    gp_status st = GP_OK;
    gp_file_ending(path, ending, sizeof ending);
    const bool may = strcmp(ending, "exr") == 0 || strcmp(ending, "png") == 0;
    if (may && gp_file_exists(path))
        st = gp_words_command(NULL, path, true, &command);
    if (st == GP_ERR_BUG)
        return gp_no_memory(log, path);
    *out = json_pack("{ss so so*}", "name", name, "file", gp_json_name(path),
                     "command", command ? gp_json_name(command) : NULL);
    gp_free(command);
    return GP_OK;
}

/* The colour of file k; without one in both the first channel of floats, in
 * grey. False: there is none. */
static bool find_light(const struct gp_compare_row *e, int k,
                       struct glarepp_image *out, const char **channel)
{
    const struct glarepp_compare_facts *const f = e->facts;
    const struct gp_stored_image *const m = e->image[k];
    *out = (struct glarepp_image) {
        .data = m->data,
        .primaries = m->chromaticities,
    };
    *channel = NULL;
    for (int c = 0; c < 3 && f->lit; c++)
        out->plane[c] = (void *) (uintptr_t) m->light[c];
    for (int i = 0; i < f->pairs && !f->lit && !*channel; i++) {
        const int at[2] = {f->in_a[i], f->in_b[i]};
        bool whole = false;
        for (int j = 0; j < 2; j++)
            whole |= at[j] >= 0 && e->image[j]->channel[at[j]].is_uint;
        if (whole)
            continue;
        *channel = f->pair[i];
        if (at[k] < 0)
            out->data = (struct gp_rect) {0};
        for (int c = 0; c < 3 && at[k] >= 0; c++)
            out->plane[c] = (void *) (uintptr_t) m->channel[at[k]].v;
    }
    return f->lit || *channel;
}

static gp_status make_set(const struct gp_log *log,
                          const struct gp_compare_row *e, const char **grey,
                          struct gp_page_set *s)
{
    const struct glarepp_compare_facts *const f = e->facts;
    struct glarepp_image light[2];
    struct glarepp_image map = GLAREPP_IMAGE;
    json_t *text;
    gp_status st = GP_OK;
    for (int k = 0; k < 2; k++) {
        if (!find_light(e, k, &light[k], grey))
            return GP_OK;
    }
    s->window = f->window;
    const int x = f->x - s->window.x0, y = f->y - s->window.y0;
    if (f->max > 0.0)
        s->keep = (struct gp_rect) {x, y, x + 1, y + 1};
    if (f->has_flip)
        GP_TRY(glarepp_compare_view(e->compare, -2, false, 1.0f, &map));
    GP_TRY(about(log, "A", e->a, &text));
    GP_TRY(gp_page_set_add(log, s, text, &light[0], NULL, NULL));
    GP_TRY(about(log, "B", e->b, &text));
    GP_TRY(gp_page_set_add(log, s, text, &light[1], &light[0], map.plane[0]));
out:
    glarepp_image_end(&map);
    return st;
}

// -- entries ----------------------------------------------------------------------

static void add_note(json_t *list, const char *before, const char *name,
                     const char *after)
{
    char text[512];
    snprintf(text, sizeof text, "%s%s%s", before, name, after);
    json_array_append_new(list, gp_json_name(text));
}

static json_t *make_entry(const struct gp_compare_pages *p,
                          const struct gp_compare_row *e, json_t *facts)
{
    char label[48] = "";
    const int n =
        p->sequence ? snprintf(label, sizeof label, "%d", e->frame) : 0;
    if (e->parts > 1)
        snprintf(label + n, sizeof label - (size_t) n, "%spart %d",
                 n ? ", " : "", e->part);
    json_t *const notes = json_array(), *const channels =
                                            e->why ? NULL : json_array();
    json_t *const o = json_pack("{ss sO so so*}", "label", label, "facts",
                                facts, "notes", notes, "channels", channels);
    if (e->why)
        return o;
    const struct glarepp_compare_facts *const f = e->facts;
    const struct gp_rect a = e->image[0]->data, b = e->image[1]->data;
    json_object_set_new(o, "gates", gates_of(&p->s->compare.limits, f));
    for (int i = 0; i < f->pairs; i++) {
        json_array_append_new(channels, gp_json_name(f->pair[i]));
        if (f->in_a[i] < 0 || f->in_b[i] < 0)
            add_note(notes, "channel ", f->pair[i],
                     f->in_a[i] < 0 ? " is only in B: 0 in A"
                                    : " is only in A: 0 in B");
    }
    if (memcmp(&a, &b, sizeof a) != 0)
        json_array_append_new(
            notes, json_sprintf("the data windows differ: %dx%d at (%d, %d) "
                                "and %dx%d at (%d, %d); 0 outside",
                                gp_rect_w(a), gp_rect_h(a), a.x0, a.y0,
                                gp_rect_w(b), gp_rect_h(b), b.x0, b.y0));
    return o;
}

static size_t bytes_of(const json_t *o)
{
    return json_dumpb(o, NULL, 0, JSON_COMPACT);
}

/* Says where figures are not of what the pictures show. */
static void note_shown(const struct gp_compare_row *e, json_t *notes)
{
    const struct glarepp_compare_facts *const f = e->facts;
    const int *const in[2] = {f->in_a, f->in_b};
    bool shown = !(f->max > 0.0);
    for (int k = 0; k < 2; k++) {
        const struct gp_stored_image *const m = e->image[k];
        if (m->integers)
            add_note(notes, k ? "B" : "A",
                     " has integers: its picture and the values under the "
                     "pointer are linear light, figures are of stored values",
                     "");
        const int at = in[k][f->channel];
        for (int c = 0; c < 3 && at >= 0; c++)
            shown |= m->own.c[c] || m->light[c] == m->channel[at].v;
    }
    if (!shown)
        add_note(notes, "pictures show colour: the largest error is in ",
                 f->pair[f->channel], "");
}

/* Adds pictures to an entry, in `bytes`, and a thumbnail, where `side` is not 0. */
static gp_status show(const struct gp_compare_pages *p,
                      const struct gp_compare_row *e, bool whole, size_t bytes,
                      int side, struct gp_page_entry *to)
{
    json_t *const entry = to->entry;
    json_t *const notes = json_object_get(entry, "notes");
    struct gp_page_set set = {.n = 0};
    const char *grey = NULL;
    json_t *packed = NULL;
    gp_status st = GP_OK;
    if (e->image[0]->first)
        add_note(notes, "deep pixels have figures, but no picture", "", "");
    else
        GP_TRY(make_set(p->log, e, &grey, &set));
    if (grey)
        add_note(notes, "no colour in both: shown is channel ", grey, "");
    else if (!set.n)
        add_note(notes, "no channel of floats to show", "", "");
    else
        note_shown(e, notes);
    if (set.n && side) {
        GP_TRY(gp_page_thumb(p->log, &set, 1, side, &packed));
        json_object_set_new(entry, "thumb", packed);
    }
    if (set.n && whole) {
        GP_TRY(gp_page_pack(p->log, &set, bytes, &packed));
        json_object_set_new(entry, "set", packed);
        to->bytes = bytes_of(packed);
    }
out:
    gp_page_set_free(&set);
    return st;
}

static int by_error(const void *a, const void *b)
{
    const struct gp_page_entry *const x = a, *const y = b;
    return x->result != y->result ? y->result - x->result
           : x->error != y->error
               ? (y->error > x->error) - (y->error < x->error)
               : x->order - y->order;
}

/* Returns the least bad entry with pictures, and how many have some; or NULL. */
static struct gp_page_entry *least_bad(const struct gp_compare_pages *p,
                                       int *shown)
{
    struct gp_page_entry *least = NULL;
    *shown = 0;
    for (struct gp_page_entry *k = p->kept.at; k < p->kept.at + p->kept.n;
         k++) {
        *shown += k->bytes > 0;
        if (k->bytes && (!least || by_error(k, least) > 0))
            least = k;
    }
    return least;
}

/* Adds pictures and a thumbnail to a new entry, as far as its page has room, which
 * less bad ones make. */
static gp_status fill(struct gp_compare_pages *p,
                      const struct gp_compare_row *e, struct gp_page_entry *new)
{
    // (a pixel of a thumbnail takes about 3 bytes of text, of 16 x 9; what a
    // picture says of itself up to about ABOUT)
    static const double SQUARE = 1.7, ABOUT = 4096.0, LEAST = 1024.0;
    const int parts = gp_max(e->parts, 1), all = p->pairs * parts;
    const int pairs = gp_max(p->pattern.len ? parts : all, p->kept.n);
    const double room = (double) gp_page_room(p->s, 0);
    const double strip = (p->index ? INDEX : STRIP) * room;
    const int side = p->sequence || parts > 1
                         ? gp_clamp_whole(sqrt(strip / all / SQUARE), 16, 160)
                         : 0;
    p->text += bytes_of(new->entry);
    const double text = (double) p->text / p->kept.n + SQUARE * side * side;
    const double most = fmax(room - text * pairs, LEAST);
    const double share = fmax(most / gp_min(pairs, SHARES) - ABOUT, LEAST);
    int shown;
    struct gp_page_entry *least = least_bad(p, &shown);
    // (pictures take as much as others do)
    const bool may = !least ||
                     (double) (p->used + p->used / (size_t) shown) <= most ||
                     by_error(new, least) < 0;
    const gp_status st = show(p, e, may, (size_t) share, side, new);
    p->used += new->bytes;
    while ((double) p->used > most && (least = least_bad(p, &shown)) &&
           shown > 1) {
        json_object_del(least->entry, "set");
        p->used -= least->bytes;
        least->bytes = 0;
    }
    return st;
}

/* Appends an entry, whose reference it takes. */
static gp_status append(const struct gp_log *log, struct gp_page_entries *to,
                        struct gp_page_entry entry)
{
    void *block = to->at;
    const gp_status st =
        gp_resize(log, "page", ((size_t) to->n + 1) * sizeof *to->at, &block);
    if (st) {
        json_decref(entry.entry);
        return st;
    }
    to->at = block;
    to->at[to->n++] = entry;
    return GP_OK;
}

gp_status gp_compare_pages_add(struct gp_compare_pages *p,
                               const struct gp_compare_row *e, json_t *facts)
{
    const struct glarepp_compare_facts *const f = e->why ? NULL : e->facts;
    const double error = !f            ? (double) INFINITY
                         : f->has_flip ? f->flip
                                       : f->rel_l2;
    gp_status st;
    if (!p->page) {
        char title[512];
        snprintf(title, sizeof title, "%s and %s",
                 gp_base_name(p->s->input.files.at[0]),
                 gp_base_name(p->s->input.files.at[1]));
        GP_TRY(gp_page_make(p->log, p->s, "compare", title, &p->page));
        if (p->s->page.index && !p->index)
            GP_TRY(gp_page_make(p->log, p->s, "index", title, &p->index));
    }
    GP_TRY(append(p->log, &p->kept,
                  (struct gp_page_entry) {make_entry(p, e, facts), e->result,
                                          error, p->kept.n, 0}));
    if (f)
        st = fill(p, e, &p->kept.at[p->kept.n - 1]);
out:
    return st;
}

// -- pages ------------------------------------------------------------------------

/* The link from an index to a page in its folder or one below; NULL: it is elsewhere. */
static const char *link_of(const char *index, const char *page)
{
    const size_t folder = (size_t) (gp_base_name(index) - index);
    const bool below = folder ? strncmp(index, page, folder) == 0
                              : gp_is_dash(index) || page[0] != '/';
    return below && strncmp(page + folder, "../", 3) != 0 ? page + folder
                                                          : NULL;
}

gp_status gp_compare_pages_begin(const struct gp_log *log,
                                 const struct gp_settings *s, int frames,
                                 struct gp_compare_pages *out)
{
    const char *const html = s->page.html, *const index = s->page.index;
    const char *const files[] = {html, index};
    gp_status st = GP_OK;
    *out = (struct gp_compare_pages) {
        .log = log,
        .s = s,
        .sequence = frames > 0,
        .pairs = gp_max(frames, 1),
        .pattern.path = html,
    };
    if (html && frames > 0)
        GP_TRY(gp_pattern_find(log, html, &out->pattern));
    if (index && !out->pattern.len)
        GP_TRY(gp_fail(log, GP_ERR_USAGE,
                       "%s: an index needs a page for each frame (found %s); "
                       "give --html a pattern, e.g. page.####.html",
                       index, html ? html : "no --html"));
    if (index && !link_of(index, html))
        GP_TRY(gp_fail(log, GP_ERR_USAGE,
                       "%s: its pages are not in its folder or below (found "
                       "%s); give --html-index FOLDER/index.html",
                       index, html));
    for (int i = 0; i < 2; i++) {
        if (files[i] && !gp_is_dash(files[i]))
            GP_TRY(gp_file_check(log, files[i], false));
    }
out:
    return st;
}

/* Writes a page, whose reference it takes, with these entries, the worst first. */
static gp_status write_page(const struct gp_compare_pages *p, const char *path,
                            json_t *page, struct gp_page_entries *from)
{
    json_t *const list = json_object_get(page, "entries");
    if (from->n)
        qsort(from->at, (size_t) from->n, sizeof *from->at, by_error);
    for (int i = 0; i < from->n; i++)
        json_array_append_new(list, from->at[i].entry);
    from->n = 0;
    return gp_page_save(p->log, p->s, path, page);
}

/* Lists the entries of a page in the index, without their pictures, and links it
 * back: up as many folders as its `path` goes down. */
static gp_status list_page(struct gp_compare_pages *p, const char *path)
{
    const char *const index = p->s->page.index;
    char up[PATH_MAX] = "";
    gp_status st = GP_OK;
    size_t n = 0;
    for (const char *at = path; (at = strchr(at, '/')) && n + 4 < sizeof up;
         at++)
        n += (size_t) snprintf(up + n, sizeof up - n, "../");
    if (!gp_is_dash(index))
        json_object_set_new(p->page, "index",
                            json_sprintf("%s%s", up, gp_base_name(index)));
    for (int i = 0; i < p->kept.n && !st; i++) {
        struct gp_page_entry e = p->kept.at[i];
        e.entry = json_copy(e.entry);
        e.order = p->listed.n;
        json_object_del(e.entry, "set");
        json_object_set_new(e.entry, "href", gp_json_name(path));
        st = append(p->log, &p->listed, e);
    }
    return st;
}

gp_status gp_compare_pages_write(struct gp_compare_pages *p, int frame,
                                 bool last)
{
    char *path = NULL;
    gp_status st = GP_OK;
    if (p->page && (p->pattern.len != 0) != last) {
        path = gp_pattern_name(&p->pattern, frame, NULL);
        if (!path)
            GP_TRY(gp_no_memory(p->log, p->s->page.html));
        if (p->index)
            GP_TRY(list_page(p, link_of(p->s->page.index, path)));
        st = write_page(p, path, p->page, &p->kept);
        p->page = NULL;
        p->used = p->text = 0;
    }
    if (last && p->index && !st) {
        st = write_page(p, p->s->page.index, p->index, &p->listed);
        p->index = NULL;
    }
out:
    free(path);
    return st;
}

void gp_compare_pages_free(struct gp_compare_pages *p)
{
    for (int i = 0; i < p->kept.n; i++)
        json_decref(p->kept.at[i].entry);
    for (int i = 0; i < p->listed.n; i++)
        json_decref(p->listed.at[i].entry);
    gp_free(p->kept.at);
    gp_free(p->listed.at);
    json_decref(p->page);
    json_decref(p->index);
    *p = (struct gp_compare_pages) {0};
}
