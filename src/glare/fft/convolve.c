// SPDX-License-Identifier: Apache-2.0
/* Matrices, and the passes over them. */
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/fft/pass.h"

static size_t round_up(size_t n, size_t step)
{
    return (n + step - 1) / step * step;
}

/* Lines of a block. */
static int lines_of(bool in_double)
{
    return in_double ? GP_DOUBLE_LINES : GP_FLOAT_LINES;
}

gp_status gp_fft_matrix_make(const struct gp_log *log, struct gp_fft_numbers of,
                             int channels, int nx, int rows,
                             struct gp_fft_matrix *out)
{
    enum { SET = 64 }; // points of a page
    const size_t lines = (size_t) lines_of(of.in_double);
    struct gp_fft_matrix m = {.of = of};
    m.blocks = (int) (round_up((size_t) nx / 2 + 1, lines) / lines);
    m.pitch = round_up((size_t) rows / (of.real ? 2 : 1), 2 * lines);
    if (m.pitch % SET == 0)
        m.pitch += 2 * lines; // blocks must not share the sets of a cache
    const size_t plane = (size_t) m.blocks * m.pitch;
    gp_status st = gp_alloc(log, "spectrum", (size_t) channels * plane,
                            GP_POINT_BYTES, &m.z[0]);
    if (st)
        return st;
    for (int c = 1; c < channels; c++)
        m.z[c] = (char *) m.z[0] + (size_t) c * plane * GP_POINT_BYTES;
    *out = m;
    return GP_OK;
}

void gp_fft_matrix_free(struct gp_fft_matrix *m)
{
    gp_free(m->z[0]);
    *m = (struct gp_fft_matrix) {0};
}

struct gp_fft_matrix gp_fft_one_channel(const struct gp_fft_matrix *m, int c)
{
    struct gp_fft_matrix view = *m;
    view.z[0] = NULL;
    view.z[c] = m->z[0];
    return view;
}

gp_status gp_fft_pair_make(const struct gp_log *log, int nx, int ny,
                           bool in_double, struct gp_transform out[2])
{
    const int n[2] = {nx, ny};
    gp_status st = GP_OK;
    for (int i = 0; i < 2 && !st; i++)
        st = in_double ? gp_double_transform_make(log, n[i], &out[i])
                       : gp_float_transform_make(log, n[i], &out[i]);
    return st;
}

void gp_fft_pair_free(struct gp_transform pair[2])
{
    gp_transform_free(&pair[0]);
    gp_transform_free(&pair[1]);
}

static gp_status run_pass(struct gp_pass *s, gp_task in_float,
                          gp_task in_double)
{
    const struct gp_fft_request *const req = s->req;
    gp_status st =
        gp_alloc(req->log, "transform", 2 * gp_transform_room(s->t->n),
                 (size_t) gp_threads(), &s->scratch);
    if (st)
        return st;
    gp_parallel_do(s->tasks * req->channels,
                   req->in_double ? in_double : in_float, s);
    gp_free(s->scratch);
    return GP_OK;
}

static int row_tasks(const struct gp_fft_request *req, int rows)
{
    const int block = 2 * lines_of(req->in_double);
    return (rows + block - 1) / block;
}

gp_status gp_fft_rows_in(const struct gp_fft_request *req, int rows,
                         gp_fft_load load, const void *ctx,
                         struct gp_fft_matrix *m)
{
    struct gp_pass s = {
        .req = req,
        .t = &req->t[0],
        .m = m,
        .rows = {.n = rows},
        .load = load,
        .ctx = ctx,
        .tasks = row_tasks(req, rows),
    };
    return run_pass(&s, gp_float_rows_in, gp_double_rows_in);
}

gp_status gp_fft_make_kernel(const struct gp_fft_request *req,
                             struct gp_fft_rows rows, double scale,
                             struct gp_fft_matrix *m)
{
    struct gp_pass s = {
        .req = req,
        .t = &req->t[1],
        .m = m,
        .rows = rows,
        .scale = scale,
        .tasks = m->blocks,
    };
    return run_pass(&s, gp_float_make_kernel, gp_double_make_kernel);
}

gp_status gp_fft_multiply(const struct gp_fft_request *req,
                          struct gp_fft_rows rows,
                          const struct gp_fft_matrix *kernel, int first,
                          int count, struct gp_fft_matrix *m)
{
    struct gp_pass s = {
        .req = req,
        .t = &req->t[1],
        .m = m,
        .kernel = kernel,
        .rows = rows,
        .first = first,
        .count = count,
        .tasks = m->blocks,
    };
    return run_pass(&s, gp_float_multiply, gp_double_multiply);
}

gp_status gp_fft_rows_out(const struct gp_fft_request *req,
                          const struct gp_fft_matrix *m, int rows,
                          gp_fft_store store, const void *ctx)
{
    struct gp_fft_matrix from = *m;
    struct gp_pass s = {
        .req = req,
        .t = &req->t[0],
        .m = &from,
        .rows = {.n = rows},
        .store = store,
        .ctx = ctx,
        .tasks = row_tasks(req, rows),
    };
    return run_pass(&s, gp_float_rows_out, gp_double_rows_out);
}
