// SPDX-License-Identifier: Apache-2.0
/* Pictures as text. A plane of halfs is coded as deflate likes it, without loss:
 *
 * 1. codes are the halfs' bits; green, red - green, blue - green: noise of a grey
 *    surface is one noise, and a difference of bits is nearly one of logarithms
 * 2. of pictures after the first minus those of the first
 * 3. minus what three neighbours say (MED: Weinberger, Seroussi, Sapiro, "LOCO-I",
 *    1996), sign at the low end
 * 4. high bytes of all, then low bytes; zlib; base64
 *
 * page.js undoes it. Sums are modulo 2^16. */
#include "cli/page/page.h"

#include "cli/words.h"
#include "core/colour.h"
#include "core/half.h"
#include "core/json.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "io/file.h"
#include "io/write.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAST = 256, FAST = 1, SMALL = 9 }; // pixels of a region; levels of zlib

/* The samples of a page: averages of scale x scale pixels, and a region of single
 * ones (empty: none), from the window's corner. */
struct plan {
    int scale, w, h; // squares
    struct gp_rect region;
    size_t n; // squares, then pixels of the region
};

static struct plan plan_of(const struct gp_page_set *s, int scale)
{
    struct plan p = {
        .scale = scale,
        .w = (gp_rect_w(s->window) + scale - 1) / scale,
        .h = (gp_rect_h(s->window) + scale - 1) / scale,
    };
    p.n = (size_t) p.w * (size_t) p.h;
    return p;
}

void gp_page_set_free(struct gp_page_set *s)
{
    for (int i = 0; i < s->n; i++) {
        struct gp_page_picture *const p = &s->picture[i];
        json_decref(p->about);
        for (int c = 0; c < 3; c++)
            gp_free(p->half[c]);
        gp_free(p->relative);
        gp_free(p->flip);
    }
    *s = (struct gp_page_set) {0};
}

// -- a picture as halfs ----------------------------------------------------------

/* Row y of a plane in the window: `row` of floats, 0 outside. */
static void read_row(const struct glarepp_image *l, int c,
                     struct gp_rect window, int y, float *row)
{
    const struct gp_rect all = l->data, in = gp_rect_meet(all, window);
    memset(row, 0, (size_t) gp_rect_w(window) * sizeof *row);
    if (y < in.y0 || y >= in.y1 || gp_rect_empty(in))
        return;
    const size_t at = (size_t) (y - all.y0) * (size_t) gp_rect_w(all) +
                      (size_t) (in.x0 - all.x0);
    memcpy(row + (in.x0 - window.x0), (const float *) l->plane[c] + at,
           (size_t) gp_rect_w(in) * sizeof *row);
}

static void read_luminance(const struct glarepp_image *l, struct gp_rect window,
                           int y, float *row, float *sum)
{
    const size_t w = (size_t) gp_rect_w(window);
    float weight[3];
    gp_luminance_weights(l->primaries ? l->primaries : gp_rec709_chromaticities,
                         weight);
    memset(sum, 0, w * sizeof *sum);
    for (int c = 0; c < 3; c++) {
        read_row(l, c, window, y, row);
        for (size_t x = 0; x < w; x++)
            sum[x] += weight[c] * row[x];
    }
}

/* The relative error at each pixel: |dY| over Y of a and 1e-6 of its maximum. 0; or
 * 1 to 255 for an error of 1e-9 to 100, in equal steps of its logarithm; NaN and Inf
 * are 255. page.js has the same constants. */
