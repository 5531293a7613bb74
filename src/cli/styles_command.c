#include "cli/commands.h"

#include "cli/options.h"
#include "cli/sheet.h"
#include "cli/stages.h"
#include "cli/styles.h"
#include "core/memory.h"
#include "io/file.h"
#include "io/write.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// -- a tile -------------------------------------------------------------------

/* A picture that a run of the main job makes for the sheet. */
struct tile {
    struct gp_sheet *sheet;
    int i;
    const char *caption;
};

static gp_status take_picture(void *user, const struct gp_log *log,
                              const struct gp_frame *f,
                              const struct gp_planes *picture)
{
    const struct tile *const t = user;
    return gp_sheet_draw(log, t->sheet, t->i, t->caption, f, picture);
}

/* Runs the main job with `first`, an option and its value as one word, before
 * the options that were given. */
static gp_status make_tile(const struct gp_log *log, struct glarepp *gp,
    const struct gp_settings *s, const char *first, struct tile *t)
{
    gp_status st;
    struct gp_taker taker = {take_picture, t};
    struct gp_settings one = {0};
    struct gp_jobs jobs = {0};
    struct gp_progress none;
    char **word = NULL;
    int words = 1;
    GP_TRY(gp_alloc_zero(log, "command line",
                         (size_t) s->words.options.n / 2 + 4, sizeof *word,
                         &word));
    for (int i = 0; i < s->words.options.n; i += 2) {
        const char *const value = s->words.options.at[i + 1];
        if (asprintf(&word[words], value ? "--%s=%s" : "--%s",
                     s->words.options.at[i], value) < 0)
            GP_TRY(gp_no_memory(log, s->input.files.at[0]));
        words++;
    }
    const char *const last[] = {first, "--", s->input.files.at[0]};
    for (size_t i = 0; i < sizeof last / sizeof *last; i++) {
        if (!(word[words++] = strdup(last[i])))
            GP_TRY(gp_no_memory(log, s->input.files.at[0]));
    }
    GP_TRY(gp_options_parse(log, words, word, &one));
    one.run.append = t->i > 0;
    GP_TRY(gp_jobs_make(log, &one, &jobs));
    if (jobs.n != 1)
        GP_TRY(gp_fail(log, GP_ERR_USAGE, "%s: styles draws one frame (found "
                       "%d); give one file, and one view of it",
                       s->input.files.at[0], jobs.n));
    jobs.taker = &taker;
    gp_progress_open(&none, stderr, GP_PROGRESS_NEVER, true);
    st = gp_pipeline_run(log, gp, &one, &jobs, &none);
    gp_progress_close(&none);
out:
    gp_jobs_free(&jobs);
    gp_settings_free(&one);
    for (int i = 1; word && i < words; i++)
        free(word[i]);
    gp_free(word);
    return st;
}

// -- all of them --------------------------------------------------------------

static gp_status write_sheet(const struct gp_log *log,
    const struct gp_settings *s, const struct gp_sheet *sheet)
{
    struct gp_write_stats stats = {0};
    struct gp_write_params p = s->output.write;
    const struct gp_rect window = {0, 0, gp_sheet_w(sheet), gp_sheet_h(sheet)};
    const struct gp_frame f = {.path = (char *) s->input.files.at[0],
                               .data = window,
                               .display = window};
    char *command = NULL;
    gp_status st = gp_command_text(log, s, s->input.files.at, 1, &command);
    p.command = command;
    for (int i = 0; i < s->output.pictures.n && !st; i++)
        st = gp_write_picture(log, &p, s->output.pictures.at[i], &f,
                              &sheet->planes, GP_PICTURE_SHOWN, &stats);
    free(command);
    return st;
}

gp_status gp_styles_command(const struct gp_log *log, struct glarepp *gp,
                            const struct gp_settings *s)
{
    struct gp_sheet sheet = {.columns = 3, .tiles = 1};
    const struct gp_style *style = gp_styles;
    gp_status st;
    if (!s->input.files.n) {
        for (; style->name; style++)
            printf("%-10s  %s%s\n", style->name, style->text,
                   strcmp(style->name, GP_STYLE_USUAL) == 0 ? " (default)"
                                                            : "");
        return gp_flush_stdout(log);
    }
    while (gp_styles[sheet.tiles - 1].name)
        sheet.tiles++;
    struct tile t = {&sheet, 0, "no glare"};
    GP_TRY(make_tile(log, gp, s, "--gain=0", &t));
    for (; style->name; style++) {
        char word[64];
        snprintf(word, sizeof word, "--style=%s", style->name);
        t.i++;
        t.caption = style->name;
        GP_TRY(make_tile(log, gp, s, word, &t));
    }
    st = write_sheet(log, s, &sheet);
    if (!st && s->run.level == GP_LEVEL_WARN && isatty(STDERR_FILENO)) {
        char line[GP_LINE_BYTES];
        snprintf(line, sizeof line,
                 "%s: %d pictures of %s, the first without "
                 "glare",
                 s->output.pictures.at[0], sheet.tiles, s->input.files.at[0]);
        gp_make_printable(line);
        fprintf(stderr, "%s\n", line);
    }
out:
    gp_planes_free(&sheet.planes);
    return st;
}
