#include "app/bench.h"
#include "app/compare.h"
#include "app/help.h"
#include "app/jobs.h"
#include "app/options.h"
#include "app/pipeline.h"
#include "app/progress.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/file_temp.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
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

/* Every message is one line on stderr, and never in the middle of the
 * progress line; `user` is the progress, NULL before there is one. */
static void print_line(void *user, enum gp_level level, const char *line)
{
    char whole[4352];
    snprintf(whole, sizeof whole, "glarepp: %s%s",
             level == GP_LEVEL_WARN ? "warning: " : "", line);
    if (user)
        gp_progress_say(user, stderr, whole);
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

static gp_status make_frames(struct gp_log *log, const struct gp_settings *s)
{
    struct gp_jobs jobs = {0};
    struct gp_progress progress;
    gp_set_threads(s->threads);
    gp_status st = gp_jobs_make(log, s, &jobs);
    if (!st) {
        gp_progress_open(&progress, stderr, s->progress,
                         s->level == GP_LEVEL_ERROR);
        log->user = &progress;
        st = gp_pipeline_run(log, s, &jobs, &progress);
        log->user = NULL;
        gp_progress_close(&progress);
    }
    gp_jobs_free(&jobs);
    return st;
}

int main(int argc, char *argv[])
{
    struct gp_settings s;
    int status = 0; // of what has exit statuses of its own
    struct gp_log log = {print_line, NULL, GP_LEVEL_WARN};
    keep_streams();
    gp_keep_memory();
    gp_temp_cleanup_on_signal();
    // a reader that leaves is an error with a line, not a silent death
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); // and so is a file that may not grow
    gp_status st = gp_options_parse(&log, argc, argv, &s);
    log.level = s.level;
    if (!st && (s.help || s.help_man || s.version ||
                s.command == GP_COMMAND_HELP))
        st = print_text(&log, &s);
    else if (!st && s.command == GP_COMMAND_BENCH)
        st = gp_bench_run(&log, &s);
    else if (!st && s.command == GP_COMMAND_COMPARE)
        status = gp_compare_run(&log, &s);
    else if (!st)
        st = make_frames(&log, &s);
    gp_settings_free(&s);
    return st ? (int) st : status;
}