static void find_relative(const struct glarepp_image *a,
                          const struct glarepp_image *b, struct gp_rect window,
                          float *row, uint8_t *to)
{
    const int w = gp_rect_w(window);
    const double step = 11.0 * M_LN10 / 254.0, least = 9.0 * M_LN10;
    float *const ya = row + w, *const yb = ya + w;
    double most = 0.0;
    for (int y = window.y0; y < window.y1; y++) {
        read_luminance(a, window, y, row, ya);
        for (int x = 0; x < w; x++)
            most = isfinite(ya[x]) ? fmax(most, (double) ya[x]) : most;
    }
    for (int y = window.y0; y < window.y1; y++, to += w) {
        read_luminance(a, window, y, row, ya);
        read_luminance(b, window, y, row, yb);
        for (int x = 0; x < w; x++) {
            const double d = fabs((double) yb[x] - (double) ya[x]);
            const bool same = (isnan(ya[x]) && isnan(yb[x])) || ya[x] == yb[x];
            const double e = d / (fabs((double) ya[x]) + 1e-6 * most);
            const double code = rint((gp_log(fmax(e, 1e-9)) + least) / step);
            to[x] = same || e == 0.0 ? 0
                    : !(e < 100.0)
                        ? 255
                        : (uint8_t) (1 + gp_clamp_whole(code, 0, 254));
        }
    }
}

/* Rounds a plane to halfs; counts what that changes: values that a half cannot
 * hold, and those that are no number. Returns sums by half stops: by bits 9 and up
 * of positive halfs. */
static json_t *round_plane(const struct glarepp_image *l, int c,
                           struct gp_rect window, float *row, uint16_t *to,
                           json_int_t count[3])
{
    const int w = gp_rect_w(window);
    float *const back = row + w;
    json_int_t bin[128] = {0};
    json_t *const list = json_array();
    for (int y = window.y0; y < window.y1; y++, to += w) {
        read_row(l, c, window, y, row);
        count[1] += (json_int_t) gp_float_to_half(row, to, (size_t) w);
        gp_half_to_float(to, back, (size_t) w);
        for (int x = 0; x < w; x++) {
            count[0] += row[x] != back[x] && !isnan(row[x]);
            count[2] += !isfinite(row[x]);
            bin[to[x] >> 9]++;
        }
    }
    for (int i = 0; i < 62; i++) // (then infinite, NaN, and under 0)
        json_array_append_new(list, json_integer(bin[i]));
    return list;
}

gp_status gp_page_set_add(const struct gp_log *log, struct gp_page_set *s,
                          json_t *about, const struct glarepp_image *light,
                          const struct glarepp_image *base, const float *flip)
{
    struct gp_page_picture *const p = &s->picture[s->n++];
    const size_t w = (size_t) gp_rect_w(s->window);
    const size_t n = w * (size_t) gp_rect_h(s->window);
    json_int_t count[3] = {0};
    json_t *const bins = json_array();
    float *row = NULL;
    gp_status st;
    *p = (struct gp_page_picture) {.about = about};
    GP_TRY(gp_alloc(log, "page rows", w, 3 * sizeof *row, &row));
    for (int c = 0; c < 3; c++) {
        GP_TRY(gp_alloc(log, "page", n, sizeof *p->half[c], &p->half[c]));
        json_array_append_new(
            bins, round_plane(light, c, s->window, row, p->half[c], count));
    }
    if (base) {
        GP_TRY(gp_alloc(log, "page", n, 1, &p->relative));
        find_relative(base, light, s->window, row, p->relative);
    }
    if (flip)
        GP_TRY(gp_alloc(log, "page", n, 1, &p->flip));
    for (size_t i = 0; i < n && flip; i++)
        p->flip[i] = (uint8_t) lrintf(255.0f * gp_clamp01(flip[i]));
    json_object_set(about, "histogram", bins);
    json_object_set_new(about, "rounded", json_integer(count[0]));
    json_object_set_new(about, "clamped", json_integer(count[1]));
    json_object_set_new(about, "odd", json_integer(count[2]));
out:
    json_decref(bins);
    gp_free(row);
    return st;
}

// -- averages -------------------------------------------------------------------

/* Copies the region of a plane of bytes or halfs after the averages. */
static void copy_region(const struct gp_page_set *s, const struct plan *p,
                        const void *from, size_t size, void *to)
{
    const struct gp_rect r = p->region;
    const size_t w = (size_t) gp_rect_w(s->window), row = (size_t) gp_rect_w(r);
    char *out = (char *) to + (size_t) p->w * (size_t) p->h * size;
    for (int y = r.y0; y < r.y1; y++, out += row * size)
        memcpy(out,
               (const char *) from + ((size_t) y * w + (size_t) r.x0) * size,
               row * size);
}

