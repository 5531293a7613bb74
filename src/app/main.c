#include "app/bench.h"
#include "app/compare.h"
#include "app/jobs.h"
#include "app/options.h"
#include "app/pipeline.h"
#include "app/progress.h"
#include "core/bridge.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "gl/gl.h"
#include "io/file_temp.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* A standard stream that is closed must not become a picture's descriptor:
 * opened the wrong way round, it gives an error to who uses it. */
static void keep_streams(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++) {
        if (fcntl(fd, F_GETFD) < 0)
            (void) !open("/dev/null", fd ? O_RDONLY : O_WRONLY);
    }
}

struct voice {
    struct gp_progress *progress; // NULL: none is drawn
    const char *file;  // the first input, for errors that name no file and are
                       // about no frame; NULL before the command line is read
};

/* Every message is one line on stderr, and never in the middle of the
 * progress line. */
static void print_line(void *user, enum gp_level level, const char *line)
{
    const struct voice *const voice = user;
    const bool names = level == GP_LEVEL_BARE && voice->file;
    char whole[2 * GP_LINE_BYTES];
    snprintf(whole, sizeof whole, "glarepp: %s%s%s%s",
             level == GP_LEVEL_WARN ? "warning: " : "",
             names ? voice->file : "", names ? ": " : "", line);
    if (voice->progress)
        gp_progress_say(voice->progress, stderr, whole);
    else
        fprintf(stderr, "%s\n", whole);
}

/* What asks for text only. */
static gp_status print_text(const struct gp_log *log,
                            const struct gp_settings *s)
{
    gp_status st = GP_OK;
    if (s->command == GP_COMMAND_HELP && s->completion)
        gp_complete(stdout, s->completion);
    else if (s->command == GP_COMMAND_HELP)
        st = gp_help_topic(log, stdout, s->inputs.n ? s->inputs.at[0] : NULL);
    else if (s->help)
        gp_help(stdout, s->command);
    else if (s->help_man)
        gp_help_man(stdout);
    else
        gp_version(stdout);
    if (st)
        return st;
    if (fflush(stdout) != 0 || ferror(stdout))
        return gp_fail(log, GP_ERR_IO,
                       "-: cannot write to stdout (%s); check who reads it",
                       strerror(errno));
    return GP_OK;
}

static const struct gp_log *last_log; // for what has no way back to main()

/* The end where no error can be returned: one line, and nothing half-written. */
static void end_for_memory(const char *line)
{
    gp_status st = gp_fail(last_log, GP_ERR_BUG, "%s", line);
    gp_temp_remove_all();
    _exit((int) st);
}

static gp_status make_frames(const struct gp_log *log, struct voice *voice,
                             const struct gp_settings *s)
{
    struct gp_jobs jobs = {0};
    struct gp_progress progress;
    gp_set_threads(s->threads);
    gp_gl_prepare(); // while there is one thread
    gp_status st = gp_jobs_make(log, s, &jobs);
    if (!st) {
        gp_progress_open(&progress, stderr, s->progress,
                         s->level == GP_LEVEL_ERROR);
        voice->progress = &progress;
        st = gp_pipeline_run(log, s, &jobs, &progress);
        voice->progress = NULL;
        gp_progress_close(&progress);
    }
    gp_jobs_free(&jobs);
    return st;
}

int main(int argc, char *argv[])
{
    struct gp_settings s;
    int status = 0; // of what has exit statuses of its own
    struct voice voice = {NULL, NULL};
    struct gp_log log = {print_line, &voice, GP_LEVEL_WARN};
    keep_streams();
    gp_keep_memory();
    gp_temp_cleanup_on_signal();
    last_log = &log;
    gp_bridge_on_no_memory(end_for_memory);
    // a reader that leaves is an error with a line, not a silent death
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); // and so is a file that may not grow
    gp_status st = gp_options_parse(&log, argc, argv, &s);
    log.level = s.level;
    voice.file = !st && s.inputs.n ? s.inputs.at[0] : NULL;
    gp_bridge_about(voice.file);
    if (!st && (s.help || s.help_man || s.version ||
                s.command == GP_COMMAND_HELP))
        st = print_text(&log, &s);
    else if (!st && s.command == GP_COMMAND_BENCH)
        st = gp_bench_run(&log, &s);
    else if (!st && s.command == GP_COMMAND_COMPARE)
        status = gp_compare_run(&log, &s);
    else if (!st)
        st = make_frames(&log, &voice, &s);
    gp_settings_free(&s);
    return st ? (int) st : status;
}
