#include "app/compare_report.h"

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
    const struct gp_compare_figures *const f = r->figures;
    printf("%g", f->max);
    if (f->max > 0.0)
        printf(" @ (%d, %d, %s)", f->x, f->y,
               gp_printable(gp_compare_name(r->match, f->channel)).text);
}

/* The values of all channels of an image at the largest error. */
static void print_values(const struct gp_compare_row *r, bool of_b, const char *before)
{
    for (int i = 0; i < r->match->pairs; i++) {
        const struct gp_compare_pair *const p = &r->match->pair[i];
        if (!(of_b ? p->b : p->a))
            continue;
        printf("%s%g", before, gp_compare_value(r->match, of_b, i,
                                                r->figures->x, r->figures->y));
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
    const struct gp_compare_figures *const f = r->figures;
    if (r->why) {
        printf("  %s%s\n", r->parts > 1 ? "parts: " : "",
               gp_printable(r->why).text);
        return;
    }
    const struct gp_compare_match *const m = r->match;
    const struct gp_rect a = m->a->data, b = m->b->data;
    if (s->all_parts && r->parts > 1)
        printf("Subimage %d : ", r->part);
    if (s->all_parts)
        printf("%d x %d, %d channels\n", gp_rect_w(a), gp_rect_h(a),
               m->a->channels);
    printf("  Mean error = %g\n  RMS error = %g\n  Peak SNR = %g\n"
           "  Max error  = ", f->mean, f->rms, f->psnr);
    print_worst(r);
    if (f->max > 0.0 && !m->a->deep) {
        print_values(r, false, "  values are ");
        print_values(r, true, " vs ");
    }
    putchar('\n');
    print_count(f->warned, f->pixels, (double) s->limits.warn);
    print_count(f->failed, f->pixels, (double) s->limits.fail);
    if (s->perceptual)
        printf("  %lld pixels (%3g%%) failed the perceptual test\n", f->seen,
               100.0 * (double) f->seen / (double) f->pixels);
    printf("  rel_l2 = %g\n", f->rel_l2);
    if (!isnan(f->max_rel))
        printf("  max_rel = %g\n", f->max_rel);
    if (r->flip->known)
        printf("  %s = %.6f", r->flip->hdr ? "HDR-FLIP" : "LDR-FLIP",
               r->flip->mean);
    if (r->flip->known && r->flip->hdr)
        printf(" (exposures %.4g to %.4g EV, %d)",
               (double) r->flip->exposures.start,
               (double) r->flip->exposures.stop, r->flip->exposures.count);
    if (r->flip->known)
        putchar('\n');
    if (f->uneven)
        printf("  %lld pixels differ in their number of samples, the first at "
               "(%d, %d)\n", f->uneven, f->uneven_x, f->uneven_y);
    if (f->nonfinite)
        printf("  %lld values that are NaN or infinite differ\n",
               f->nonfinite);
    for (int i = 0; i < m->pairs; i++) {
        const struct gp_compare_pair *const at = &m->pair[i];
        const bool both = at->a && at->b;
        if (both && strcmp(at->a->name, at->b->name) == 0)
            continue;
        if (both)
            printf("  channel %s is compared with %s of B, by its number\n",
                   gp_printable(at->a->name).text,
                   gp_printable(at->b->name).text);
        else
            printf("  channel %s is only in %s (0 in the other)\n",
                   gp_printable(gp_compare_name(m, i)).text,
                   at->a ? "A" : "B");
    }
    if (memcmp(&a, &b, sizeof a) != 0)
        printf("  windows %dx%d at (%d, %d) and %dx%d at (%d, %d); 0 "
               "outside\n", gp_rect_w(a), gp_rect_h(a), a.x0, a.y0,
               gp_rect_w(b), gp_rect_h(b), b.x0, b.y0);
}

void gp_compare_print_line(const struct gp_compare_row *r)
{
    const struct gp_compare_figures *const f = r->figures;
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
    if (r->flip->known)
        printf(", FLIP %.6f", r->flip->mean);
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
    const struct gp_compare_figures *const f = r->figures;
    const struct gp_compare_flip *const flip = r->flip;
    const struct gp_flip_exposures *const e = &flip->exposures;
    json_t *const worst = !(f->max > 0.0) ? NULL : json_pack(
        "{si si so so so}", "x", f->x, "y", f->y,
        "channel", gp_json_name(gp_compare_name(r->match, f->channel)),
        "a", make_real(f->worst_a), "b", make_real(f->worst_b));
    json_t *const figures = json_pack(
        "{so so* so so so so so* so* ss* so* sI sI sI so* so* sI}",
        "max", make_real(f->max), "worst", worst, "mean", make_real(f->mean),
        "rms", make_real(f->rms), "psnr", make_real(f->psnr),
        "rel_l2", make_real(f->rel_l2),
        "max_rel", isnan(f->max_rel) ? NULL : make_real(f->max_rel),
        "flip", flip->known ? make_real(flip->mean) : NULL,
        "flip_kind", !flip->known ? NULL : flip->hdr ? "hdr" : "ldr",
        "flip_exposures", !flip->known || !flip->hdr ? NULL : json_pack("[ffi]",
            (double) e->start, (double) e->stop, e->count),
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

gp_status gp_compare_draw_flip(
    const struct gp_log *log, const struct gp_write_params *write,
    const char *path, const struct gp_compare_row *r)
{
    struct gp_frame frame = gp_frame_blank(r->match->window);
    struct gp_write_params plain = *write;
    struct gp_write_stats stats = {0};
    const size_t pixels = gp_frame_pixels(&frame);
    gp_status st;
    frame.path = gp_strdup(path);
    if (!frame.path)
        return gp_no_memory(log, path);
    GP_TRY(gp_planes_make(log, "heatmap", pixels, &frame.shown));
    gp_compare_heatmap(r->flip->map, pixels, &frame.shown);
    plain.dither = GP_DITHER_NEVER; // each pixel is a number
    GP_TRY(gp_write_picture(log, &plain, path, &frame, &frame.shown,
                            GP_PICTURE_SHOWN, &stats));
out:
    gp_frame_free(&frame);
    return st;
}

/* The channels of the pairs in `f`, in the order of their names, all but its
 * colour with their samples. */
static gp_status make_channels(const struct gp_log *log,
    const struct gp_compare_settings *s, const struct gp_compare_match *m,
    const int colour[3], struct gp_frame *f)
{
    const size_t pixels = gp_frame_pixels(f);
    gp_status st = gp_alloc_zero(log, "channels", (size_t) m->pairs,
                                 sizeof *f->channel, &f->channel);
    for (int i = 0; i < m->pairs && !st; i++) {
        struct gp_channel *const c = &f->channel[f->channels++];
        *c = (struct gp_channel) {
            .name = gp_strdup(gp_compare_name(m, i)), .type = GP_FLOAT,
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
            gp_compare_subtract(m, i, s->absolute, s->scale, c->data);
    }
    return st;
}

gp_status gp_compare_draw_difference(
    const struct gp_log *log, const struct gp_write_params *write,
    const char *path, const struct gp_compare_row *r,
    const struct gp_compare_settings *s)
{
    const struct gp_compare_match *const m = r->match;
    static const char *const name[3] = {"R", "G", "B"};
    struct gp_write_params as = *write;
    struct gp_write_stats stats = {0};
    struct gp_frame f = gp_frame_blank(m->window);
    const size_t pixels = gp_frame_pixels(&f);
    int colour[3] = {-1, -1, -1};
    char ending[8];
    gp_status st;
    memcpy(f.chromaticities, m->a->chromaticities, sizeof f.chromaticities);
    memcpy(f.luminance, m->a->luminance, sizeof f.luminance);
    f.path = gp_strdup(path);
    if (!f.path)
        return gp_no_memory(log, path);
    for (int i = 0; i < m->pairs; i++) {
        for (int k = 0; k < 3; k++)
            colour[k] = strcmp(gp_compare_name(m, i), name[k]) == 0 ? i
                                                                    : colour[k];
    }
    if (colour[0] < 0 && colour[1] < 0 && colour[2] < 0) { // the first is grey
        f.model = GP_COLOUR_GREY;
        colour[0] = colour[1] = colour[2] = 0;
    }
    GP_TRY(gp_planes_make(log, "difference", pixels, &f.rgb));
    for (int k = 0; k < 3; k++) {
        if (colour[k] >= 0)
            gp_compare_subtract(m, colour[k], s->absolute, s->scale,
                                f.rgb.c[k]);
        else
            memset(f.rgb.c[k], 0, pixels * sizeof(float));
    }
    as.type = GP_OUT_FLOAT;
    as.dither = GP_DITHER_NEVER; // equal values become equal codes
    gp_file_ending(path, ending, sizeof ending);
    if (strcmp(ending, "exr") == 0) {
        f.display = m->a->display;
        GP_TRY(make_channels(log, s, m, colour, &f));
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
