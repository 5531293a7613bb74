#include "core/cpu.h"
#include "core/memory.h"
#include "glare/splat/blur.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The kernel by square rings around its centre: ring d holds the samples
 * with max(|dx|, |dy|) = d, rings first .. first + n - 1 all samples. */
struct rings {
    int first, n;
    float *peak;  // largest magnitude on ring first + i or any beyond
    double *left; // share of the kernel beyond ring first + i, largest channel
    double whole; // the same beyond no ring: 1, or the tail's share
};

/* The light of polygons by bin. */
struct lights {
    double bin[GP_SOURCE_BINS];
    double all;
};

static int farther(int at, int size)
{
    return abs(at) > abs(size - 1 - at) ? abs(at) : abs(size - 1 - at);
}

static int nearest(int at, int size)
{
    return at < 0 ? -at : at >= size ? at - size + 1 : 0;
}

static gp_status make_rings(const struct gp_log *log,
                            const struct gp_kernel *k, struct rings *r)
{
    void *p;
    const int x = nearest(k->cx, k->w), y = nearest(k->cy, k->h);
    const int far_x = farther(k->cx, k->w), far_y = farther(k->cy, k->h);
    r->first = x > y ? x : y;
    r->n = (far_x > far_y ? far_x : far_y) - r->first + 1;
    gp_status st = gp_alloc_zero(log, "shrinking", (size_t) r->n,
                                 sizeof *r->peak, &p);
    if (st)
        return st;
    r->peak = p;
    st = gp_alloc_zero(log, "shrinking", (size_t) r->n, sizeof *r->left, &p);
    r->left = p;
    return st;
}

static void free_rings(struct rings *r)
{
    gp_free(r->peak);
    gp_free(r->left);
}

/* Samples [x0, x1) of a row that lie on one ring. */
GP_CLONES static void add_flat(const float *row, int x0, int x1,
                               double *restrict sum, float *restrict peak)
{
    double total = 0.0;
    float most = *peak;
    for (int x = x0; x < x1; x++) {
        const float v = fabsf(row[x]);
        total += (double) v;
        most = v > most ? v : most;
    }
    *sum += total;
    *peak = most;
}

/* n samples from `from` on, each on the ring after the last one's; `way` is 1
 * to the right, -1 to the left. */
GP_CLONES static void add_outward(const float *from, int way, int n,
                                  double *restrict sum, float *restrict peak)
{
    for (int i = 0; i < n; i++) {
        const float v = fabsf(from[i * way]);
        sum[i] += (double) v;
        peak[i] = v > peak[i] ? v : peak[i];
    }
}

static int clamp(int v, int low, int high)
{
    return v < low ? low : v > high ? high : v;
}

/* Adds channel c to its rings: peaks, and sums of magnitudes in `sum`. */
static void add_channel(const struct gp_kernel *k, int c, bool tail,
                        const struct rings *r, double *sum)
{
    for (int y = 0; y < k->h; y++) {
        const float *const row = k->k.c[c] + (size_t) y * (size_t) k->w;
        const int dy = abs(y - k->cy);
        const bool core = tail && dy <= GP_CORE_RADIUS; // not drawn from here
        const int flat = core ? GP_CORE_RADIUS : dy;
        const int x0 = clamp(k->cx - flat, 0, k->w);
        const int x1 = clamp(k->cx + flat + 1, 0, k->w);
        if (!core && x0 < x1)
            add_flat(row, x0, x1, sum + dy - r->first,
                     r->peak + dy - r->first);
        if (x0 > 0) { // starts on the ring of its rightmost sample
            const int at = k->cx - (x0 - 1) - r->first;
            add_outward(row + x0 - 1, -1, x0, sum + at, r->peak + at);
        }
        if (x1 < k->w) {
            const int at = x1 - k->cx - r->first;
            add_outward(row + x1, 1, k->w - x1, sum + at, r->peak + at);
        }
    }
}

/* Sums of rings to shares of what lies beyond each. */
static void take_shares(const struct rings *r, const double *sum, double norm,
                        double *whole)
{
    double beyond = 0.0;
    for (int i = r->n - 1; i >= 0; i--) {
        r->left[i] = fmax(r->left[i], beyond / norm);
        beyond += sum[i];
    }
    *whole = fmax(*whole, beyond / norm);
}

