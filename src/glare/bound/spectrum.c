/* Bounds the layer of the difference of sources and polygons by the kernel's
 * spectrum. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/bound/bound_priv.h"

#include <math.h>
#include <string.h>

enum {
    COLUMNS = 16,           // a task takes
    BAND = 64,              // rows a task takes
    MOST_POINTS = 1 << 26,  // of a plane
};

/* Columns whose |K|^2 is nowhere over this share of its mean are not
 * transformed but taken at their largest: they hardly count. */
static const double FAINT = 0.25;

static bool is_faint(const struct gp_power *p, int c, int k)
{
    const double most = (double) p->most[c][k];
    return most * most <= FAINT * p->mean2[c];
}

/* Rounding of a transform of n points relative to its norm, two rows to a
 * complex one (Higham 2002, theorem 24.2). */
static double rounding(const struct gp_power *p)
{
    return 2.0 * 5.42 * 0x1p-24 * log2((double) p->nx * p->ny);
}

/* Sum of squares in eight parts, so that it becomes vector code. */
GP_CLONES static double sum_squares(const float *v, int n)
{
    enum { LANES = 8 };
    double lane[LANES] = {0}, sum = 0.0;
    int x = 0;
    for (; x + LANES <= n; x += LANES) {
        for (int i = 0; i < LANES; i++)
            lane[i] += (double) v[x + i] * (double) v[x + i];
    }
    for (; x < n; x++)
        sum += (double) v[x] * (double) v[x];
    for (int i = 0; i < LANES; i++)
        sum += lane[i];
    return sum;
}

GP_CLONES static double sum_magnitudes(const float *v, int n)
{
    enum { LANES = 8 };
    double lane[LANES] = {0}, sum = 0.0;
    int x = 0;
    for (; x + LANES <= n; x += LANES) {
        for (int i = 0; i < LANES; i++)
            lane[i] += fabs((double) v[x + i]);
    }
    for (; x < n; x++)
        sum += fabs((double) v[x]);
    for (int i = 0; i < LANES; i++)
        sum += lane[i];
    return sum;
}

/* -- the kernel's samples -------------------------------------------------- */

/* The part of the kernel that can reach the frame. */
struct reaching {
    const struct gp_kernel *k;
    struct gp_rect crop;
    bool tail;
    double (*sum)[2]; // of each row of each channel: magnitudes, squares
};

/* Returns row y of the kernel, of which [crop.x0, *core) and [*beyond, crop.x1)
 * count. */
static const float *find_row(const struct reaching *p, int c, int y, int *core,
                             int *beyond)
{
    const struct gp_kernel *const k = p->k;
    const bool cut = p->tail && abs(y - k->cy) <= GP_CORE_RADIUS;
    *core = cut ? gp_clamp(k->cx - GP_CORE_RADIUS, p->crop.x0, p->crop.x1)
                : p->crop.x1;
    *beyond = cut ? gp_clamp(k->cx + GP_CORE_RADIUS + 1, p->crop.x0,
                             p->crop.x1)
                  : p->crop.x1;
    return k->k.c[c] + (size_t) y * (size_t) k->w;
}

static void load_kernel(const void *ctx, int c, int j, float *z)
{
    const struct reaching *const p = ctx;
    int core, beyond;
    const float *const row = find_row(p, c, p->crop.y0 + j, &core, &beyond);
    for (int x = p->crop.x0; x < core; x++)
        z[2 * (x - p->crop.x0)] = row[x];
    for (int x = beyond; x < p->crop.x1; x++)
        z[2 * (x - p->crop.x0)] = row[x];
}

static void measure_row(void *ctx, int i, int thread)
{
    const struct reaching *const p = ctx;
    const int rows = gp_rect_h(p->crop);
    int core, beyond;
    const float *const row =
        find_row(p, i / rows, p->crop.y0 + i % rows, &core, &beyond);
    (void) thread;
    p->sum[i][0] = sum_magnitudes(row + p->crop.x0, core - p->crop.x0) +
                   sum_magnitudes(row + beyond, p->crop.x1 - beyond);
    p->sum[i][1] = sum_squares(row + p->crop.x0, core - p->crop.x0) +
                   sum_squares(row + beyond, p->crop.x1 - beyond);
}

