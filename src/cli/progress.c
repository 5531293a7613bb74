// SPDX-License-Identifier: Apache-2.0
#include "cli/progress.h"

#include "cli/words.h"
#include "core/clock.h"
#include "core/json.h"
#include "core/minmax.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

enum {
    PATIENCE_MS = 1000,  // shorter work needs no line
    TICK_MS = 250,       // between redraws on a terminal
    PIPE_MS = 100,       // least time between lines in a pipe
};

// -- the line: under the lock ------------------------------------------------

void gp_print_duration(char *text, size_t size, double seconds)
{
    long long s = (long long) (seconds + 0.5);
    if (s < 60)
        snprintf(text, size, "%lld s", s);
    else if (s < 3600)
        snprintf(text, size, "%lld min %lld s", s / 60, s % 60);
    else
        snprintf(text, size, "%lld h %lld min", s / 3600, s / 60 % 60);
}

static void wipe_line(struct gp_progress *p)
{
    if (p->drawn)
        fputs("\r\033[K", p->file);
    p->drawn = false;
}

/* Describes frames made and failed, rate and time left. */
static void describe_progress(const struct gp_progress *p, double seconds,
                              char *line, size_t size)
{
    const double rate = seconds > 0.0 ? p->done / seconds : 0.0;
    char time[32], failed[32] = "";
    if (p->failed)
        snprintf(failed, sizeof failed, ", %d failed", p->failed);
    if (p->done == 0) { // no rate yet
        gp_print_duration(time, sizeof time, seconds);
        snprintf(line, size, "0 of %d made, %s so far: %s: %s", p->total, time,
                 p->name, p->stage);
    } else {
        gp_print_duration(time, sizeof time,
                          seconds / p->done * (p->total - p->done));
        snprintf(line, size, "%d of %d made%s, %.*f frames/s, %s left: %s: %s",
                 gp_max(p->done - p->failed, 0), p->total, failed,
                 rate >= 1.0 ? 1 : 3, rate, time, p->name, p->stage);
    }
    gp_make_printable(line);
}

static void draw_line(struct gp_progress *p, double now)
{
    char line[512];
    struct winsize w;
    describe_progress(p, (now - p->start_ms) * 1e-3, line, sizeof line);
    wipe_line(p);
    // a line that wraps could not be wiped
    const int columns = p->terminal &&
                                ioctl(fileno(p->file), TIOCGWINSZ, &w) == 0 &&
                                w.ws_col > 1 ? w.ws_col - 1 : 79;
    if (p->terminal)
        fprintf(p->file, "%.*s", columns, line);
    else
        fprintf(p->file, "glarepp: %s\n", line);
    fflush(p->file);
    p->drawn = p->terminal;
    p->last_ms = now;
}

/* Prints a line for programs when the count has changed, or at the end. */
static void print_news(struct gp_progress *p, double now, bool end)
{
    const double seconds = (now - p->start_ms) * 1e-3;
    const double percent =
        end || p->total <= 0 ? 100.0 : 100.0 * p->done / p->total;
    const int news = p->when == GP_PROGRESS_PERCENT ? (int) percent : p->done;
    const bool soon = p->when != GP_PROGRESS_PERCENT && p->printed >= 0 &&
                      !end && now - p->last_ms < PIPE_MS;
    char line[512];
    if (soon || (news <= p->printed && !(end && p->printed < INT_MAX)))
        return;
    if (p->when == GP_PROGRESS_PERCENT && news > p->printed)
        fprintf(p->file, "%d%%\n", news);
    if (p->when == GP_PROGRESS_OPENJD) {
        describe_progress(p, seconds, line, sizeof line);
        fprintf(p->file, "openjd_progress: %.1f\nopenjd_status: %s\n",
                floor(percent * 10.0) / 10.0, line);
    }
    if (p->when == GP_PROGRESS_JSON) {
        const double left = seconds / p->done * (p->total - p->done);
        json_t *const o = json_pack(
            "{si so* si sf sf so* so* so*}", "done", p->done,
            "failed", p->failed ? json_integer(p->failed) : NULL,
            "total", p->total, "percent", floor(percent * 10.0) / 10.0,
            "seconds", seconds,
            "seconds_left", p->done > 0 ? json_real(left) : NULL,
            "file", p->name[0] ? gp_json_name(p->name) : NULL,
            "stage", p->name[0] ? json_string(p->stage) : NULL);
        char *const text =
            gp_json_print(o, JSON_COMPACT | JSON_REAL_PRECISION(6));
        if (text) // a run without a line is still a run
            fprintf(p->file, "%s\n", text);
        free(text);
    }
    fflush(p->file);
    p->printed = end ? INT_MAX : news;
    p->last_ms = now;
}

