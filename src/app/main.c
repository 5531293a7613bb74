#include "app/clobber.h"
#include "app/commands.h"
#include "app/compare_report.h"
#include "app/environment.h"
#include "app/hints.h"
#include "app/jobs.h"
#include "app/options.h"
#include "app/progress.h"
#include "app/stages.h"
#include "bench/bench.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "gl/gl.h"
#include "io/file.h"
#include "io/read.h"
#include "io/write.h"

#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* The user of the log. */
struct voice {
    struct gp_progress *progress; // NULL: none is drawn
    const char *file;  // the first input, put before errors that name no file
                       // and are about no frame; NULL: not known yet
};

/* Prints a message as one line on stderr, not in the middle of the progress
 * line. */
static void print_line(void *user, const struct gp_line *line)
{
    const struct voice *const voice = user;
    const bool names = line->level == GP_LEVEL_BARE && voice->file;
    char whole[2 * GP_LINE_BYTES];
    snprintf(whole, sizeof whole, "glarepp: %s%s%s%s%s",
             line->level == GP_LEVEL_WARN ? "warning: " : "",
             names ? voice->file : "", names ? ": " : "", line->text,
             gp_hint(line->parameter, line->text));
    gp_make_printable(whole);
    if (voice->progress)
        gp_progress_say(voice->progress, stderr, whole);
    else
        fprintf(stderr, "%s\n", whole);
}

/* Prints the installed flares to stdout, one a line. */
static gp_status list_flares(const struct gp_log *log)
{
    char list[4096];
    const gp_status st = gp_flare_presets(log, "list", "\n", list, sizeof list);
    if (!st)
        puts(list);
    return st;
}

/* Prints help, versions, the table or flares to stdout. */
static gp_status print_text(const struct gp_log *log,
                            const struct gp_settings *s)
{
    gp_status st = GP_OK;
    char io[256];
    if (s->command == GP_COMMAND_HELP)
        st = gp_help_topic(log, stdout,
                           s->input.files.n ? s->input.files.at[0] : NULL);
    else if (s->words.help && s->words.help[0] &&
             strcmp(s->words.help, "all") != 0)
        st = gp_help_topic(log, stdout, s->words.help);
    else if (s->words.help && !s->words.help[0] &&
             s->command == GP_COMMAND_MAIN)
        gp_help_screen(stdout);
    else if (s->words.help)
        gp_help(stdout, s->command);
    else if (s->words.help_table)
        gp_help_table(stdout);
    else if (s->words.list_flares)
        st = list_flares(log);
    else {
        gp_io_versions(io, sizeof io);
        printf("glarepp " GP_VERSION "\n" "with %s, jansson %s\n" "opened when "
               "needed: FFTW 3, OpenImageIO, OpenColorIO, OSMesa, EGL\n"
               "GPL-3.0-or-later; no warranty\n", io, jansson_version_str());
    }
    return st ? st : gp_flush_text(log);
}

// -- the commands ------------------------------------------------------------

static gp_status make_frames(const struct gp_log *log, struct voice *voice,
                             const struct gp_settings *s)
{
    struct gp_jobs jobs = {0};
    struct gp_progress progress;
    gp_environment_set_gl(gp_threads()); // while there is one thread
    gp_status st = gp_jobs_make(log, s, &jobs);
    if (!st) {
        gp_progress_open(&progress, stderr, s->run.progress,
                         s->run.level == GP_LEVEL_ERROR);
        voice->progress = &progress;
        st = gp_pipeline_run(log, s, &jobs, &progress);
        voice->progress = NULL;
        gp_progress_close(&progress);
    }
    gp_jobs_free(&jobs);
    return st;
}

/* Measures the main job with each of several numbers of threads. */
static gp_status run_scaling(const struct gp_log *log,
                             const struct gp_settings *s)
{
    gp_status st;
    struct gp_scaling_request req = {
        .input = s->input.files.at[0],
        .threads = s->run.threads,
        .runs = s->bench.runs,
        .json = s->bench.json,
    };
    char **word = NULL;
    int words = 0;
    GP_TRY(gp_alloc_zero(log, "command line", (size_t) s->words.options.n + 1,
                         sizeof *word, &word));
    for (int i = 0; i < s->words.options.n; i += 2) {
        const char *const name = s->words.options.at[i];
        const char *const value = s->words.options.at[i + 1];
        const struct gp_option *const o = gp_option_find(name, strlen(name));
        if (!(o->commands & GP_COMMAND_MAIN) || o->kind == GP_KIND_COUNTS)
            continue;
        if (asprintf(&word[words], value ? "--%s=%s" : "--%s", name, value) < 0)
            GP_TRY(gp_no_memory(log, req.input));
        words++;
    }
    req.word = (const char *const *) word;
    req.words = words;
    st = gp_scaling_run(log, &req);
out:
    while (words > 0)
        free(word[--words]);
    gp_free(word);
    return st;
}

