// SPDX-License-Identifier: Apache-2.0
/* The kernel's spectrum: made with a frame, kept for more. */
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/fft/fft.h"

#include <string.h>

/* A kernel's rows on the torus. */
struct making {
    const struct gp_kernel *kernel;
    const struct gp_fft_placing *p;
    int first; // offset of row 0
};

/* Row of offset dy = first + j, each sample at its offset modulo nx. */
static void load_kernel_row(const void *ctx, int c, int j, float *z)
{
    const struct making *const r = ctx;
    const struct gp_kernel *const k = r->kernel;
    const struct gp_rect taps = r->p->taps;
    const int dy = r->first + j, nx = r->p->nx;
    const float *const row =
        k->k.c[c] + (size_t) (dy + k->cy) * (size_t) k->w + k->cx;
    for (int from = taps.x0, end; from < taps.x1; from = end) {
        const int at = gp_fft_wrap(from, nx);
        end = gp_min(taps.x1, from + nx - at);
        memcpy(z + at, row + from, (size_t) (end - from) * sizeof *z);
    }
    if (dy == 0 && taps.x0 <= 0 && taps.x1 > 0)
        z[0] = 0.0f; // the centre
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

void gp_fft_spectrum_free(struct gp_fft_spectrum *s)
{
    gp_fft_matrix_free(&s->m);
    *s = (struct gp_fft_spectrum) {0};
}

gp_status gp_fft_find_spectrum(const struct gp_glare_request *req,
                               const struct gp_fft_request *fft,
                               const struct gp_fft_placing *p,
                               struct gp_fft_spectrum *s)
{
    gp_status st;
    const struct gp_kernel *const k = req->kernel;
    const bool kept = k->serial && (k->grey || !req->params->last);
    if (s->m.z[0] && gp_fft_is_of(s->kernel, k) &&
        s->m.of.in_double == fft->in_double && s->placing.nx == p->nx &&
        s->placing.ny == p->ny &&
        memcmp(&s->placing.taps, &p->taps, sizeof p->taps) == 0 &&
        (s->channel < 0 || s->channel == fft->channel))
        return GP_OK;
    const bool even = is_even(k, &p->taps);
    const int n = even ? p->taps.y1 : gp_rect_h(p->taps);
    const struct making from = {k, p, even ? 0 : p->taps.y0};
    struct gp_fft_request planes = *fft;
    int *places = NULL;
    gp_fft_spectrum_free(s);
    if (kept) {
        planes.channel = 0;
        planes.channels = k->grey ? 1 : 3;
    }
    GP_TRY(gp_fft_matrix_make(req->log,
                              (struct gp_fft_numbers) {even, fft->in_double},
                              planes.channels, p->nx, p->ny, &s->m));
    GP_TRY(
        gp_alloc(req->log, "transform", (size_t) n, sizeof *places, &places));
    for (int j = 0; j < n; j++)
        places[j] = gp_fft_wrap(from.first + j, p->ny);
    struct gp_fft_matrix m =
        kept ? s->m : gp_fft_one_channel(&s->m, fft->channel);
    GP_TRY(gp_fft_rows_in(&planes, n, load_kernel_row, &from, &m));
    // two factors 1/2 were left out on the way in: the kernel's rows, the
    // sources' rows
    GP_TRY(gp_fft_make_kernel(&planes, (struct gp_fft_rows) {n, places},
                              0.25 / ((double) p->nx * p->ny), &m));
    s->kernel = k->serial;
    s->placing = *p;
    s->channel = kept ? -1 : fft->channel;
out:
    gp_free(places);
    if (st)
        gp_fft_spectrum_free(s);
    return st;
}