// -- the clock ---------------------------------------------------------------

static void *tick(void *arg)
{
    struct gp_progress *p = arg;
    pthread_mutex_lock(&p->lock);
    while (p->ticking) {
        struct timespec t;
        clock_gettime(CLOCK_REALTIME, &t); // the clock of conditions
        long long ns = t.tv_nsec + TICK_MS * 1000000LL;
        t.tv_sec += (time_t) (ns / 1000000000);
        t.tv_nsec = (long) (ns % 1000000000);
        pthread_cond_timedwait(&p->wake, &p->lock, &t);
        double now = gp_now_ms();
        if (p->ticking && p->name[0] && now - p->start_ms >= p->patience_ms)
            draw_line(p, now);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

void gp_progress_open(struct gp_progress *p, FILE *file,
                      enum gp_progress_when when)
{
    const bool programs = when >= GP_PROGRESS_PERCENT;
    const bool terminal = !programs && isatty(fileno(file));
    const bool draws = when == GP_PROGRESS_ALWAYS || programs ||
                       (when == GP_PROGRESS_AUTO && terminal);
    *p = (struct gp_progress) {
        .file = draws ? file : NULL,
        .when = when,
        .stage = "",
        .printed = -1,
        .terminal = terminal,
        .patience_ms = when == GP_PROGRESS_ALWAYS ? 0.0 : PATIENCE_MS,
        .start_ms = gp_now_ms(),
        .last_ms = -PIPE_MS,
        .ticking = draws && terminal,
    };
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->wake, NULL);
    if (p->ticking && pthread_create(&p->clock, NULL, tick, p) != 0)
        p->ticking = false; // a run without its line is still a run
}

void gp_progress_close(struct gp_progress *p)
{
    pthread_mutex_lock(&p->lock);
    bool ticking = p->ticking;
    p->ticking = false;
    pthread_cond_signal(&p->wake);
    pthread_mutex_unlock(&p->lock);
    if (ticking)
        pthread_join(p->clock, NULL);
    if (p->file) {
        wipe_line(p);
        fflush(p->file);
    }
    pthread_cond_destroy(&p->wake);
    pthread_mutex_destroy(&p->lock);
    p->file = NULL;
}

void gp_progress_update(struct gp_progress *p, int done, int total,
                        const char *name, const char *stage)
{
    double now = gp_now_ms();
    if (!p->file)
        return;
    pthread_mutex_lock(&p->lock);
    p->done = done;
    p->total = total;
    p->stage = stage;
    snprintf(p->name, sizeof p->name, "%s", gp_base_name(name));
    if (p->when >= GP_PROGRESS_PERCENT)
        print_news(p, now, false);
    else if (!p->terminal && now - p->last_ms >= PIPE_MS)
        draw_line(p, now);
    pthread_mutex_unlock(&p->lock);
}

void gp_progress_fail(struct gp_progress *p, int n)
{
    pthread_mutex_lock(&p->lock);
    p->failed += n;
    pthread_mutex_unlock(&p->lock);
}

void gp_progress_end(struct gp_progress *p)
{
    pthread_mutex_lock(&p->lock);
    if (p->file && p->when >= GP_PROGRESS_PERCENT) {
        p->done = p->total;
        print_news(p, gp_now_ms(), true);
    }
    pthread_mutex_unlock(&p->lock);
}

void gp_progress_say(struct gp_progress *p, FILE *file, const char *line)
{
    pthread_mutex_lock(&p->lock);
    if (p->file)
        wipe_line(p);
    fprintf(file, "%s\n", line);
    pthread_mutex_unlock(&p->lock);
}

// -- messages in the order of frames -----------------------------------------

/* Prints a message, kept as its level, its line and a null byte. */
static void print_message(const struct gp_frame_log *l, const char *kept)
{
    const enum gp_level level = (enum gp_level) *kept;
    if (l->to && l->to->sink && level <= l->to->level)
        l->to->sink(l->to->user, &(struct gp_line) {level, GP_OK, "", kept + 1});
}

/* Keeps a message; prints those of the oldest unit, and one that finds memory
 * full. */
static void log_message(void *user, const struct gp_line *message)
{
    struct gp_frame_log *const l = user;
    const bool bare = message->level == GP_LEVEL_BARE;
    char kept[GP_LINE_BYTES + 1] = {
        (char) (bare ? GP_LEVEL_ERROR : message->level)};
    snprintf(kept + 1, sizeof kept - 1, "%s%s%s", bare ? l->name : "",
             bare ? ": " : "", message->text);
    const size_t bytes = strlen(kept + 1) + 2;
    char *const grown = realloc(l->text, l->bytes + bytes);
    if (grown) {
        l->text = grown;
        memcpy(l->text + l->bytes, kept, bytes);
        l->bytes += bytes;
    }
    if (atomic_load(l->head) == l->unit || !grown)
        gp_frame_log_flush(l);
    if (!grown)
        print_message(l, kept);
}

const char *gp_frame_log_error(const struct gp_frame_log *l)
{
    const char *last = NULL, *m = l->text;
    for (; m < l->text + l->bytes; m += strlen(m + 1) + 2)
        last = *m == GP_LEVEL_ERROR ? m + 1 : last;
    return last;
}

void gp_frame_log_open(struct gp_frame_log *l, const struct gp_log *to,
    const atomic_int *head, int unit, const char *name)
{
    *l = (struct gp_frame_log) {
        .log = {log_message, l, to && to->level > GP_LEVEL_WARN
                                    ? to->level : GP_LEVEL_WARN},
        .to = to, .head = head, .unit = unit, .name = name,
    };
}

void gp_frame_log_flush(struct gp_frame_log *l)
{
    for (; l->printed < l->bytes;
         l->printed += strlen(l->text + l->printed + 1) + 2)
        print_message(l, l->text + l->printed);
}

void gp_frame_log_close(struct gp_frame_log *l)
{
    free(l->text);
    *l = (struct gp_frame_log) {0};
}

// -- frames that failed ------------------------------------------------------

/* True where one of n jobs failed. */
static bool has_failed(const struct gp_jobs *j, int first, int n)
{
    bool failed = false;
    for (int i = first; i < first + n; i++)
        failed |= j->job[i].failed;
    return failed;
}

gp_status gp_failures_report(const struct gp_log *log, const struct gp_jobs *j,
                             int kept)
{
    enum { MORE = 32 }; // bytes of ", and N more"
    char list[GP_FAILURES_BYTES] = "", item[64];
    const struct gp_job *const job = j->job;
    const int views = gp_jobs_of_frame(j), frames = j->n / views;
    int bad = 0, left = 0;
    bool numbers = true;
    size_t used = 0;
    for (int i = 0; i < j->n; i += views)
        bad += has_failed(j, i, views);
    if (kept)
        gp_say(log, GP_LEVEL_WARN, "--no-clobber: skipped %d of %d %s%s (all "
               "outputs exist); remove the files to make them again", kept,
               j->n, views > 1 ? "view" : "frame", j->n == 1 ? "" : "s");
    if (!bad)
        return GP_OK;
    // numbers where all have one, else names; an item is for `step` jobs, those
    // of a frame or, in a list of names, of an input
    for (int i = 0; i < j->n; i++)
        numbers = numbers && (!job[i].failed || job[i].numbered);
    const int step = numbers ? views : j->views;
    for (int i = 0; i < j->n; i += step)
        left += has_failed(j, i, step);
    for (int i = 0, next; i < j->n; i = next) {
        int last = i, n = 1;
        next = i + step;
        if (!has_failed(j, i, step))
            continue;
        for (; next < j->n; next += step) {
            if (!has_failed(j, next, step))
                continue;
            if (!numbers || job[next].frame - job[last].frame != 1)
                break;
            last = next;
            n++;
        }
        snprintf(item, sizeof item, n > 1 ? "%d-%d" : "%d", job[i].frame,
                 job[last].frame);
        const char *const word = numbers ? item : job[i].input;
        const char *const between = !used ? "" : numbers ? "," : ", ";
        if (used + strlen(between) + strlen(word) + MORE >= sizeof list) {
            snprintf(list + used, sizeof list - used, "%s%d more",
                     used ? " and " : "", left);
            numbers = false; // a cut list is no value of --frames
            break;
        }
        used += (size_t) snprintf(list + used, sizeof list - used, "%s%s",
                                  between, word);
        left -= n;
    }
    return gp_fail(log, GP_ERR_FRAMES, "--skip-bad-frames: %d of %d frame%s "
                   "failed (%s); fix the errors above, then make them "
                   "again%s%s", bad, frames, frames == 1 ? "" : "s", list,
                   numbers ? " with --frames " : "", numbers ? list : "");
}
