/* A convolution by complex transforms of powers of two, plain or compensated:
 * each number is a pair, the second of which keeps what additions and products
 * lose (Knuth's two-sum; fused products), for split.c. */

enum { LANES = 16, PARTS = 4 }; // re, im, and what both have lost

/* Points of LANES transforms side by side; twiddle factors of the longest. */
struct lanes {
    int n;            // length
    bool kept;
    float *a[PARTS], *b[PARTS], *w[PARTS];
};

static float *floats(size_t n)
{
    float *out = NULL;
    if (gp_alloc_zero(&split_log, "lanes", n, sizeof *out, &out))
        exit(70);
    return out;
}

static struct lanes lanes_open(int n, bool kept, int sign)
{
    struct lanes l = {.n = n, .kept = kept};
    for (int i = 0; i < PARTS; i++) {
        l.a[i] = floats((size_t) n * LANES);
        l.b[i] = floats((size_t) n * LANES);
        l.w[i] = floats((size_t) n / 2);
    }
    for (int j = 0; j < n / 2; j++) {
        const double at = sign * 2.0 * acos(-1.0) * j / n;
        const double of[2] = {cos(at), sin(at)};
        for (int i = 0; i < 2; i++) {
            l.w[i][j] = (float) of[i];
            l.w[2 + i][j] = (float) (of[i] - (double) l.w[i][j]);
        }
    }
    return l;
}

static void lanes_close(struct lanes *l)
{
    for (int i = 0; i < PARTS; i++) {
        gp_free(l->a[i]);
        gp_free(l->b[i]);
        gp_free(l->w[i]);
    }
}

#if defined(__x86_64__) && !defined(__clang__)
#define WITH_FMA __attribute__((target_clones("fma", "default")))
#else
#define WITH_FMA
#endif

