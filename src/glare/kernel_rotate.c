/* Rotates a kernel about its centre's pixel. */
#include "core/parallel.h"
#include "glare/glare_priv.h"

#include <math.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

bool gp_rotate_angle(float degrees, struct gp_unturned *u)
{
    static const double exact[] = {1.0, 0.0, -1.0, 0.0};
    const double turns = fmod((double) degrees, 360.0) / 90.0; // exact
    const int quarters = ((int) turns + 4) % 4;
    if (turns == (int) turns) {
        u->cos = exact[quarters];
        u->sin = exact[(quarters + 3) % 4];
        return true;
    }
    const double angle = fmod((double) degrees, 360.0) * PI / 180.0;
    u->cos = cos(angle);
    u->sin = sin(angle);
    return false;
}

// -- one sample ---------------------------------------------------------------

/* The place in the unturned kernel of a sample of the rotated one. */
struct spot {
    int x, y;       // of the upper left of four samples; may lie outside
    double fx, fy;  // from there, in [0, 1)
};

static struct spot find_spot(const struct gp_unturned *u, int dx, int dy)
{
    const double x = u->cx + (u->cos * dx - u->sin * dy);
    const double y = u->cy + (u->sin * dx + u->cos * dy);
    const double x0 = floor(x), y0 = floor(y);
    return (struct spot) {(int) x0, (int) y0, x - x0, y - y0};
}

static bool is_outside(const struct gp_unturned *u, const struct spot *s)
{
    return s->x < -1 || s->x >= u->w || s->y < -1 || s->y >= u->h;
}

static double tap(const struct gp_unturned *u, int c, int x, int y)
{
    return x >= 0 && x < u->w && y >= 0 && y < u->h
               ? (double) u->k.c[c][(size_t) y * (size_t) u->w + (size_t) x]
               : 0.0;
}

static double sample(const struct gp_unturned *u, int c, const struct spot *s)
{
    const double top = (1.0 - s->fx) * tap(u, c, s->x, s->y) +
                       s->fx * tap(u, c, s->x + 1, s->y);
    const double bottom = (1.0 - s->fx) * tap(u, c, s->x, s->y + 1) +
                          s->fx * tap(u, c, s->x + 1, s->y + 1);
    return (1.0 - s->fy) * top + s->fy * bottom;
}

double gp_rotate_reference(const struct gp_unturned *u, int c, int dx, int dy)
{
    const struct spot s = find_spot(u, dx, dy);
    return is_outside(u, &s) ? 0.0 : sample(u, c, &s);
}

// -- the whole kernel ---------------------------------------------------------

struct rotating {
    const struct gp_unturned *u;
    const struct gp_rotated *to;
    bool grey;
};

static void rotate_row(void *ctx, int y, int thread)
{
    const struct rotating *const t = ctx;
    const size_t at = (size_t) y * (size_t) t->to->w;
    const size_t bytes = (size_t) t->to->w * sizeof(float);
    (void) thread;
    for (int c = 0; c < 3; c++)
        memset(t->to->k.c[c] + at, 0, bytes);
    for (int x = 0; x < t->to->w; x++) {
        const struct spot s = find_spot(t->u, x - t->to->cx, y - t->to->cy);
        if (is_outside(t->u, &s))
            continue;
        for (int c = 0; c < (t->grey ? 1 : 3); c++)
            t->to->k.c[c][at + (size_t) x] = (float) sample(t->u, c, &s);
    }
    for (int c = 1; c < 3 && t->grey; c++)
        memcpy(t->to->k.c[c] + at, t->to->k.c[0] + at, bytes);
}

gp_status gp_rotate(const struct gp_log *log, const char *name,
    const struct gp_unturned *u, bool grey, struct gp_rotated *out)
{
    // whole offsets within the rotated corners of what bilinear sampling
    // reaches, one pixel around the samples; it is 0 on that line
    const double xs[] = {-1.0 - u->cx, (double) u->w - u->cx};
    const double ys[] = {-1.0 - u->cy, (double) u->h - u->cy};
    double box[4] = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < 4; i++) {
        const double x = xs[i & 1], y = ys[i >> 1];
        const double dx = u->cos * x + u->sin * y;
        const double dy = u->cos * y - u->sin * x;
        box[0] = fmin(box[0], ceil(dx));
        box[1] = fmin(box[1], ceil(dy));
        box[2] = fmax(box[2], floor(dx));
        box[3] = fmax(box[3], floor(dy));
    }
    const double w = box[2] - box[0] + 1.0, h = box[3] - box[1] + 1.0;
    if (w * h > GP_ROTATED_PIXELS)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: the rotated kernel is too large (%.0fx%.0f); use a "
                       "smaller kernel, or --rotate 0, 90, 180 or 270", name, w,
                       h);
    struct gp_rotated t = {
        .w = (int) w, .h = (int) h, .cx = -(int) box[0], .cy = -(int) box[1],
    };
    gp_status st = gp_planes_make(log, name, (size_t) t.w * (size_t) t.h, &t.k);
    if (st)
        return st;
    struct rotating rotating = {u, &t, grey};
    gp_parallel_do(t.h, rotate_row, &rotating);
    *out = t;
    return GP_OK;
}
