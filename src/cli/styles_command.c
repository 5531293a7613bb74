// SPDX-License-Identifier: Apache-2.0
#include "cli/commands.h"

#include "cli/page/page.h"
#include "cli/stages.h"
#include "cli/words.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "io/file.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// -- the sheet: rows of tiles of one size, with captions ------------------------

/* Tiles are at most so wide, in pixels. */
enum { TILE = 640, COLUMNS = 3 };

struct sheet {
    int w, h;                // of a tile; 0: none is there yet
    int tiles;               // all that there will be
    int i;                   // present tile
    const char *caption;     // of a to z, spaces and dashes; cut where too long
    struct gp_report report; // with a line for each
    struct gp_planes planes; // display-linear, of the whole sheet; owned
    bool page;               // pictures go into `set` too
    char *command;           // of the present tile; owned
    struct gp_page_set set;
};

static bool is_page(const char *path)
{
    char ending[8];
    gp_file_ending(path, ending, sizeof ending);
    return strcmp(ending, "html") == 0;
}

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

static int sheet_w(const struct sheet *s)
{
    return COLUMNS * (s->w + GAP) + GAP;
}

static int sheet_h(const struct sheet *s)
{
    const int rows = (s->tiles + COLUMNS - 1) / COLUMNS;
    return rows * (s->h + LINE + GAP) + GAP;
}

static void draw_caption(struct sheet *s, int left, int top,
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
            const size_t at = (size_t) (top + y) * (size_t) sheet_w(s) +
                              (size_t) (left + 6 * DOT * n + x);
            for (int p = 0; p < 3; p++)
                s->planes.c[p][at] = INK;
        }
    }
}

/* Sets pixel `at` to the mean of a rectangle, from the data window's corner. */
static void set_mean(const struct gp_frame *f, const struct gp_planes *p,
                     const double from[2], const double size[2],
                     struct gp_planes *out, size_t at)
{
    double sum[3] = {0};
    const int w = gp_frame_w(f);
    const double to[2] = {from[0] + size[0], from[1] + size[1]};
    const int last_x = gp_min((int) ceil(to[0]), w);
    const int last_y = gp_min((int) ceil(to[1]), gp_frame_h(f));
    for (int y = gp_max((int) floor(from[1]), 0); y < last_y; y++) {
        const double high = fmin(y + 1.0, to[1]) - fmax(y, from[1]);
        for (int x = gp_max((int) floor(from[0]), 0); x < last_x; x++) {
            const double share =
                high * (fmin(x + 1.0, to[0]) - fmax(x, from[0]));
            for (int c = 0; c < 3; c++)
                sum[c] += share * (double) p->c[c][(size_t) y * (size_t) w +
                                                   (size_t) x];
        }
    }
    for (int c = 0; c < 3; c++)
        out->c[c][at] = (float) (sum[c] / (size[0] * size[1]));
}

/* Draws a tile: the display window of f from `picture`, the samples of its data
 * window, scaled down by areas; outside of the data window it is black. The
 * first tile sets the size of all. */
static gp_status draw_tile(void *user, const struct gp_log *log,
                           const struct gp_frame *f,
                           const struct gp_planes *picture)
{
    struct sheet *const s = user;
    const double w = gp_rect_w(f->display), h = gp_rect_h(f->display);
    if (!s->w) {
        s->w = gp_min(TILE, gp_rect_w(f->display));
        s->h = gp_max((int) lrint(s->w * h / w), 1);
        const size_t pixels = (size_t) sheet_w(s) * (size_t) sheet_h(s);
        const gp_status st = gp_planes_make(log, "sheet", pixels, &s->planes);
        if (st)
            return st;
        for (size_t i = 0; i < 3 * pixels; i++)
            s->planes.c[i / pixels][i % pixels] = PAPER;
    }
    const int left = GAP + s->i % COLUMNS * (s->w + GAP);
    const int top = GAP + s->i / COLUMNS * (s->h + LINE + GAP);
    const double size[2] = {w / s->w, h / s->h};
    const int dx = f->display.x0 - f->data.x0, dy = f->display.y0 - f->data.y0;
    for (int y = 0; y < s->h; y++) {
        for (int x = 0; x < s->w; x++) {
            const size_t at = (size_t) (top + LINE + y) *
                                  (size_t) sheet_w(s) + (size_t) (left + x);
            set_mean(f, picture,
                     (double[2]) {dx + x * size[0], dy + y * size[1]}, size,
                     &s->planes, at);
        }
    }
    draw_caption(s, left, top, s->caption);
    if (!s->page)
        return GP_OK;
    const struct glarepp_image light = gp_frame_view(f, picture);
    s->set.window = f->data;
    return gp_page_set_add(
        log, &s->set,
        json_pack("{ss so}", "name", s->caption, "command",
                  json_sprintf("%s -o %s.png", s->command,
                               s->i ? s->caption : "before")),
        &light, NULL, NULL);
}