/* s + lost = a + b, exactly */
#define TWO_SUM(s, lost, a, b)                                                \
    const float s = (a) + (b), s##_ = s - (a);                                \
    const float lost = ((a) - (s - s##_)) + ((b) - s##_)

/* Butterflies of n points, x and y `half` apart, with one factor. */
WITH_FMA static void plain(const float *const in[PARTS],
    float *const out[PARTS], size_t x, size_t y, size_t half, int n,
    const float w[PARTS])
{
    const float *restrict const ar = in[0] + x, *restrict const ai = in[1] + x;
    const float *restrict const br = ar + half, *restrict const bi = ai + half;
    float *restrict const pr = out[0] + y, *restrict const pi = out[1] + y;
    for (int i = 0; i < n; i++) {
        const float dr = ar[i] - br[i], di = ai[i] - bi[i];
        pr[i] = ar[i] + br[i];
        pi[i] = ai[i] + bi[i];
        pr[n + i] = w[0] * dr - w[1] * di;
        pi[n + i] = w[0] * di + w[1] * dr;
    }
}

/* re + lost = p q - r s, its factors' losses included; of p and q, r and s */
#define KEPT_PRODUCT(re, lost, p, pl, q, ql, r, rl, s, sl)                    \
    const float re##1 = (p) * (q), re##2 = -(r) * (s);                        \
    TWO_SUM(re, lost##1, re##1, re##2);                                       \
    const float lost = lost##1 + __builtin_fmaf(p, q, -re##1) +               \
                       __builtin_fmaf(-(r), s, -re##2) +                      \
                       ((p) * (ql) + (pl) * (q) - (r) * (sl) - (rl) * (s))

WITH_FMA static void compensated(const float *const in[PARTS],
    float *const out[PARTS], size_t x, size_t y, size_t half, int n,
    const float w[PARTS])
{
    const float *restrict const ar = in[0] + x, *restrict const ai = in[1] + x;
    const float *restrict const al = in[2] + x, *restrict const am = in[3] + x;
    float *restrict const pr = out[0] + y, *restrict const pi = out[1] + y;
    float *restrict const pl = out[2] + y, *restrict const pm = out[3] + y;
    const float wr = w[0], wi = w[1], wl = w[2], wm = w[3];
    for (int i = 0; i < n; i++) {
        const float br = ar[half + (size_t) i], bi = ai[half + (size_t) i];
        const float bl = al[half + (size_t) i], bm = am[half + (size_t) i];
        TWO_SUM(sr, se, ar[i], br);
        TWO_SUM(si, sf, ai[i], bi);
        TWO_SUM(dr, de, ar[i], -br);
        TWO_SUM(di, df, ai[i], -bi);
        const float dl = de + (al[i] - bl), dm = df + (am[i] - bm);
        KEPT_PRODUCT(re, rl, wr, wl, dr, dl, wi, wm, di, dm);
        KEPT_PRODUCT(im, il, wr, wl, di, dm, -wi, -wm, dr, dl);
        pr[i] = sr;
        pi[i] = si;
        pl[i] = se + (al[i] + bl);
        pm[i] = sf + (am[i] + bm);
        pr[n + i] = re;
        pi[n + i] = im;
        pl[n + i] = rl;
        pm[n + i] = il;
    }
}

/* Transforms LANES lines at `at` of z in place: points are `step` floats apart,
 * lines `next` (Stockham, radix 2). */
static void transform_lines(struct lanes *l, float *const z[PARTS], size_t at,
                            size_t step, size_t next)
{
    const int parts = l->kept ? PARTS : 2;
    float **in = l->a, **out = l->b;
    for (int p = 0; p < parts; p++) {
        for (size_t i = 0; i < (size_t) l->n; i++) {
            for (size_t j = 0; j < LANES; j++)
                in[p][i * LANES + j] = z[p][at + i * step + j * next];
        }
    }
    for (int half = l->n / 2, m = 1; half; half /= 2, m *= 2) {
        for (int j = 0; j < half; j++) {
            const float w[PARTS] = {l->w[0][j * m], l->w[1][j * m],
                                    l->w[2][j * m], l->w[3][j * m]};
            const size_t x = (size_t) (j * m) * LANES;
            (l->kept ? compensated : plain)(
                (const float *const *) in, out, x, 2 * x,
                (size_t) l->n / 2 * LANES, m * LANES, w);
        }
        float **const swap = in;
        in = out;
        out = swap;
    }
    for (int p = 0; p < parts; p++) {
        for (size_t i = 0; i < (size_t) l->n; i++) {
            for (size_t j = 0; j < LANES; j++)
                z[p][at + i * step + j * next] = in[p][i * LANES + j];
        }
    }
}

struct kept {
    int nx, ny;
    bool kept;
    float *z[PARTS], *kernel[3][PARTS];
    struct lanes x[2], y[2]; // forward, back
};

static void transform_plane(struct kept *p, float *const z[PARTS], int back)
{
    const size_t nx = (size_t) p->nx, ny = (size_t) p->ny;
    for (size_t i = 0; i < (back ? nx : ny); i += LANES) {
        if (back)
            transform_lines(&p->y[1], z, i, nx, 1);
        else
            transform_lines(&p->x[0], z, i * nx, 1, nx);
    }
    for (size_t i = 0; i < (back ? ny : nx); i += LANES) {
        if (back)
            transform_lines(&p->x[1], z, i * nx, 1, nx);
        else
            transform_lines(&p->y[0], z, i, nx, 1);
    }
}

/* nx and ny are powers of two. */
static struct kept kept_open(const struct gp_kernel *k, int nx, int ny,
                             bool kept)
{
    struct kept p = {.nx = nx, .ny = ny, .kept = kept};
    const size_t n = (size_t) nx * (size_t) ny;
    for (int back = 0; back < 2; back++) {
        p.x[back] = lanes_open(nx, kept, back ? 1 : -1);
        p.y[back] = lanes_open(ny, kept, back ? 1 : -1);
    }
    for (int i = 0; i < PARTS; i++)
        p.z[i] = floats(n);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < PARTS; i++)
            p.kernel[c][i] = floats(n);
        for (int y = 0; y < k->h; y++) {
            for (int x = 0; x < k->w; x++) // scaled by a power of two
                p.kernel[c][0][(y - k->cy + ny) % ny * nx +
                               (x - k->cx + nx) % nx] =
                    k->k.c[c][y * k->w + x] / (float) n;
        }
        transform_plane(&p, p.kernel[c], 0);
    }
    return p;
}

/* Adds the layer of all light. */
static void kept_add(struct kept *p, const struct gp_sources *src,
                     struct gp_planes *layer)
{
    const size_t n = (size_t) p->nx * (size_t) p->ny;
    float *const *const z = p->z;
    for (int c = 0; c < 3; c++) {
        const float *const *const k = (const float *const *) p->kernel[c];
        for (int i = 0; i < PARTS; i++)
            memset(z[i], 0, n * sizeof(float));
        for (int y = 0; y < src->h; y++) {
            for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
                z[0][y * p->nx + src->x[i]] = src->rgb[c][i];
        }
        transform_plane(p, z, 0);
        for (size_t i = 0; i < n; i++) {
            const float a = z[0][i], b = z[1][i], e = z[2][i], f = z[3][i];
            KEPT_PRODUCT(re, rl, a, e, k[0][i], k[2][i], b, f, k[1][i],
                         k[3][i]);
            KEPT_PRODUCT(im, il, a, e, k[1][i], k[3][i], -b, -f, k[0][i],
                         k[2][i]);
            z[0][i] = re;
            z[1][i] = im;
            z[2][i] = p->kept ? rl : 0.0f;
            z[3][i] = p->kept ? il : 0.0f;
        }
        transform_plane(p, z, 1);
        for (int y = 0; y < src->h; y++) {
            float *const to = layer->c[c] + (size_t) y * (size_t) src->w;
            for (int x = 0; x < src->w; x++)
                to[x] += z[0][y * p->nx + x] + z[2][y * p->nx + x];
        }
    }
}

static void kept_close(struct kept *p)
{
    for (int i = 0; i < PARTS; i++) {
        gp_free(p->z[i]);
        for (int c = 0; c < 3; c++)
            gp_free(p->kernel[c][i]);
    }
    for (int back = 0; back < 2; back++) {
        lanes_close(&p->x[back]);
        lanes_close(&p->y[back]);
    }
}