static gp_status run_bench(const struct gp_log *log,
                           const struct gp_settings *s)
{
    char *const input = s->input.files.n ? (char *) s->input.files.at[0] : NULL;
    struct gp_job suns = {.input = input};
    struct gp_sun_files files = {s, &suns};
    const struct gp_sun_reader reader = gp_sun_reader_of(&files);
    struct gp_wanted_kernel wanted = {0};
    struct gp_bench_layers layers = {0};
    gp_status st = gp_wanted_kernel_read(log, s, &wanted);
    if (!st)
        st = gp_bench_layers_begin(log, s, input, &layers);
    if (st) {
        gp_wanted_kernel_free(&wanted);
        return st;
    }
    const struct gp_kernel_params image = gp_wanted_params(s, &wanted);
    const struct gp_bench_request req = {
        .params = &s->bench,
        .input = input,
        .default_kernel = !gp_option_given(s, "kernel"),
        .read = &s->input.read,
        .sensor = &s->light.sensor,
        .kernel = &image,
        .kernel_name = gp_option_given(s, "kernel") ? s->kernel.words.at[0]
                                                    : s->light.style,
        .kernel_image = &wanted.image[0],
        .recipe = wanted.recipe,
        .recipes = wanted.recipes,
        .fov = (double) s->kernel.fov,
        .glare = &s->glare,
        .compose = &s->light.compose,
        .tone = &s->tone.map,
        .sun = &s->sun,
        .reader = &reader,
        .layer = layers.row,
        .layers = layers.rows,
    };
    st = gp_clobber_check(log, s, "input", input);
    gp_environment_set_gl(gp_threads()); // while there is one thread
    if (!st)
        st = gp_bench_run(log, &req);
    gp_bench_layers_end(&layers);
    gp_wanted_kernel_free(&wanted);
    return st;
}

/* Returns the path of `name` in $XDG_CACHE_HOME/glarepp, or in ~/.cache/glarepp
 * where that variable is unset or not an absolute path (XDG Base Directory
 * Specification 0.8); from malloc. Makes the folders with mode 0700. NULL when
 * they cannot be made: a run without a cache is only slower. */
static char *cache_file(const char *name)
{
    const char *base = getenv("XDG_CACHE_HOME"), *below = "";
    char *path;
    if (!base || base[0] != '/') {
        base = getenv("HOME");
        below = "/.cache";
    }
    if (!base || base[0] != '/' ||
        asprintf(&path, "%s%s/glarepp/%s", base, below, name) < 0)
        return NULL;
    for (char *s = path + 1; (s = strchr(s, '/')); s++) {
        *s = '\0';
        const bool there = mkdir(path, 0700) == 0 || errno == EEXIST;
        *s = '/';
        if (!there) {
            free(path);
            return NULL;
        }
    }
    return path;
}

int main(int argc, char *argv[])
{
    static struct gp_env env;
    struct gp_settings s;
    char *wisdom = NULL;
    int status = 0;
    bool differs = false; // from a claim, or rows of a table
    struct voice voice = {NULL, NULL};
    struct gp_log log = {print_line, &voice, GP_LEVEL_WARN};
    // a picture must not get the descriptor of a closed standard stream; that
    // is opened in the wrong direction, so that using it is an error
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++) {
        if (fcntl(fd, F_GETFD) < 0)
            (void) !open("/dev/null", fd ? O_RDONLY : O_WRONLY);
    }
    gp_environment_read(&env);
    gp_env_use(&env);
    gp_keep_memory();
    gp_write_keep_memory();
    gp_temp_cleanup_on_signal();
    // a write that fails is an error with a message, not a silent death
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    gp_status st = gp_options_parse(&log, argc, argv, &s);
    log.level = s.run.level;
    gp_set_threads(st ? 1 : s.run.threads.v[0]);
    voice.file = !st && s.input.files.n ? s.input.files.at[0] : NULL;
    if (!st && s.glare.fft_plan == GP_FFT_PLAN_MEASURE)
        s.glare.wisdom = wisdom = cache_file("fft-wisdom");
    if (!st && (s.words.help || s.words.help_table || s.words.version ||
                s.words.list_flares || s.command == GP_COMMAND_HELP)) {
        st = print_text(&log, &s);
    } else if (!st && s.command == GP_COMMAND_BENCH && s.run.threads.n > 1) {
        st = run_scaling(&log, &s);
    } else if (!st && s.command == GP_COMMAND_BENCH) {
        st = run_bench(&log, &s);
    } else if (!st && s.command == GP_COMMAND_COMPARE) {
        status = gp_compare_command(&log, &s);
    } else if (!st && s.command == GP_COMMAND_KERNEL) {
        st = gp_kernel_command(&log, &s, &differs);
    } else if (!st && s.command == GP_COMMAND_SETS) {
        gp_environment_set_gl(gp_threads()); // while there is one thread
        st = gp_sets_command(&log, &s, &differs);
    } else if (!st && s.command == GP_COMMAND_STYLES) {
        st = gp_styles_command(&log, &s);
    } else if (!st && s.command == GP_COMMAND_LENS) {
        st = gp_lens_command(&log, &s, &differs);
    } else if (!st) {
        st = make_frames(&log, &voice, &s);
    }
    if (s.command == GP_COMMAND_COMPARE && st == GP_ERR_USAGE)
        status = GP_COMPARE_USAGE;
    else if (st || differs)
        status = st ? (int) st : 1;
    gp_settings_free(&s);
    free(wisdom);
    return status;
}