/* Runs the main job with an option more than was given. */
static gp_status make_tile(const struct gp_log *log, struct glarepp *gp,
                           const struct gp_settings *s, const char *option,
                           const char *value, struct sheet *sheet)
{
    gp_status st;
    struct gp_taker taker = {draw_tile, sheet, &sheet->report};
    struct gp_settings one;
    struct gp_jobs jobs = {0};
    struct gp_progress none;
    GP_TRY(gp_options_more(log, s, option, value, &one));
    one.output.write.pages = true;
    GP_TRY(gp_jobs_make(log, &one, &jobs));
    if (jobs.n != 1)
        GP_TRY(gp_fail(log, GP_ERR_USAGE, "%s: styles draws one frame (found "
                       "%d); give one file, and one view of it",
                       s->input.files.at[0], jobs.n));
    jobs.taker = &taker;
    free(sheet->command);
    sheet->command = NULL;
    GP_TRY(gp_command_text(log, &one, one.input.files.at, one.input.files.n,
                           GP_COMMAND_WHOLE, &sheet->command));
    gp_progress_open(&none, stderr, GP_PROGRESS_NEVER);
    st = gp_pipeline_run(log, gp, &one, &jobs, &none);
    gp_progress_close(&none);
out:
    gp_jobs_free(&jobs);
    return st;
}

// -- all of them --------------------------------------------------------------

static gp_status write_sheet(const struct gp_log *log,
    const struct gp_settings *s, const struct sheet *sheet)
{
    struct gp_write_stats stats = {0};
    struct gp_write_params p = s->output.write;
    struct gp_frame f = gp_frame_blank(
        (struct gp_rect) {0, 0, sheet_w(sheet), sheet_h(sheet)});
    f.path = (char *) s->input.files.at[0];
    char *command = NULL;
    gp_status st;
    GP_TRY(gp_command_text(log, s, s->input.files.at, 1, GP_COMMAND_NAMES,
                           &command));
    p.command = command;
    for (int i = 0; i < s->output.pictures.n; i++) {
        const char *const path = s->output.pictures.at[i];
        json_t *page, *set;
        if (!is_page(path)) {
            GP_TRY(gp_write_picture(log, &p, path, &f, &sheet->planes,
                                    GP_PICTURE_SHOWN, &stats));
            continue;
        }
        GP_TRY(gp_page_pack(log, &sheet->set, gp_page_room(s, sheet->tiles),
                            &set));
        set = json_pack("[{so so}]", "set", set, "notes", json_array());
        GP_TRY(gp_page_make(log, s, "styles",
                            gp_base_name(s->input.files.at[0]), &page));
        json_object_set_new(page, "entries", set);
        GP_TRY(gp_page_save(log, s, path, page));
    }
out:
    free(command);
    return st;
}

gp_status gp_styles_command(const struct gp_log *log, struct glarepp *gp,
                            const struct gp_settings *s, int *status)
{
    struct sheet sheet = {.tiles = 1};
    const struct gp_style *style = gp_styles;
    gp_status st;
    (void) status;
    if (!s->input.files.n) {
        for (; style->name; style++)
            printf("%-10s  %s%s\n", style->name, style->text,
                   strcmp(style->name, GP_STYLE_USUAL) == 0 ? " (default)"
                                                            : "");
        return gp_flush_stdout(log);
    }
    while (gp_styles[sheet.tiles - 1].name)
        sheet.tiles++;
    if (s->run.report)
        GP_TRY(gp_report_open(log, s->run.report, false, &sheet.report));
    for (int i = 0; i < s->output.pictures.n; i++)
        sheet.page |= is_page(s->output.pictures.at[i]);
    sheet.caption = "no glare";
    GP_TRY(make_tile(log, gp, s, "gain", "0", &sheet));
    for (; style->name; style++) {
        sheet.i++;
        sheet.caption = style->name;
        GP_TRY(make_tile(log, gp, s, "style", style->name, &sheet));
    }
    st = write_sheet(log, s, &sheet);
    if (!st && s->output.pictures.n && s->run.level == GP_LEVEL_WARN &&
        isatty(STDERR_FILENO))
        fprintf(stderr, "%s: %d pictures of %s, the first without glare\n",
                gp_printable(s->output.pictures.at[0]).text, sheet.tiles,
                gp_printable(s->input.files.at[0]).text);
out:;
    const gp_status closed = gp_report_close(st ? NULL : log, &sheet.report);
    gp_planes_free(&sheet.planes);
    gp_page_set_free(&sheet.set);
    free(sheet.command);
    return st ? st : closed;
}
