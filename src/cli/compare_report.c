#include "cli/compare_report.h"

#include "core/json.h"
#include "core/memory.h"
#include "io/file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// -- text --------------------------------------------------------------------

const char *gp_compare_word(int result)
{
    static const char *const word[] = {
        [GP_COMPARE_MATCH] = "match", [GP_COMPARE_WARNING] = "warning",
        [GP_COMPARE_FAILURE] = "failure", [GP_COMPARE_DIFFERENT] = "different",
        [GP_COMPARE_FILE] = "file error",
    };
    return word[result];
}

static void print_worst(const struct gp_compare_row *r)
{
    const struct glarepp_compare_facts *const f = r->facts;
    printf("%g", f->max);
    if (f->max > 0.0)
        printf(" @ (%d, %d, %s)", f->x, f->y,
               gp_printable(f->pair[f->channel]).text);
}

/* The channel of a pair in file k, or NULL. */
static const struct gp_stored_channel *channel_of(const struct gp_compare_row *r,
                                                  int k, int pair)
{
    const int i = (k ? r->facts->in_b : r->facts->in_a)[pair];
    return i < 0 ? NULL : &r->image[k]->channel[i];
}

/* The values of all channels of file k at the largest error; 0 outside. */
static void print_values(const struct gp_compare_row *r, int k,
                         const char *before)
{
    const struct gp_rect d = r->image[k]->data;
    const int x = r->facts->x, y = r->facts->y;
    const bool inside = x >= d.x0 && x < d.x1 && y >= d.y0 && y < d.y1;
    const long long at = (long long) (y - d.y0) * gp_rect_w(d) + (x - d.x0);
    for (int i = 0; i < r->facts->pairs; i++) {
        const struct gp_stored_channel *const c = channel_of(r, k, i);
        if (!c)
            continue;
        printf("%s%g", before,
               !inside      ? 0.0
               : c->is_uint ? (double) ((const uint32_t *) c->v)[at]
                            : (double) ((const float *) c->v)[at]);
        before = ", ";
    }
}

static void print_count(long long n, long long of, double limit)
{
    printf("  %lld pixels (%.3g%%) over %g\n", n,
           100.0 * (double) n / (double) of, limit);
}

void gp_compare_print(const struct gp_compare_row *r,
                      const struct gp_compare_settings *s)
{
    const struct glarepp_compare_facts *const f = r->facts;
    if (r->why) {
        printf("  %s%s\n", r->parts > 1 ? "parts: " : "",
               gp_printable(r->why).text);
        return;
    }
    const struct gp_rect a = r->image[0]->data, b = r->image[1]->data;
    if (s->all_parts && r->parts > 1)
        printf("Subimage %d : ", r->part);
    if (s->all_parts)
        printf("%d x %d, %d channels\n", gp_rect_w(a), gp_rect_h(a),
               r->image[0]->channels);
    printf("  Mean error = %g\n  RMS error = %g\n  Peak SNR = %g\n"
           "  Max error  = ", f->mean, f->rms, f->psnr);
    print_worst(r);
    if (f->max > 0.0 && !r->image[0]->deep) {
        print_values(r, 0, "  values are ");
        print_values(r, 1, " vs ");
    }
    putchar('\n');
    print_count(f->warned, f->pixels, (double) s->limits.warn);
    print_count(f->failed, f->pixels, (double) s->limits.fail);
    if (s->limits.perceptual)
        printf("  %lld pixels (%3g%%) failed the perceptual test\n", f->seen,
               100.0 * (double) f->seen / (double) f->pixels);
    printf("  rel_l2 = %g\n", f->rel_l2);
    if (!isnan(f->max_rel))
        printf("  max_rel = %g\n", f->max_rel);
    if (f->has_flip)
        printf("  %s = %.6f", f->hdr ? "HDR-FLIP" : "LDR-FLIP", f->flip);
    if (f->has_flip && f->hdr)
        printf(" (exposures %.4g to %.4g EV, %d)", (double) f->start,
               (double) f->stop, f->exposures);
    if (f->has_flip)
        putchar('\n');
    if (f->uneven)
        printf("  %lld pixels differ in their number of samples, the first at "
               "(%d, %d)\n", f->uneven, f->uneven_x, f->uneven_y);
    if (f->nonfinite)
        printf("  %lld values that are NaN or infinite differ\n",
               f->nonfinite);
    for (int i = 0; i < f->pairs; i++) {
        const struct gp_stored_channel *const in_a = channel_of(r, 0, i);
        const struct gp_stored_channel *const in_b = channel_of(r, 1, i);
        if (in_a && in_b && strcmp(in_a->name, in_b->name) == 0)
            continue;
        if (in_a && in_b)
            printf("  channel %s is compared with %s of B, by its number\n",
                   gp_printable(in_a->name).text,
                   gp_printable(in_b->name).text);
        else
            printf("  channel %s is only in %s (0 in the other)\n",
                   gp_printable(f->pair[i]).text, in_a ? "A" : "B");
    }
    if (memcmp(&a, &b, sizeof a) != 0)
        printf("  windows %dx%d at (%d, %d) and %dx%d at (%d, %d); 0 "
               "outside\n", gp_rect_w(a), gp_rect_h(a), a.x0, a.y0,
               gp_rect_w(b), gp_rect_h(b), b.x0, b.y0);
}

