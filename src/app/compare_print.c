#include "app/compare_print.h"

#include "core/json.h"
#include "core/memory.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *gp_compare_word(enum gp_compare_result r)
{
    static const char *const word[] = {
        [GP_COMPARE_MATCH] = "match", [GP_COMPARE_WARNING] = "warning",
        [GP_COMPARE_FAILURE] = "failure", [GP_COMPARE_DIFFERENT] = "different",
        [GP_COMPARE_FILE] = "file error",
    };
    return word[r];
}

// -- text --------------------------------------------------------------------

static double percent(const struct gp_compare_figures *f, long long n)
{
    return 100.0 * (double) n / (double) f->pixels;
}

static void print_worst(const struct gp_compare_row *r, FILE *to)
{
    const struct gp_compare_figures *const f = r->figures;
    fprintf(to, "%g", f->max);
    if (f->max > 0.0)
        fprintf(to, " @ (%d, %d, %s): %.9g vs %.9g", f->x, f->y,
                gp_compare_name(r->match, f->channel), f->worst_a,
                f->worst_b);
}

/* Channels and windows, where the two differ. */
static void print_layout(const struct gp_compare_match *m, FILE *to)
{
    const struct gp_rect a = m->a->data, b = m->b->data;
    for (int i = 0; i < m->pairs; i++) {
        const struct gp_compare_pair *const p = &m->pair[i];
        if (!p->a || !p->b)
            fprintf(to, "  only in %s    %s (0 in the other)\n",
                    p->a ? "A" : "B", gp_compare_name(m, i));
    }
    if (memcmp(&a, &b, sizeof a) != 0)
        fprintf(to, "  windows      %dx%d at (%d, %d) and %dx%d at (%d, %d); "
                "0 outside\n", gp_rect_w(a), gp_rect_h(a), a.x0, a.y0,
                gp_rect_w(b), gp_rect_h(b), b.x0, b.y0);
}

static void print_flip(const struct gp_compare_flip *f, FILE *to)
{
    if (!f->known)
        return;
    fprintf(to, "  %s     %.6f", f->hdr ? "HDR-FLIP" : "LDR-FLIP", f->mean);
    if (f->hdr)
        fprintf(to, " (exposures %.4g to %.4g EV, %d)",
                (double) f->exposures.start, (double) f->exposures.stop,
                f->exposures.count);
    fputc('\n', to);
}

void gp_compare_print(const struct gp_compare_row *r, FILE *to)
{
    const struct gp_compare_figures *const f = r->figures;
    fprintf(to, "%s and %s", r->a, r->b);
    if (r->parts > 1)
        fprintf(to, ", part %d", r->part);
    fprintf(to, ": %s\n", gp_compare_word(r->result));
    if (r->why) {
        fprintf(to, "  %s\n", r->why);
        return;
    }
    print_layout(r->match, to);
    fprintf(to, "  max error    ");
    print_worst(r, to);
    fprintf(to, "\n  mean error   %g\n  RMS error    %g\n"
            "  PSNR         %g dB\n  rel_l2       %g\n", f->mean, f->rms,
            f->psnr, f->rel_l2);
    if (!isnan(f->max_rel))
        fprintf(to, "  max_rel      %g\n", f->max_rel);
    print_flip(r->flip, to);
    if (f->nonfinite)
        fprintf(to, "  not finite   %lld values differ\n", f->nonfinite);
    fprintf(to, "  over %-7g %lld pixels (%.3g%%) fail\n",
            (double) r->limits->fail, f->failed, percent(f, f->failed));
    fprintf(to, "  over %-7g %lld pixels (%.3g%%) warn\n",
            (double) r->limits->warn, f->warned, percent(f, f->warned));
}

void gp_compare_print_line(const struct gp_compare_row *r, FILE *to)
{
    const struct gp_compare_figures *const f = r->figures;
    if (r->numbered)
        fprintf(to, "%d", r->frame);
    else
        fprintf(to, "%s", r->a);
    if (r->parts > 1)
        fprintf(to, ", part %d", r->part);
    fprintf(to, ": %s", gp_compare_word(r->result));
    if (r->why) {
        fprintf(to, "; %s\n", r->why);
        return;
    }
    fprintf(to, "; max ");
    print_worst(r, to);
    fprintf(to, "; mean %g, RMS %g, PSNR %g, rel_l2 %g", f->mean, f->rms,
            f->psnr, f->rel_l2);
    if (r->flip->known)
        fprintf(to, ", FLIP %.6f", r->flip->mean);
    fputc('\n', to);
}

// -- JSON --------------------------------------------------------------------

static void put(json_t *o, const char *key, double v)
{
    json_object_set_new(o, key, isfinite(v) ? json_real(v) : json_null());
}

static void put_count(json_t *o, const char *key, long long n)
{
    json_object_set_new(o, key, json_integer((json_int_t) n));
}

static json_t *worst(const struct gp_compare_row *r)
{
    const struct gp_compare_figures *const f = r->figures;
    json_t *const o = json_object();
    put_count(o, "x", f->x);
    put_count(o, "y", f->y);
    json_object_set_new(o, "channel",
                        gp_json_name(gp_compare_name(r->match, f->channel)));
    put(o, "a", f->worst_a);
    put(o, "b", f->worst_b);
    return o;
}

static void put_figures(json_t *o, const struct gp_compare_row *r)
{
    const struct gp_compare_figures *const f = r->figures;
    put(o, "max", f->max);
    if (f->max > 0.0)
        json_object_set_new(o, "worst", worst(r));
    put(o, "mean", f->mean);
    put(o, "rms", f->rms);
    put(o, "psnr", f->psnr);
    put(o, "rel_l2", f->rel_l2);
    if (!isnan(f->max_rel))
        put(o, "max_rel", f->max_rel);
    if (r->flip->known) {
        put(o, "flip", r->flip->mean);
        json_object_set_new(o, "flip_kind",
                            json_string(r->flip->hdr ? "hdr" : "ldr"));
    }
    if (r->flip->known && r->flip->hdr) {
        const struct gp_flip_exposures *const e = &r->flip->exposures;
        json_object_set_new(o, "flip_exposures",
                            json_pack("[ffi]", (double) e->start,
                                      (double) e->stop, e->count));
    }
    put_count(o, "nonfinite", f->nonfinite);
    put_count(o, "failed", f->failed);
    put_count(o, "warned", f->warned);
    put_count(o, "pixels", f->pixels);
}

bool gp_compare_json(const struct gp_compare_row *r, FILE *to)
{
    json_t *const o = json_object();
    json_object_set_new(o, "a", gp_json_name(r->a));
    json_object_set_new(o, "b", gp_json_name(r->b));
    if (r->numbered)
        put_count(o, "frame", r->frame);
    if (r->parts > 1)
        put_count(o, "part", r->part);
    json_object_set_new(o, "result", json_string(gp_compare_word(r->result)));
    put_count(o, "status", r->result);
    if (r->why)
        json_object_set_new(o, "why", gp_json_name(r->why));
    else
        put_figures(o, r);
    char *const text = gp_json_print(o, JSON_COMPACT | JSON_REAL_PRECISION(9));
    const bool whole = text && fprintf(to, "%s\n", text) > 0;
    free(text);
    return whole;
}