/* Finds norm1 and mean2, the mean of |K|^2 by Parseval. */
static gp_status measure_kernel(const struct gp_log *log,
                                struct reaching *reach, struct gp_power *p)
{
    const int rows = gp_rect_h(reach->crop);
    if (gp_rect_empty(reach->crop))
        return GP_OK;
    gp_status st = gp_alloc(log, "bound", (size_t) rows * (size_t) p->channels,
                            sizeof *reach->sum, &reach->sum);
    if (st)
        return st;
    gp_parallel_do(rows * p->channels, measure_row, reach);
    for (int i = 0; i < rows * p->channels; i++) {
        p->norm1[i / rows] += reach->sum[i][0];
        p->mean2[i / rows] += reach->sum[i][1];
    }
    GP_FREE(reach->sum);
    return GP_OK;
}

/* -- its magnitudes, column by column -------------------------------------- */

struct magnitudes {
    const struct gp_fftwf *lib;
    struct gp_power *p;
    const struct gp_fft_matrix *rows; // twice the spectra of `n` rows
    int c, n;
    float *buffer; // two columns for each thread
};

/* Returns the largest |z|^2 of n numbers, n a multiple of 8. In double: squares
 * may leave the range of float. */
GP_CLONES static double find_most(const float *z, int n)
{
    enum { LANES = 8 };
    double lane[LANES] = {0}, most = 0.0;
    for (int y = 0; y < n; y += LANES) {
        for (int i = 0; i < LANES; i++) {
            const double re = (double) z[2 * (y + i)];
            const double im = (double) z[2 * (y + i) + 1];
            const double v = re * re + im * im;
            lane[i] = v > lane[i] ? v : lane[i];
        }
    }
    for (int i = 0; i < LANES; i++)
        most = fmax(most, lane[i]);
    return most;
}

/* A magnitude, half of sqrt(square), that rounding hides nowhere. */
static inline __attribute__((always_inline)) float
over(double square, double extra)
{
    return (float) ((0.5 * sqrt(square) + extra) * (1.0 + 0x1p-20));
}

GP_CLONES static void find_over(const float *restrict z, double extra, int n,
                                float *restrict to)
{
    for (int y = 0; y < n; y++) {
        const double re = (double) z[2 * y], im = (double) z[2 * y + 1];
        to[y] = over(re * re + im * im, extra);
    }
}

/* Transforms some columns and keeps their magnitudes. */
static void find_columns(void *ctx, int i, int thread)
{
    const struct magnitudes *const m = ctx;
    struct gp_power *const p = m->p;
    const int c = m->c, end = gp_min((i + 1) * COLUMNS, p->nx / 2 + 1);
    const size_t ny = (size_t) p->ny;
    const double extra = rounding(p) * p->norm1[c];
    float *const column = m->buffer + 4 * ny * (size_t) thread;
    float *const spectrum = column + 2 * ny;
    memset(column + 2 * m->n, 0,
           2 * sizeof(float) * (ny - (size_t) m->n));
    for (int k = i * COLUMNS; k < end; k++) {
        memcpy(column, m->rows->z[c] + 2 * (size_t) k * m->rows->pitch,
               2 * sizeof(float) * (size_t) m->n);
        m->lib->execute_dft(p->y.forward, (void *) column, (void *) spectrum);
        p->most[c][k] = over(find_most(spectrum, p->ny), extra);
        if (!is_faint(p, c, k)) // else nothing reads it
            find_over(spectrum, extra, p->ny, p->power[c] + (size_t) k * ny);
    }
}

/* The least period on which what wraps around stays off n pixels: sources lie
 * up to `pad` outside them, the kernel reaches from -before to after. */
static int period(int n, int pad, int before, int after)
{
    const int reach = gp_max(gp_max(before, after), 0);
    const int whole = n + 2 * pad; // the residue has to fit
    return gp_fft_length(gp_max(gp_max(n + pad + reach, whole),
                                before + after + 1));
}

