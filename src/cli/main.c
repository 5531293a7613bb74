// SPDX-License-Identifier: Apache-2.0
#include "cli/commands.h"
#include "cli/machine.h"
#include "cli/words.h"
#include "cli/listener.h"
#include "core/json.h"
#include "core/parallel.h"
#include "io/file.h"

#include <fcntl.h>
#include <jansson.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* The user of the log. */
struct voice {
    struct gp_progress *progress; // NULL: none is drawn
    const char *file;  // the first input, put before errors that name no file
                       // and are about no frame; NULL: not known yet
};

/* Prints a line on stderr, not in the middle of the progress line. */
static void print_line(void *user, const struct gp_line *line)
{
    const struct voice *const voice = user;
    const bool names = line->level == GP_LEVEL_BARE && voice->file;
    char whole[2 * GP_LINE_BYTES];
    snprintf(whole, sizeof whole, "glarepp: %s%s%s%s",
             line->level == GP_LEVEL_WARN ? "warning: " : "",
             names ? voice->file : "", names ? ": " : "", line->text);
    gp_make_printable(whole);
    if (voice->progress)
        gp_progress_say(voice->progress, stderr, whole);
    else
        fprintf(stderr, "%s\n", whole);
}

/* Prints help, versions, the table or flares to stdout. */
static gp_status print_text(const struct gp_log *log, struct glarepp *gp,
                            const struct gp_settings *s)
{
    gp_status st = GP_OK;
    char io[256];
    const char *name;
    const char *const help = s->words.help;
    const char *const word = s->input.files.n ? s->input.files.at[0] : NULL;
    const bool asks = s->command == GP_COMMAND_HELP;
    if (asks || (help && *help && strcmp(help, "all") != 0))
        st = gp_help_topic(log, stdout, asks ? word : help);
    else if (help && !*help && s->command == GP_COMMAND_MAIN)
        gp_help_screen(stdout);
    else if (help)
        gp_help(stdout, s->command);
    else if (s->words.help_table)
        gp_help_table(stdout);
    else if (s->words.list_flares) {
        if (!glarepp_name(gp, GLAREPP_FLARES, 0, NULL))
            return gp_fail(log, GP_ERR_IO, "preset:list: no flares beside the "
                           "program; install it whole, or name their folder's "
                           "parent in GLAREPP_EXAMPLES");
        for (int i = 0; (name = glarepp_name(gp, GLAREPP_FLARES, i, NULL)); i++)
            puts(name);
    } else {
        gp_io_versions(io, sizeof io);
        printf("glarepp " GP_VERSION "\n"
               "with %s, jansson %s\n"
               "opened when "
               "needed: OpenImageIO, OpenColorIO, OSMesa, EGL\n"
               "Apache-2.0; no warranty\n",
               io, jansson_version_str());
    }
    return st ? st : gp_flush_text(log);
}

// -- the commands ------------------------------------------------------------

static gp_status make_frames(const struct gp_log *log, struct glarepp *gp,
                             struct voice *voice, const struct gp_settings *s)
{
    struct gp_jobs jobs = {0};
    struct gp_progress progress;
    const char *const saved = s->words.save_settings;
    gp_status st;
    GP_TRY(s->input.files.n ? gp_jobs_make(log, s, &jobs) // else only settings
                            : gp_output_guard_check(log, s, NULL, NULL));
    if (saved)
        GP_TRY(gp_file_check(log, saved, s->output.write.create_dir));
    if (s->input.files.n) {
        gp_progress_open(&progress, stderr, s->run.level == GP_LEVEL_ERROR
                             ? GP_PROGRESS_NEVER : s->run.progress);
        voice->progress = &progress;
        st = gp_pipeline_run(log, gp, s, &jobs, &progress);
        voice->progress = NULL;
        gp_progress_close(&progress);
    }
    if (!st && saved)
        st = gp_settings_save(log, s);
out:
    gp_jobs_free(&jobs);
    return st;
}

/* Opens the library with what the options and the environment say, and enters
 * it: loops of files run in its threads too. */
static gp_status open_library(struct gp_listener *user, struct glarepp **out)
{
    struct glarepp_params p = GLAREPP_PARAMS;
    const struct gp_settings *const s = user->s;
    p.threads = s->run.threads;
    gp_set_threads(p.threads); // of loops outside of the library's calls too
    p.level = s->run.level >= GP_LEVEL_INFO ? GLAREPP_NOTE : GLAREPP_WARNING;
    p.message = gp_hear; // (reports have warnings that are not printed)
    p.picture = gp_picture_read;
    p.release = gp_picture_release;
    p.user = user;
    // (a scene's textures are decoded once; GL has pages of its own)
    p.keep_memory = s->command != GP_COMMAND_SETS;
    gp_environment_read(&p);
    const int st = glarepp_open(&p, out);
    if (!st)
        glarepp_enter(*out);
    return (gp_status) st;
}

static gp_status run_command(const struct gp_log *log, struct glarepp *gp,
                             struct voice *voice, const struct gp_settings *s,
                             int *status)
{
    if (s->words.help || s->words.help_table || s->words.version ||
        s->words.list_flares || s->command == GP_COMMAND_HELP)
        return print_text(log, gp, s);
    gp_environment_set_gl(gp_threads()); // while there is one thread
    if (s->command == GP_COMMAND_MAIN)
        return make_frames(log, gp, voice, s);
    gp_command_run *const run =
        s->command == GP_COMMAND_BENCH     ? gp_bench_command
        : s->command == GP_COMMAND_COMPARE ? gp_compare_command
        : s->command == GP_COMMAND_KERNEL  ? gp_kernel_command
        : s->command == GP_COMMAND_LENS    ? gp_lens_command
        : s->command == GP_COMMAND_STYLES  ? gp_styles_command
                                           : gp_sets_command;
    return run(log, gp, s, status);
}

int main(int argc, char *argv[])
{
    struct gp_settings s;
    struct glarepp *gp = NULL;
    int status = 0;
    struct voice voice = {NULL, NULL};
    struct gp_log log = {print_line, &voice, GP_LEVEL_WARN};
    struct gp_listener user = {&log, &s};
    // a picture must not get the descriptor of a closed standard stream; that
    // is opened in the wrong direction, so that using it is an error
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++) {
        if (fcntl(fd, F_GETFD) < 0)
            (void) !open("/dev/null", fd ? O_RDONLY : O_WRONLY);
    }
    gp_environment_set_heap();
    gp_json_watch_memory();
    gp_temp_cleanup_on_signal();
    // a write that fails is an error with a message, not a silent death
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    gp_status st = gp_options_parse(&log, argc, argv, &s);
    log.level = s.run.level;
    voice.file = !st && s.input.files.n ? s.input.files.at[0] : NULL;
    if (!st)
        st = open_library(&user, &gp);
    if (!st)
        st = run_command(&log, gp, &voice, &s, &status);
    if (s.command == GP_COMMAND_COMPARE && st == GP_ERR_USAGE)
        status = GP_COMPARE_USAGE;
    else if (st)
        status = (int) st;
    if (gp)
        glarepp_leave(gp);
    glarepp_close(&gp);
    gp_settings_free(&s);
    return status;
}