/* The means of a plane's squares; `sum` holds four rows of the window. */
static void average(const struct gp_page_set *s, const struct plan *p,
                    const uint16_t *half, float *sum, uint16_t *to)
{
    const int w = gp_rect_w(s->window), h = gp_rect_h(s->window);
    float *const row = sum + w;
    for (int j = 0; j < p->h; j++, to += p->w) {
        const int from = j * p->scale, end = gp_min(h, from + p->scale);
        memset(sum, 0, (size_t) p->w * sizeof *sum);
        for (int y = from; y < end; y++) {
            gp_half_to_float(half + (size_t) y * (size_t) w, row, (size_t) w);
            for (int x = 0; x < w; x++)
                sum[x / p->scale] += row[x];
        }
        for (int i = 0; i < p->w; i++)
            sum[i] /=
                (float) ((end - from) * gp_min(p->scale, w - i * p->scale));
        (void) gp_float_to_half(sum, to, (size_t) p->w);
    }
}

// -- codes ----------------------------------------------------------------------

/* Memory for the coding of one picture at a time. */
struct coder {
    const struct gp_log *log;
    const struct gp_page_set *s;
    const struct plan *p;
    float *row;             // two of the window; owns all of these
    uint16_t *base, *plane; // three planes of codes each: of the first picture,
                            // of the present one, then of what it is more
    uint8_t *out;           // what zlib gets
};

static gp_status begin_coder(const struct gp_log *log,
                             const struct gp_page_set *s, const struct plan *p,
                             struct coder *k)
{
    const size_t rows = 2 * (size_t) gp_rect_w(s->window) * sizeof *k->row;
    *k = (struct coder) {.log = log, .s = s, .p = p};
    const gp_status st = gp_alloc(log, "page", rows + 18 * p->n, 1, &k->row);
    if (!st) {
        k->base = (uint16_t *) (void *) ((char *) k->row + rows);
        k->plane = k->base + 3 * p->n;
        k->out = (uint8_t *) (k->plane + 3 * p->n);
    }
    return st;
}

/* The codes of a picture, three planes. */
static void make_codes(const struct coder *k, int i, uint16_t *to)
{
    static const int order[3] = {1, 0, 2}; // green first
    const size_t n = k->p->n;
    const uint16_t *const green = to;
    for (int c = 0; c < 3; c++, to += n) {
        const uint16_t *const half = k->s->picture[i].half[order[c]];
        average(k->s, k->p, half, k->row, to);
        copy_region(k->s, k->p, half, sizeof *half, to);
        for (size_t at = 0; at < n && c; at++)
            to[at] = (uint16_t) (to[at] - green[at]);
    }
}

/* Writes the bytes that MED leaves of a w x h block. */
static void predict(const uint16_t *v, int w, int h, uint8_t *high,
                    uint8_t *low)
{
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            const size_t at = (size_t) y * (size_t) w + (size_t) x;
            const size_t up = at - (size_t) w;
            const int l = x ? (int16_t) v[at - 1] : y ? (int16_t) v[up] : 0;
            const int u = y ? (int16_t) v[up] : l;
            const int lu = x && y ? (int16_t) v[up - 1] : l;
            const int least = gp_min(l, u), most = gp_max(l, u);
            const int guess = lu >= most    ? least
                              : lu <= least ? most
                                            : l + u - lu;
            const int16_t d = (int16_t) (uint16_t) (v[at] - (unsigned) guess);
            const unsigned code =
                d < 0 ? ~((unsigned) d << 1) : (unsigned) d << 1;
            high[at] = (uint8_t) (code >> 8);
            low[at] = (uint8_t) code;
        }
    }
}

