// SPDX-License-Identifier: Apache-2.0
/* The kernel's spectrum, less its core: made with a frame, kept for more. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/fft/fft_priv.h"

#include <stdlib.h>
#include <string.h>

typedef float vf __attribute__((vector_size(32)));
typedef vf vf_loose __attribute__((aligned(4), may_alias));

/* Writes n samples to every second float of z; the 2 n floats from z on exist,
 * and those between keep their values. */
GP_CLONES static void spread_row(const float *restrict row, int n,
                                 float *restrict z)
{
    enum { LANES = 8 };
    int x = 0;
    for (; x + LANES <= n; x += LANES) {
        const vf v = *(const vf_loose *) (row + x);
        vf_loose *const to = (vf_loose *) (z + 2 * x);
        const vf a = to[0], b = to[1];
        to[0] = __builtin_shufflevector(v, a, 0, 9, 1, 11, 2, 13, 3, 15);
        to[1] = __builtin_shufflevector(v, b, 4, 9, 5, 11, 6, 13, 7, 15);
    }
    for (; x < n; x++)
        z[2 * x] = row[x];
}

/* Row of offset dy = first + j, each sample at its offset modulo nx. */
static void load_kernel_row(const void *ctx, int c, int j, float *z)
{
    const struct gp_fft_making *const r = ctx;
    enum { LINE = 16 }; // samples of a cache line
    const struct gp_kernel *const k = r->kernel;
    const struct gp_rect taps = r->p->taps;
    const int dy = r->first + j, nx = r->p->nx;
    const float *const row =
        k->k.c[c] + (size_t) (dy + k->cy) * (size_t) k->w + k->cx;
    for (int from = taps.x0, end; from < taps.x1; from = end) {
        const int at = gp_fft_wrap(from, nx);
        end = gp_min(taps.x1, from + nx - at);
        for (int x = from; x < end && dy + 2 < taps.y1; x += LINE)
            __builtin_prefetch(row + 2 * k->w + x); // while these are transformed
        spread_row(row + from, end - from, z + 2 * at);
    }
    if (abs(dy) > r->core.y)
        return;
    for (int dx = gp_max(-r->core.x, taps.x0);
         dx <= r->core.x && dx < taps.x1; dx++)
        z[2 * gp_fft_wrap(dx, nx)] = 0.0f;
}

/* Tests whether a kernel is even about its centre, and all of it is in
 * `taps`. */
static bool is_even(const struct gp_kernel *k, const struct gp_rect *taps)
{
    if (taps->x0 != 1 - taps->x1 || taps->y0 != 1 - taps->y1)
        return false;
    for (int c = 0; c < (k->grey ? 1 : 3); c++) {
        const float *const centre =
            k->k.c[c] + (size_t) k->cy * (size_t) k->w + k->cx;
        for (int y = 0; y < taps->y1; y++) {
            const float *const low = centre + (ptrdiff_t) y * k->w;
            const float *const high = centre - (ptrdiff_t) y * k->w;
            int differ = 0;
            for (int x = taps->x0; x < taps->x1; x++)
                differ |= low[x] != high[-x];
            if (differ)
                return false;
        }
    }
    return true;
}

void gp_fft_making_free(struct gp_fft_making *m)
{
    if (!m->lent)
        gp_fft_matrix_free(&m->rows);
    gp_free(m->places);
    *m = (struct gp_fft_making) {0};
}

/* Makes room for `n` rows of nx numbers: the layer's last plane, which is
 * written after the last kernel is made, where it is large enough. */
static gp_status make_kernel_rows(const struct gp_glare_request *req, int nx,
    int n, bool in_double, struct gp_fft_making *m)
{
    const struct gp_fft_numbers of = {.in_double = in_double};
    const size_t plane = (size_t) req->src->w * (size_t) req->src->h;
    m->lent = gp_fft_matrix_bytes(of, nx, n) <= plane * sizeof(float);
    if (!m->lent)
        return gp_fft_matrix_make_of(req->log, of, 1, nx, n, &m->rows);
    m->rows = gp_fft_matrix_in(req->layer->c[2], of, nx, n);
    return GP_OK;
}

bool gp_fft_has_spectrum(const struct gp_fft_spectrum *s,
    const struct gp_kernel *k, const struct gp_fft_placing *p,
    const struct gp_fft_split *split)
{
    return s->m.z[0] && gp_fft_is_of(s->kernel, k) &&
           gp_fft_same_core(s->core, split->core) &&
           s->in_double == split->in_double &&
           s->placing.nx == p->nx && s->placing.ny == p->ny &&
           memcmp(&s->placing.taps, &p->taps, sizeof p->taps) == 0;
}

bool gp_fft_keeps_spectrum(const struct gp_glare_request *req)
{
    return req->kernel->grey || !req->params->last;
}

gp_status gp_fft_making_open(const struct gp_glare_request *req,
    struct gp_fft_spectrum *s, const struct gp_fft_placing *p,
    const struct gp_fft_split *split, struct gp_fft_making *out)
{
    gp_status st;
    const struct gp_kernel *const k = req->kernel;
    struct gp_fft_making m = {.passes.channels = k->grey ? 1 : 3};
    if (gp_fft_has_spectrum(s, k, p, split)) {
        m.passes.spectrum = s->m;
        *out = m;
        return GP_OK;
    }
    const bool even = is_even(k, &p->taps);
    const int n = even ? p->taps.y1 : gp_rect_h(p->taps);
    const struct gp_fft_numbers of = {even, split->in_double};
    gp_fft_matrix_free(&s->m);
    s->kernel = 0;
    if (gp_fft_keeps_spectrum(req))
        GP_TRY(gp_fft_matrix_make_of(req->log, of, m.passes.channels, p->nx,
                                     p->ny, &s->m));
    GP_TRY(make_kernel_rows(req, p->nx, n, of.in_double, &m));
    GP_TRY(gp_alloc(req->log, "transform", (size_t) n, sizeof *m.places,
                    &m.places));
    for (int j = 0; j < n; j++)
        m.places[j] = gp_fft_wrap(p->taps.y0 + j, p->ny);
    m.kernel = k;
    m.p = p;
    m.core = split->core;
    m.first = even ? 0 : p->taps.y0;
    m.passes.spectrum = s->m;
    m.passes.spectrum.of = of;
    m.passes.n = n;
    m.passes.place = m.places;
    // two factors 1/2 were left out on the way in: the kernel's rows, the
    // sources' rows
    m.passes.scale = 0.25 / ((double) p->nx * p->ny);
    *out = m;
    m = (struct gp_fft_making) {0};
out:
    gp_fft_making_free(&m);
    return st;
}

gp_status gp_fft_making_load(const struct gp_fft_request *fft,
    struct gp_fft_making *m, struct gp_fft_matrix *view)
{
    m->passes.rows = NULL;
    if (!m->rows.z[0] || fft->channel >= m->passes.channels)
        return GP_OK;
    *view = gp_fft_one_channel(&m->rows, 0, fft->channel);
    m->passes.rows = view;
    return gp_fft_rows_in(fft, m->passes.n, load_kernel_row, m, view);
}