void gp_compare_print_line(const struct gp_compare_row *r)
{
    const struct glarepp_compare_facts *const f = r->facts;
    printf("%d", r->frame);
    if (r->parts > 1)
        printf(", part %d", r->part);
    printf(": %s; ", gp_compare_word(r->result));
    if (r->why) {
        printf("%s\n", gp_printable(r->why).text);
        return;
    }
    printf("max ");
    print_worst(r);
    printf("; mean %g, RMS %g, PSNR %g, rel_l2 %g", f->mean, f->rms, f->psnr,
           f->rel_l2);
    if (f->has_flip)
        printf(", FLIP %.6f", f->flip);
    putchar('\n');
}

// -- JSON --------------------------------------------------------------------

static json_t *make_real(double v)
{
    return isfinite(v) ? json_real(v) : json_null();
}

json_t *gp_compare_json(const struct gp_compare_row *r, bool numbered)
{
    json_t *const o = json_pack("{so so so* so* ss si so*}",
        "a", gp_json_name(r->a), "b", gp_json_name(r->b),
        "frame", numbered ? json_integer(r->frame) : NULL,
        "part", r->parts > 1 ? json_integer(r->part) : NULL,
        "result", gp_compare_word(r->result), "status", r->result,
        "why", r->why ? gp_json_name(r->why) : NULL);
    if (r->why)
        return o;
    const struct glarepp_compare_facts *const f = r->facts;
    json_t *const worst = !(f->max > 0.0) ? NULL : json_pack(
        "{si si so so so}", "x", f->x, "y", f->y,
        "channel", gp_json_name(f->pair[f->channel]),
        "a", make_real(f->worst_a), "b", make_real(f->worst_b));
    json_t *const figures = json_pack(
        "{so so* so so so so so* so* ss* so* sI sI sI so* so* sI}",
        "max", make_real(f->max), "worst", worst, "mean", make_real(f->mean),
        "rms", make_real(f->rms), "psnr", make_real(f->psnr),
        "rel_l2", make_real(f->rel_l2),
        "max_rel", isnan(f->max_rel) ? NULL : make_real(f->max_rel),
        "flip", f->has_flip ? make_real(f->flip) : NULL,
        "flip_kind", !f->has_flip ? NULL : f->hdr ? "hdr" : "ldr",
        "flip_exposures", !f->has_flip || !f->hdr ? NULL : json_pack("[ffi]",
            (double) f->start, (double) f->stop, f->exposures),
        "nonfinite", (json_int_t) f->nonfinite,
        "failed", (json_int_t) f->failed, "warned", (json_int_t) f->warned,
        "uneven", !f->uneven ? NULL : json_pack("{sI si si}", "pixels",
            (json_int_t) f->uneven, "x", f->uneven_x, "y", f->uneven_y),
        "seen", f->seen < 0 ? NULL : json_integer(f->seen),
        "pixels", (json_int_t) f->pixels);
    json_object_update(o, figures);
    json_decref(figures);
    return o;
}

// -- pictures ----------------------------------------------------------------

/* Returns a frame of the window under the name of its file.
 * Errors: GP_ERR_BUG. */
static gp_status blank_frame(const struct gp_log *log, const char *path,
                             const struct gp_compare_row *r, struct gp_frame *f)
{
    const struct glarepp_rect w = r->facts->window;
    *f = gp_frame_blank((struct gp_rect) {w.x0, w.y0, w.x1, w.y1});
    f->path = gp_strdup(path);
    return f->path ? GP_OK : gp_no_memory(log, path);
}