gp_status gp_power_make(const struct gp_log *log,
                        const struct gp_kernel *kernel, bool tail, int w,
                        int h, int pad, struct gp_power *out)
{
    gp_status st;
    const struct gp_rect crop = gp_bound_crop(kernel, w - 1 + pad, h - 1 + pad);
    struct reaching reach = {.k = kernel, .tail = tail, .crop = crop};
    struct gp_power p = {.channels = kernel->grey ? 1 : 3};
    struct gp_fft_matrix rows = {0};
    struct magnitudes m = {.p = &p, .n = gp_rect_h(crop)};
    GP_TRY(measure_kernel(log, &reach, &p));
    if (!gp_rect_empty(crop) && !gp_fftwf_open(NULL, &m.lib)) {
        p.nx = period(w, pad, kernel->cx - crop.x0, crop.x1 - 1 - kernel->cx);
        p.ny = period(h, pad, kernel->cy - crop.y0, crop.y1 - 1 - kernel->cy);
    }
    if ((double) p.nx * p.ny > MOST_POINTS)
        p.nx = p.ny = 0;
    const size_t columns = (size_t) p.nx / 2 + 1, ny = (size_t) p.ny;
    if (p.nx) {
        GP_TRY(gp_fft_plan_make(log, p.nx, GP_FFT_PLAN_ESTIMATE, NULL, &p.x));
        GP_TRY(gp_fft_plan_make(log, p.ny, GP_FFT_PLAN_ESTIMATE, NULL, &p.y));
        GP_TRY(gp_fft_matrix_make(log, 1, p.nx, m.n, &rows));
        // (lengths are multiples of 8: columns stay aligned)
        GP_TRY(gp_alloc(log, "bound", 4 * ny * (size_t) gp_threads(),
                        sizeof *m.buffer, &m.buffer));
    }
    // The kernel's place on the torus does not change |K|
    for (m.c = 0; p.nx && m.c < p.channels; m.c++) {
        const struct gp_fft_request req = {log, &p.x, &p.y, m.c, 1};
        struct gp_fft_matrix view = rows;
        view.z[0] = NULL;
        view.z[m.c] = rows.z[0];
        m.rows = &view;
        GP_TRY(gp_alloc(log, "bound", columns * ny, sizeof(float),
                        &p.power[m.c]));
        GP_TRY(gp_alloc(log, "bound", columns, sizeof(float), &p.most[m.c]));
        GP_TRY(gp_fft_rows_in(&req, m.n, load_kernel, &reach, &view));
        gp_parallel_do(((int) columns + COLUMNS - 1) / COLUMNS, find_columns,
                       &m);
    }
    *out = p;
    p = (struct gp_power) {0};
out:
    gp_free(m.buffer);
    gp_fft_matrix_free(&rows);
    gp_power_free(&p);
    return st;
}

void gp_power_free(struct gp_power *p)
{
    for (int c = 0; c < 3; c++) {
        gp_free(p->power[c]);
        gp_free(p->most[c]);
    }
    gp_fft_plan_free(&p->x);
    gp_fft_plan_free(&p->y);
    *p = (struct gp_power) {0};
}

/* -- the residue ----------------------------------------------------------- */

struct filling {
    const struct gp_sources *src;
    const struct gp_polygons *polygons;
    struct gp_residue *out;
    int width, height; // of the planes
    bool *lit;         // rows that are not 0
    double (*square)[3]; // of each band
};

/* Pixels of a polygon's light on one axis: box + 1 from `first`, the
 * ones between the ends all with weight 1 / box. */
struct footprint {
    int first;
    double head, body, tail; // weights
};

static struct footprint make_footprint(float at, int box)
{
    const double start = (double) at - (box - 1) / 2.0;
    const double fraction = start - floor(start), body = 1.0 / box;
    return (struct footprint) {
        .first = (int) floor(start),
        .head = (1.0 - fraction) * body, .body = body, .tail = fraction * body,
    };
}