static gp_status fill_rings(const struct gp_log *log,
                            const struct gp_kernel *k, bool tail,
                            struct rings *r)
{
    void *p;
    gp_status st = gp_alloc(log, "shrinking", (size_t) r->n, sizeof(double),
                            &p);
    if (st)
        return st;
    double *const sum = p;
    for (int c = 0; c < (k->grey ? 1 : 3); c++) {
        memset(sum, 0, (size_t) r->n * sizeof *sum);
        add_channel(k, c, tail, r, sum);
        if (k->norm1[c] > 0.0)
            take_shares(r, sum, k->norm1[c], &r->whole);
    }
    for (int i = r->n - 2; i >= 0; i--)
        r->peak[i] = fmaxf(r->peak[i], r->peak[i + 1]);
    gp_free(sum);
    return GP_OK;
}

/* Rings that a polygon of this light keeps: those up to the last one where it
 * is over `least`. */
static int kept(const struct rings *r, double light, double least)
{
    int low = 0, high = r->n; // the peaks fall
    while (low < high) {
        const int mid = (low + high) / 2;
        if (light * (double) r->peak[mid] > least)
            low = mid + 1;
        else
            high = mid;
    }
    return low;
}

/* The most light that a polygon of that bin may have. */
static double bin_end(int bin)
{
    static const int last = (0xff << 1) - 1; // beyond it are Inf and NaN
    const float v = gp_source_bin_start(bin < last ? bin + 1 : last + 1);
    return isfinite(v) ? (double) v : 0x1p128;
}

/* Share of all light that is left out. */
static double left_out(const struct rings *r, const struct lights *l,
                       double least)
{
    double sum = 0.0;
    for (int b = 0; b < GP_SOURCE_BINS; b++) {
        if (!(l->bin[b] > 0.0))
            continue;
        const int n = kept(r, bin_end(b), least);
        sum += l->bin[b] * (n ? r->left[n - 1] : r->whole);
    }
    return sum / l->all;
}

/* The largest float for which at most `share` is left out: floats over 0 are
 * in the order of their bits. */
static float find_least(const struct rings *r, const struct lights *l,
                        double share)
{
    uint32_t low = 0, high = 0x7f800000; // 0 leaves nothing out; Inf
    while (high - low > 1) {
        const uint32_t mid = low + (high - low) / 2;
        float v;
        memcpy(&v, &mid, sizeof v);
        if (left_out(r, l, (double) v) <= share)
            low = mid;
        else
            high = mid;
    }
    float least;
    memcpy(&least, &low, sizeof least);
    return least;
}

/* Adds up the lights; returns how far a polygon's blur and its place between
 * pixels can carry a sample of the kernel, in whole pixels. */
static int survey(const struct gp_polygons *polygons, struct lights *l)
{
    int side = 1;
    for (size_t i = 0; i < polygons->n; i++) {
        const struct gp_polygon *const p = &polygons->at[i];
        l->bin[gp_source_bin(p->light)] += (double) p->light;
        l->all += (double) p->light;
        side = gp_blur_box[p->blur] > side ? gp_blur_box[p->blur] : side;
    }
    return side / 2 + 1;
}

gp_status gp_shrink_make(const struct gp_log *log,
                         const struct gp_kernel *kernel,
                         const struct gp_splat_params *p,
                         const struct gp_polygons *polygons,
                         struct gp_shrink *out)
{
    gp_status st = GP_OK;
    const bool tail = p->method == GP_GROUP_CORE;
    struct lights l = {0};
    struct rings r = {0};
    struct gp_shrink s = {0};
    const int carry = survey(polygons, &l);
    for (int b = 0; b < GP_SOURCE_BINS; b++)
        s.reach[b] = INT_MAX / 2;
    if (p->shrink > 0.0f && l.all > 0.0) {
        GP_TRY(make_rings(log, kernel, &r));
        GP_TRY(fill_rings(log, kernel, tail, &r));
        s.least = find_least(&r, &l, (double) p->shrink);
        s.left_out = left_out(&r, &l, (double) s.least);
        for (int b = 0; b < GP_SOURCE_BINS; b++) {
            const int n = kept(&r, bin_end(b), (double) s.least);
            const int reach = n ? r.first + n - 1 + carry : 0;
            s.reach[b] = tail && reach < GP_CORE_RADIUS ? GP_CORE_RADIUS
                                                        : reach;
        }
    }
    *out = s;
out:
    free_rings(&r);
    return st;
}