gp_status gp_compare_draw_flip(
    const struct gp_log *log, const struct gp_write_params *write,
    const char *path, const struct gp_compare_row *r)
{
    struct glarepp_image map = GLAREPP_IMAGE;
    struct gp_write_params plain = *write;
    struct gp_write_stats stats = {0};
    struct gp_frame f;
    gp_status st;
    GP_TRY(blank_frame(log, path, r, &f));
    GP_TRY(glarepp_compare_view(r->compare, -1, false, 1.0f, &map));
    const struct gp_planes shown = {{map.plane[0], map.plane[1], map.plane[2]}};
    plain.dither = GP_DITHER_NEVER; // each pixel is a number
    GP_TRY(gp_write_picture(log, &plain, path, &f, &shown, GP_PICTURE_SHOWN,
                            &stats));
out:
    glarepp_image_end(&map);
    gp_frame_free(&f);
    return st;
}

/* Copies the difference of a pair. */
static gp_status subtract(const struct gp_compare_row *r,
    const struct gp_compare_settings *s, int pair, size_t pixels, float *to)
{
    struct glarepp_image d;
    const gp_status st = (gp_status) glarepp_compare_view(r->compare, pair, s->absolute,
                                              s->scale, &d);
    if (!st)
        memcpy(to, d.plane[0], pixels * sizeof *to);
    glarepp_image_end(&d);
    return st;
}

/* The channels of the pairs in `f`, in the order of their names, all but its
 * colour with their samples. */
static gp_status make_channels(const struct gp_log *log,
    const struct gp_compare_settings *s, const struct gp_compare_row *r,
    const int colour[3], struct gp_frame *f)
{
    const int pairs = r->facts->pairs;
    const size_t pixels = gp_frame_pixels(f);
    gp_status st = gp_alloc_zero(log, "channels", (size_t) pairs,
                                 sizeof *f->channel, &f->channel);
    for (int i = 0; i < pairs && !st; i++) {
        struct gp_channel *const c = &f->channel[f->channels++];
        *c = (struct gp_channel) {
            .name = gp_strdup(r->facts->pair[i]), .type = GP_FLOAT,
            .xs = 1, .ys = 1, .w = gp_frame_w(f), .h = gp_frame_h(f),
            .colour = -1,
        };
        for (int k = 2; k >= 0; k--)
            c->colour = colour[k] == i ? k : c->colour;
        if (!c->name)
            return gp_no_memory(log, f->path);
        if (c->colour >= 0)
            continue;
        st = gp_alloc(log, c->name, pixels, sizeof(float), &c->data);
        if (!st)
            st = subtract(r, s, i, pixels, c->data);
    }
    return st;
}

gp_status gp_compare_draw_difference(
    const struct gp_log *log, const struct gp_write_params *write,
    const char *path, const struct gp_compare_row *r,
    const struct gp_compare_settings *s)
{
    static const char *const name[3] = {"R", "G", "B"};
    const struct gp_stored_image *const a = r->image[0];
    struct gp_write_params as = *write;
    struct gp_write_stats stats = {0};
    struct gp_frame f;
    int colour[3] = {-1, -1, -1};
    char ending[8];
    gp_status st;
    GP_TRY(blank_frame(log, path, r, &f));
    memcpy(f.chromaticities, a->chromaticities, sizeof f.chromaticities);
    memcpy(f.luminance, a->luminance, sizeof f.luminance);
    for (int i = 0; i < r->facts->pairs; i++) {
        for (int k = 0; k < 3; k++)
            colour[k] = strcmp(r->facts->pair[i], name[k]) == 0 ? i : colour[k];
    }
    if (colour[0] < 0 && colour[1] < 0 && colour[2] < 0) { // the first is grey
        f.model = GP_COLOUR_GREY;
        colour[0] = colour[1] = colour[2] = 0;
    }
    const size_t pixels = gp_frame_pixels(&f);
    GP_TRY(gp_planes_make(log, "difference", pixels, &f.rgb));
    for (int k = 0; k < 3; k++) {
        if (colour[k] >= 0)
            GP_TRY(subtract(r, s, colour[k], pixels, f.rgb.c[k]));
        else
            memset(f.rgb.c[k], 0, pixels * sizeof(float));
    }
    as.type = GP_OUT_FLOAT;
    as.dither = GP_DITHER_NEVER; // equal values become equal codes
    gp_file_ending(path, ending, sizeof ending);
    if (strcmp(ending, "exr") == 0) {
        f.display = a->display;
        GP_TRY(make_channels(log, s, r, colour, &f));
        GP_TRY(gp_write_hdr(log, &as, path,
                            &(struct gp_hdr_colour) {&f, &f.rgb}, 1, &stats));
    } else {
        GP_TRY(gp_write_picture(log, &as, path, &f, &f.rgb, GP_PICTURE_ENCODED,
                                &stats));
    }
out:
    gp_frame_free(&f);
    return st;
}
