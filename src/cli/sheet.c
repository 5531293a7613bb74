#include "cli/sheet.h"

#include "core/minmax.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Pixels between tiles, and of a line of captions: letters of 5 x 7 dots, each
 * dot DOT x DOT pixels. */
enum { GAP = 8, DOT = 2, LINE = 7 * DOT + 10 };

// display-linear: a grey that hides no halo's end, and text on it
static const float PAPER = 0.015f, INK = 0.7f;

/* Letters as columns of dots, the lowest bit at the top. */
static const uint8_t letters[26][5] = {
    {0x20, 0x54, 0x54, 0x54, 0x78}, {0x7f, 0x48, 0x44, 0x44, 0x38}, // a, b
    {0x38, 0x44, 0x44, 0x44, 0x20}, {0x38, 0x44, 0x44, 0x48, 0x7f},
    {0x38, 0x54, 0x54, 0x54, 0x18}, {0x08, 0x7e, 0x09, 0x01, 0x02},
    {0x0c, 0x52, 0x52, 0x52, 0x3e}, {0x7f, 0x08, 0x04, 0x04, 0x78},
    {0x00, 0x44, 0x7d, 0x40, 0x00}, {0x20, 0x40, 0x44, 0x3d, 0x00}, // i, j
    {0x7f, 0x10, 0x28, 0x44, 0x00}, {0x00, 0x41, 0x7f, 0x40, 0x00},
    {0x7c, 0x04, 0x18, 0x04, 0x78}, {0x7c, 0x08, 0x04, 0x04, 0x78},
    {0x38, 0x44, 0x44, 0x44, 0x38}, {0x7c, 0x14, 0x14, 0x14, 0x08},
    {0x08, 0x14, 0x14, 0x18, 0x7c}, {0x7c, 0x08, 0x04, 0x04, 0x08}, // q, r
    {0x48, 0x54, 0x54, 0x54, 0x20}, {0x04, 0x3f, 0x44, 0x40, 0x20},
    {0x3c, 0x40, 0x40, 0x20, 0x7c}, {0x1c, 0x20, 0x40, 0x20, 0x1c},
    {0x3c, 0x40, 0x30, 0x40, 0x3c}, {0x44, 0x28, 0x10, 0x28, 0x44},
    {0x0c, 0x50, 0x50, 0x50, 0x3c}, {0x44, 0x64, 0x54, 0x4c, 0x44}, // y, z
};
static const uint8_t dash[5] = {0x08, 0x08, 0x08, 0x08, 0x08}, space[5];

int gp_sheet_w(const struct gp_sheet *s)
{
    return s->columns * (s->w + GAP) + GAP;
}

int gp_sheet_h(const struct gp_sheet *s)
{
    const int rows = (s->tiles + s->columns - 1) / s->columns;
    return rows * (s->h + LINE + GAP) + GAP;
}

static void draw_caption(struct gp_sheet *s, int left, int top,
                         const char *text)
{
    for (int n = 0; text[n] && (6 * n + 5) * DOT <= s->w; n++) {
        const char c = text[n];
        const uint8_t *const column = c >= 'a' && c <= 'z' ? letters[c - 'a']
                                      : c == '-' ? dash : space;
        for (int i = 0; i < 5 * DOT * 7 * DOT; i++) {
            const int x = i % (5 * DOT), y = i / (5 * DOT);
            if (!(column[x / DOT] >> (y / DOT) & 1))
                continue;
            const size_t at = (size_t) (top + y) * (size_t) gp_sheet_w(s) +
                              (size_t) (left + 6 * DOT * n + x);
            for (int p = 0; p < 3; p++)
                s->planes.c[p][at] = INK;
        }
    }
}

/* The mean of a data window's samples over [x0, x1) x [y0, y1), in pixels from
 * its corner. */
static void mean_of(const struct gp_planes *p, int w, int h, double x0,
                    double y0, double x1, double y1, float *const out[3])
{
    double sum[3] = {0};
    const int last_x = gp_min((int) ceil(x1), w);
    const int last_y = gp_min((int) ceil(y1), h);
    for (int y = gp_max((int) floor(y0), 0); y < last_y; y++) {
        const double high = fmin(y + 1.0, y1) - fmax(y, y0);
        for (int x = gp_max((int) floor(x0), 0); x < last_x; x++) {
            const double share = high * (fmin(x + 1.0, x1) - fmax(x, x0));
            for (int c = 0; c < 3; c++)
                sum[c] += share * (double) p->c[c][(size_t) y * (size_t) w +
                                                   (size_t) x];
        }
    }
    for (int c = 0; c < 3; c++)
        *out[c] = (float) (sum[c] / ((x1 - x0) * (y1 - y0)));
}

/* Makes the sheet for tiles of f's display window. */
static gp_status begin(const struct gp_log *log, const struct gp_frame *f,
                       struct gp_sheet *s)
{
    const double w = gp_rect_w(f->display), h = gp_rect_h(f->display);
    s->w = gp_min(GP_SHEET_WIDTH, gp_rect_w(f->display));
    s->h = gp_max((int) lrint(s->w * h / w), 1);
    const size_t pixels = (size_t) gp_sheet_w(s) * (size_t) gp_sheet_h(s);
    const gp_status st = gp_planes_make(log, "sheet", pixels, &s->planes);
    for (int c = 0; c < 3 && !st; c++) {
        for (size_t i = 0; i < pixels; i++)
            s->planes.c[c][i] = PAPER;
    }
    return st;
}

gp_status gp_sheet_draw(const struct gp_log *log, struct gp_sheet *s, int i,
    const char *caption, const struct gp_frame *f,
    const struct gp_planes *picture)
{
    const gp_status st = s->w ? GP_OK : begin(log, f, s);
    if (st)
        return st;
    const int left = GAP + i % s->columns * (s->w + GAP);
    const int top = GAP + i / s->columns * (s->h + LINE + GAP);
    const double across = (double) gp_rect_w(f->display) / s->w;
    const double down = (double) gp_rect_h(f->display) / s->h;
    const int dx = f->display.x0 - f->data.x0, dy = f->display.y0 - f->data.y0;
    for (int y = 0; y < s->h; y++) {
        for (int x = 0; x < s->w; x++) {
            const size_t at = (size_t) (top + LINE + y) *
                                  (size_t) gp_sheet_w(s) + (size_t) (left + x);
            float *const out[3] = {&s->planes.c[0][at], &s->planes.c[1][at],
                                   &s->planes.c[2][at]};
            mean_of(picture, gp_frame_w(f), gp_frame_h(f), dx + x * across,
                    dy + y * down, dx + (x + 1) * across, dy + (y + 1) * down,
                    out);
        }
    }
    draw_caption(s, left, top, caption);
    return GP_OK;
}