/* Makes rows of the planes: sources, less the polygons that reach them. */
static void fill_band(void *ctx, int band, int thread)
{
    const struct filling *const f = ctx;
    const struct gp_sources *const src = f->src;
    const int y0 = band * BAND, y1 = gp_min(y0 + BAND, f->height);
    const int pad = f->out->pad;
    const size_t width = (size_t) f->width;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        float *const plane = f->out->d.c[c];
        memset(plane + (size_t) y0 * width, 0,
               (size_t) (y1 - y0) * width * sizeof(float));
        for (int y = gp_max(y0, pad); y < gp_min(y1, pad + src->h); y++) {
            float *const to = plane + (size_t) y * width + pad;
            for (uint32_t k = src->row[y - pad]; k < src->row[y - pad + 1]; k++)
                to[src->x[k]] = src->rgb[c][k];
        }
    }
    for (size_t k = 0; k < f->polygons->n; k++) {
        const struct gp_polygon *const p = &f->polygons->at[k];
        const int box = gp_blur_box[p->blur];
        // the usual case first: the band is far away
        if ((double) p->y + pad + box / 2 + 2 < y0 ||
            (double) p->y + pad - box / 2 - 2 > y1)
            continue;
        const struct footprint v = make_footprint(p->y, box);
        const struct footprint u = make_footprint(p->x, box);
        for (int j = 0; j <= box; j++) {
            const int y = v.first + pad + j;
            const double down = j == 0 ? v.head : j < box ? v.body : v.tail;
            if (y < y0 || y >= y1 || down == 0.0)
                continue;
            for (int c = 0; c < 3; c++) {
                float *const to =
                    f->out->d.c[c] + (size_t) y * width + pad + u.first;
                const double light = (double) p->rgb[c] * down;
                const float body = (float) (light * u.body);
                to[0] -= (float) (light * u.head);
                for (int i = 1; i < box; i++)
                    to[i] -= body;
                to[box] -= (float) (light * u.tail);
            }
        }
    }
    for (int y = y0; y < y1; y++) {
        f->lit[y] = false;
        for (int c = 0; c < 3; c++) {
            const double sum = sum_squares(
                f->out->d.c[c] + (size_t) y * width, f->width);
            f->square[band][c] += sum;
            f->lit[y] |= sum > 0.0;
        }
    }
}

gp_status gp_residue_make(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_polygons *polygons, int pad,
    struct gp_residue *out)
{
    gp_status st;
    struct gp_residue r = {.w = src->w, .h = src->h, .pad = pad};
    struct filling f = {
        .src = src, .polygons = polygons, .out = &r,
        .width = src->w + 2 * pad, .height = src->h + 2 * pad,
    };
    const int bands = (f.height + BAND - 1) / BAND;
    GP_TRY(gp_planes_make(log, "bound",
                          (size_t) f.width * (size_t) f.height, &r.d));
    GP_TRY(gp_alloc(log, "bound", (size_t) f.height, sizeof *r.row, &r.row));
    GP_TRY(gp_alloc(log, "bound", (size_t) f.height, sizeof *f.lit, &f.lit));
    GP_TRY(gp_alloc_zero(log, "bound", (size_t) bands, sizeof *f.square,
                         &f.square));
    gp_parallel_do(bands, fill_band, &f);
    for (int y = 0; y < f.height; y++) {
        if (f.lit[y])
            r.row[r.rows++] = y;
    }
    for (int c = 0; c < 3; c++) {
        double sum = 0.0, light = 0.0;
        for (int i = 0; i < bands; i++)
            sum += f.square[i][c];
        r.norm2[c] = sqrt(sum);
        // a single source and its polygon cancel to the bit; where more meet,
        // each pixel takes a few roundings of at most the cell's light
        for (size_t k = 0; k < polygons->n; k++) {
            const double v = (double) polygons->at[k].rgb[c];
            light += v * v;
        }
        r.rounding[c] = sum > 0.0 ? 0x1p-21 * sqrt(light) : 0.0;
    }
    *out = r;
    r = (struct gp_residue) {0};
out:
    gp_residue_free(&r);
    gp_free(f.lit);
    gp_free(f.square);
    return st;
}

void gp_residue_free(struct gp_residue *r)
{
    gp_planes_free(&r->d);
    gp_free(r->row);
    *r = (struct gp_residue) {0};
}

/* -- the power of the residue ---------------------------------------------- */

struct adding {
    const struct gp_power *p;
    const struct gp_residue *r;
    const struct gp_fft_matrix *m;
    const struct gp_fftwf *lib;
    int tasks;      // for each channel
    double *sum;    // of each task
    float *buffer;  // two columns for each thread
};

static void load_residue(const void *ctx, int c, int j, float *z)
{
    const struct gp_residue *const r = ctx;
    const int width = r->w + 2 * r->pad;
    const float *const row = r->d.c[c] + (size_t) r->row[j] * (size_t) width;
    for (int x = 0; x < width; x++)
        z[2 * x] = row[x];
}