/* Packs the codes of a picture. */
static gp_status pack_codes(struct coder *k, const uint16_t *v, int level,
                            void **out, size_t *size)
{
    const struct plan *const p = k->p;
    const size_t squares = (size_t) p->w * (size_t) p->h;
    for (int c = 0; c < 3; c++, v += p->n) {
        uint8_t *const high = k->out + 2 * p->n * (size_t) c;
        uint8_t *const low = high + p->n;
        predict(v, p->w, p->h, high, low);
        predict(v + squares, gp_rect_w(p->region), gp_rect_h(p->region),
                high + squares, low + squares);
    }
    return gp_zlib_pack(k->log, k->out, 6 * p->n, level, out, size);
}

static json_t *base64(const uint8_t *from, size_t n)
{
    static const char digit[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const size_t size = (n + 2) / 3 * 4;
    char *const text = malloc(size + 1);
    for (size_t i = 0, to = 0; text && i < n; i += 3, to += 4) {
        const unsigned v = (unsigned) from[i] << 16 |
                           (i + 1 < n ? (unsigned) from[i + 1] << 8 : 0) |
                           (i + 2 < n ? from[i + 2] : 0);
        for (size_t k = 0; k < 4; k++)
            text[to + k] = i + k > n ? '=' : digit[v >> (18 - 6 * k) & 63];
    }
    json_t *const string = text ? json_stringn_nocheck(text, size) : NULL;
    free(text);
    return string;
}

/* Sets packed bytes as `key` of `to`, and adds their length in base64; frees
 * them. */
static gp_status take(const struct gp_log *log, void *bytes, size_t n,
                      json_t *to, const char *key, size_t *total)
{
    const bool lost = json_object_set_new(to, key, base64(bytes, n)) != 0;
    *total += (n + 2) / 3 * 4;
    gp_free(bytes);
    return lost ? gp_no_memory_bare(log, "page") : GP_OK;
}

/* Packs a map of errors: of squares the most, so that no average hides one. */
static gp_status pack_map(struct coder *k, const uint8_t *map, int level,
                          json_t *to, const char *key, size_t *total)
{
    const struct plan *const p = k->p;
    const int w = gp_rect_w(k->s->window), h = gp_rect_h(k->s->window);
    void *bytes;
    size_t n;
    if (!map)
        return GP_OK;
    copy_region(k->s, p, map, 1, k->out);
    memset(k->out, 0, (size_t) p->w * (size_t) p->h);
    for (int y = 0; y < h; y++) {
        uint8_t *const row = k->out + (size_t) (y / p->scale) * (size_t) p->w;
        for (int x = 0; x < w; x++, map++)
            row[x / p->scale] = (uint8_t) gp_max(row[x / p->scale], *map);
    }
    const gp_status st =
        gp_zlib_pack(k->log, k->out, k->p->n, level, &bytes, &n);
    return st ? st : take(k->log, bytes, n, to, key, total);
}

/* Packs all pictures by a plan, each into what is said about it; *total is the
 * length of their text. */
static gp_status pack_all(const struct gp_log *log, const struct gp_page_set *s,
                          const struct plan *p, int level, size_t *total)
{
    struct coder k;
    gp_status st;
    *total = 0;
    GP_TRY(begin_coder(log, s, p, &k));
    for (int i = 0; i < s->n; i++) {
        const struct gp_page_picture *const picture = &s->picture[i];
        uint16_t *const codes = i ? k.plane : k.base;
        json_t *const to = picture->about;
        void *bytes;
        size_t n;
        make_codes(&k, i, codes);
        for (size_t at = 0; at < 3 * p->n && i; at++)
            codes[at] = (uint16_t) (codes[at] - k.base[at]);
        GP_TRY(pack_codes(&k, codes, level, &bytes, &n));
        GP_TRY(take(log, bytes, n, to, "rgb", total));
        GP_TRY(pack_map(&k, picture->relative, level, to, "relative", total));
        GP_TRY(pack_map(&k, picture->flip, level, to, "flip", total));
    }
out:
    gp_free(k.row);
    return st;
}

// -- a plan that fits --------------------------------------------------------------

/* Finds the pixel to keep, or where codes of green differ most; the middle where
 * they are all equal. */
static void find_middle(const struct gp_page_set *s, int *x, int *y)
{
    const int w = gp_rect_w(s->window), h = gp_rect_h(s->window);
    int most = 0;
    *x = s->keep.x0;
    *y = s->keep.y0;
    if (!gp_rect_empty(s->keep))
        return;
    *x = w / 2;
    *y = h / 2;
    for (int i = 1; i < s->n; i++) {
        const uint16_t *const a = s->picture[0].half[1];
        const uint16_t *const b = s->picture[i].half[1];
        for (int at = 0; at < w * h; at++) {
            const int d = abs((int16_t) a[at] - (int16_t) b[at]);
            *x = d > most ? at % w : *x;
            *y = d > most ? at / w : *y;
            most = gp_max(most, d);
        }
    }
}

/* Adds a region to the plan of averages that takes `used`: as wide as the picture
 * is, around a pixel. */
static gp_status fill(const struct gp_log *log, const struct gp_page_set *s,
                      size_t bytes, size_t used, struct plan *p)
{
    const int w = gp_rect_w(s->window), h = gp_rect_h(s->window);
    const struct plan averages = *p;
    int x, y;
    size_t total = bytes + 1;
    gp_status st = GP_OK;
    double pixels = 0.8 * ((double) bytes - (double) used) * (double) p->n /
                    (double) gp_max((int) used, 1);
    find_middle(s, &x, &y);
    for (int i = 0; i < 6 && total > bytes && pixels >= LEAST && !st; i++) {
        const int rh = gp_clamp_whole(sqrt(pixels * h / w), 1, h);
        const int rw = gp_clamp_whole(pixels / rh, 1, w);
        const int x0 = gp_min(gp_max(x - rw / 2, 0), w - rw);
        const int y0 = gp_min(gp_max(y - rh / 2, 0), h - rh);
        p->region = (struct gp_rect) {x0, y0, x0 + rw, y0 + rh};
        p->n = averages.n + gp_rect_pixels(p->region);
        st = pack_all(log, s, p, FAST, &total);
        pixels *= 0.9 * ((double) bytes - (double) used) /
                  fmax((double) total - (double) used, 1.0);
    }
    if (total > bytes)
        *p = averages;
    return st;
}

gp_status gp_page_pack(const struct gp_log *log, const struct gp_page_set *s,
                       size_t bytes, json_t **out)
{
    const double w = gp_rect_w(s->window), h = gp_rect_h(s->window);
    const double raw = w * h * 6.0 * s->n, wanted = 0.6 * (double) bytes;
    json_t *const list = json_array();
    size_t total;
    gp_status st;
    // (no picture is packed to less than a 20th, but for flat ones)
    struct plan p =
        plan_of(s, gp_clamp_whole(ceil(sqrt(raw / (20.0 * (double) bytes))), 1,
                                  1 << 20));
    GP_TRY(pack_all(log, s, &p, FAST, &total));
    while ((double) total > (p.scale == 1 ? (double) bytes : wanted) &&
           p.n > 1) {
        p = plan_of(s, gp_max(p.scale + 1,
                              gp_clamp_whole(
                                  p.scale * sqrt(0.8 * (double) total / wanted),
                                  1, 1 << 20)));
        GP_TRY(pack_all(log, s, &p, FAST, &total));
    }
    if (p.scale > 1 && total < bytes)
        GP_TRY(fill(log, s, bytes, total, &p));
    GP_TRY(pack_all(log, s, &p, SMALL, &total));
    for (int i = 0; i < s->n; i++)
        json_array_append(list, s->picture[i].about);
    *out = json_pack("{si si si si si sI s[iiii] sO}", "x", s->window.x0, "y",
                     s->window.y0, "w", (int) w, "h", (int) h, "scale", p.scale,
                     "bytes", (json_int_t) total, "region", p.region.x0,
                     p.region.y0, gp_rect_w(p.region), gp_rect_h(p.region),
                     "pictures", list);
out:
    json_decref(list);
    return st;
}

gp_status gp_page_thumb(const struct gp_log *log, const struct gp_page_set *s,
                        int i, int side, json_t **out)
{
    const int longer = gp_max(gp_rect_w(s->window), gp_rect_h(s->window));
    const struct plan p = plan_of(s, (longer + side - 1) / side);
    struct coder k;
    void *bytes = NULL;
    size_t n = 0;
    gp_status st;
    GP_TRY(begin_coder(log, s, &p, &k));
    float *const v = (float *) (void *) k.base;
    for (size_t c = 0; c < 3; c++) {
        average(s, &p, s->picture[i].half[c], k.row, k.plane);
        gp_half_to_float(k.plane, v, p.n);
        for (size_t at = 0; at < p.n; at++)
            k.out[3 * at + c] =
                (uint8_t) lrintf(255.0f * gp_srgb_encode(gp_clamp01(v[at])));
    }
    GP_TRY(gp_zlib_pack(log, k.out, 3 * p.n, SMALL, &bytes, &n));
    *out = json_pack("{si si so}", "w", p.w, "h", p.h, "rgb", base64(bytes, n));
    st = *out ? GP_OK : gp_no_memory_bare(log, "page");
out:
    gp_free(bytes);
    gp_free(k.row);
    return st;
}

// -- the page -------------------------------------------------------------------

size_t gp_page_room(const struct gp_settings *s, int pictures)
{
    // names and figures of a picture take up to about this
    static const double TEXT = 4096.0, LEAST = 1024.0;
    const double page =
        (double) strlen(gp_page_before) + (double) strlen(gp_page_after);
    const double pairs =
        gp_option_given(s, "html-size") ? 1.0 : fmax(pictures / 2.0, 1.0);
    const double room =
        1e6 * s->page.megabytes * pairs - page - TEXT * pictures;
    return (size_t) (room > LEAST ? room : LEAST);
}

gp_status gp_page_make(const struct gp_log *log, const struct gp_settings *s,
                       const char *kind, const char *title, json_t **out)
{
    const struct gp_texts *const in = &s->input.files;
    char *command = NULL;
    const gp_status st =
        gp_command_text(log, s, in->at, in->n, GP_COMMAND_ALL, &command);
    if (!st)
        *out = json_pack("{ss so ss so so}", "kind", kind, "title",
                         gp_json_name(title), "version", GP_VERSION, "command",
                         gp_json_name(command), "entries", json_array());
    free(command);
    return st;
}

gp_status gp_page_save(const struct gp_log *log, const struct gp_settings *s,
                       const char *path, json_t *page)
{
    char *const text =
        gp_json_print(page, JSON_COMPACT | JSON_REAL_PRECISION(9));
    static const char less[] = "\\u003c";
    struct gp_file *f = NULL;
    gp_status st = text ? GP_OK : gp_no_memory(log, path);
    GP_TRY(st);
    GP_TRY(gp_file_open(log, path, false, false, &f));
    GP_TRY(gp_file_write(f, gp_page_before, strlen(gp_page_before)));
    // JSON in a script element: no "<" may end it, or begin another
    for (const char *at = text; *at; at += *at == '<') {
        const size_t n = strcspn(at, "<");
        GP_TRY(gp_file_write(f, at, n));
        at += n;
        GP_TRY(gp_file_write(f, less, *at ? sizeof less - 1 : 0));
    }
    GP_TRY(gp_file_write(f, gp_page_after, strlen(gp_page_after)));
    st = gp_file_commit(&f);
    const double size = 1e-6 * (double) (strlen(gp_page_before) + strlen(text) +
                                         strlen(gp_page_after));
    if (!st && gp_option_given(s, "html-size") && size > s->page.megabytes)
        gp_say(log, GP_LEVEL_WARN,
               "%s: %.2g MB, over --html-size, by names and figures; make a "
               "page of fewer frames",
               path, size);
out:
    gp_file_discard(&f);
    free(text);
    return st;
}
