/* A convolution by real transforms in one precision, for split.c, which
 * includes this file for each, with
 *
 *   REAL       float, double
 *   FFT(name)  FFTW's name of that precision
 *   OF(name)   that of a function or struct of this file */

struct OF(passes) {
    int nx, ny, from, to;   // columns [from, to) of the half spectrum are taken
    size_t pitch;           // REALs from row to row
    REAL *z, *kernel[3];    // ny rows each
    FFT(plan) in, out, columns, back;
};

/* Transforms columns of z; rows are transformed already. */
static void OF(forward)(struct OF(passes) *p, REAL *z)
{
    FFT(complex) *const first = (FFT(complex) *) z + p->from;
    FFT(execute_dft)(p->columns, first, first);
}

static struct OF(passes) OF(open)(const struct gp_kernel *k, int nx, int ny,
                                  int from, int to)
{
    struct OF(passes) p = {nx, ny, from, to, .pitch = (size_t) nx + 16};
    const size_t n = p.pitch * (size_t) ny, one = sizeof(REAL);
    const int stride = (int) p.pitch / 2;
    const unsigned how = FFTW_MEASURE;
    if (gp_alloc_zero(&split_log, "z", n, one, &p.z))
        exit(70);
    FFT(complex) *const z = (FFT(complex) *) p.z + from;
    p.in = FFT(plan_dft_r2c_1d)(nx, p.z, (FFT(complex) *) p.z, how);
    p.out = FFT(plan_dft_c2r_1d)(nx, (FFT(complex) *) p.z, p.z, how);
    p.columns = FFT(plan_many_dft)(1, &ny, to - from, z, NULL, stride, 1, z,
                                   NULL, stride, 1, FFTW_FORWARD, how);
    p.back = FFT(plan_many_dft)(1, &ny, to - from, z, NULL, stride, 1, z, NULL,
                                stride, 1, FFTW_BACKWARD, how);
    const double scale = 1.0 / ((double) nx * ny);
    for (int c = 0; c < 3; c++) {
        if (gp_alloc_zero(&split_log, "kernel", n, one, &p.kernel[c]))
            exit(70);
        for (int y = 0; y < k->h; y++) {
            REAL *const row =
                p.kernel[c] + p.pitch * (size_t) ((y - k->cy + ny) % ny);
            for (int x = 0; x < k->w; x++)
                row[(x - k->cx + nx) % nx] = (REAL) (
                    scale * (double) k->k.c[c][y * k->w + x]);
            FFT(execute_dft_r2c)(p.in, row, (FFT(complex) *) row);
        }
        OF(forward)(&p, p.kernel[c]);
    }
    return p;
}

static void OF(multiply)(REAL *z, const REAL *k, int from, int to)
{
    for (int x = 2 * from; x < 2 * to; x += 2) {
        const REAL re = z[x], im = z[x + 1];
        z[x] = re * k[x] - im * k[x + 1];
        z[x + 1] = re * k[x + 1] + im * k[x];
    }
}

/* Adds the layer of the rows of light that are taken. */
static void OF(add)(struct OF(passes) *p, const struct gp_sources *src,
                    const bool *taken, struct gp_planes *layer)
{
    for (int c = 0; c < 3; c++) {
        memset(p->z, 0, p->pitch * (size_t) p->ny * sizeof(REAL));
        for (int y = 0; y < src->h; y++) {
            REAL *const row = p->z + p->pitch * (size_t) y;
            if (!taken[y] || src->row[y] == src->row[y + 1])
                continue;
            for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
                row[src->x[i]] = (REAL) src->rgb[c][i];
            FFT(execute_dft_r2c)(p->in, row, (FFT(complex) *) row);
        }
        OF(forward)(p, p->z);
        for (int y = 0; y < p->ny; y++)
            OF(multiply)(p->z + p->pitch * (size_t) y,
                         p->kernel[c] + p->pitch * (size_t) y, p->from, p->to);
        FFT(complex) *const first = (FFT(complex) *) p->z + p->from;
        FFT(execute_dft)(p->back, first, first);
        const int half = p->nx / 2 + 1;
        for (int y = 0; y < src->h; y++) {
            REAL *const row = p->z + p->pitch * (size_t) y;
            float *const to = layer->c[c] + (size_t) y * (size_t) src->w;
            memset(row, 0, 2 * (size_t) p->from * sizeof(REAL));
            memset(row + 2 * p->to, 0,
                   2 * (size_t) (half - p->to) * sizeof(REAL));
            FFT(execute_dft_c2r)(p->out, (FFT(complex) *) row, row);
            for (int x = 0; x < src->w; x++)
                to[x] += (float) row[x];
        }
    }
}

static void OF(close)(struct OF(passes) *p)
{
    FFT(destroy_plan)(p->in);
    FFT(destroy_plan)(p->out);
    FFT(destroy_plan)(p->columns);
    FFT(destroy_plan)(p->back);
    gp_free(p->z);
    for (int c = 0; c < 3; c++)
        gp_free(p->kernel[c]);
}