/* Sum of |power[y] z[y]|^2, in eight parts so that it becomes vector code. In
 * double: squares may leave the range of float. */
GP_CLONES static double weigh(const float *power, const float *z, int n)
{
    enum { LANES = 8 };
    double lane[LANES] = {0};
    for (int y = 0; y < n; y += LANES) { // n is a multiple of 8
        for (int i = 0; i < LANES; i++) {
            const double re = (double) z[2 * (y + i)];
            const double im = (double) z[2 * (y + i) + 1];
            const double k = (double) power[y + i];
            lane[i] += k * k * (re * re + im * im);
        }
    }
    double sum = 0.0;
    for (int i = 0; i < LANES; i++)
        sum += lane[i];
    return sum;
}

/* Sums |K|^2 |2 D|^2 over some columns of one channel. */
static void add_columns(void *ctx, int i, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_power *const p = a->p;
    const int c = i / a->tasks, k0 = i % a->tasks * COLUMNS;
    const int kc = p->channels == 1 ? 0 : c, last = p->nx / 2;
    const int end = gp_min(k0 + COLUMNS, last + 1);
    const size_t ny = (size_t) p->ny;
    float *const column = a->buffer + 4 * ny * (size_t) thread;
    float *const spectrum = column + 2 * ny;
    double sum = 0.0;
    for (int k = k0; k < end; k++) {
        const float *const z = a->m->z[c] + 2 * (size_t) k * a->m->pitch;
        const double times = k == 0 || k == last ? 1.0 : 2.0;
        const double most = (double) p->most[kc][k];
        if (is_faint(p, kc, k)) {
            sum += most * most * p->ny * sum_squares(z, 2 * a->r->rows) * times;
            continue;
        }
        memset(column, 0, 2 * sizeof(float) * ny);
        for (int j = 0; j < a->r->rows; j++) {
            column[2 * a->r->row[j]] = z[2 * j];
            column[2 * a->r->row[j] + 1] = z[2 * j + 1];
        }
        a->lib->execute_dft(p->y.forward, (void *) column, (void *) spectrum);
        sum += weigh(p->power[kc] + (size_t) k * ny, spectrum, p->ny) * times;
    }
    a->sum[i] = sum;
}

gp_status gp_power_bound(const struct gp_log *log, const struct gp_power *p,
                         const struct gp_residue *r, double out[3])
{
    gp_status st = GP_OK;
    double sum[3] = {0}; // |K|^2 |2 D|^2
    struct gp_fft_matrix m = {0};
    const struct gp_fft_request req = {log, &p->x, &p->y, 0, 3};
    struct adding a = {
        .p = p, .r = r, .m = &m, .tasks = (p->nx / 2 + COLUMNS) / COLUMNS,
    };
    if (r->rows && p->nx) {
        GP_TRY(gp_fftwf_open(log, &a.lib));
        GP_TRY(gp_fft_matrix_make(log, 3, p->nx, r->rows, &m));
        GP_TRY(gp_alloc(log, "bound", (size_t) a.tasks * 3, sizeof *a.sum,
                        &a.sum));
        // (lengths are multiples of 8: columns stay aligned)
        GP_TRY(gp_alloc(log, "bound",
                        4 * (size_t) p->ny * (size_t) gp_threads(),
                        sizeof *a.buffer, &a.buffer));
        GP_TRY(gp_fft_rows_in(&req, r->rows, load_residue, r, &m));
        gp_parallel_do(3 * a.tasks, add_columns, &a);
        for (int i = 0; i < 3 * a.tasks; i++)
            sum[i / a.tasks] += a.sum[i];
    }
    for (int c = 0; c < 3; c++) {
        const double norm1 = p->norm1[p->channels == 1 ? 0 : c];
        // Young's inequality where there is no transform
        out[c] = p->nx ? sqrt(sum[c] / (4.0 * p->nx * p->ny)) +
                             norm1 * rounding(p) * r->norm2[c]
                       : norm1 * r->norm2[c];
        out[c] += norm1 * r->rounding[c];
    }
out:
    gp_fft_matrix_free(&m);
    gp_free(a.sum);
    gp_free(a.buffer);
    return st;
}
