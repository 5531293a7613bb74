#include "app/progress.h"

#include "core/clock.h"
#include "core/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

enum {
    PATIENCE_MS = 1000,  // shorter work needs no line
    TICK_MS = 250,       // between two lines on a terminal
    PIPE_MS = 100,       // least time between two lines in a pipe
};

// -- the text ----------------------------------------------------------------

/* "45 s", "3 min 20 s", "2 h 5 min". */
static void duration(char *text, size_t size, double seconds)
{
    long long s = (long long) (seconds + 0.5);
    if (s < 60)
        snprintf(text, size, "%lld s", s);
    else if (s < 3600)
        snprintf(text, size, "%lld min %lld s", s / 60, s % 60);
    else
        snprintf(text, size, "%lld h %lld min", s / 3600, s / 60 % 60);
}

void gp_progress_text(char *line, size_t size, int done, int total,
                      const char *name, double elapsed_ms)
{
    char time[32];
    double seconds = elapsed_ms * 1e-3;
    if (done == 0) { // no rate yet
        duration(time, sizeof time, seconds);
        snprintf(line, size, "0 of %d made, %s so far: %s", total, time,
                 name);
        return;
    }
    double rate = seconds > 0.0 ? done / seconds : 0.0;
    duration(time, sizeof time, seconds / done * (total - done));
    snprintf(line, size, "%d of %d made, %.*f frames/s, %s left: %s",
             done, total, rate >= 1.0 ? 1 : 3, rate, time, name);
}

// -- drawing, under the lock -------------------------------------------------

/* Columns of the terminal; a wrapped line could not be wiped. */
static int columns(const struct gp_progress *p)
{
    struct winsize w;
    return ioctl(fileno(p->file), TIOCGWINSZ, &w) == 0 && w.ws_col > 1
               ? w.ws_col - 1 : 79;
}

static void wipe(struct gp_progress *p)
{
    if (p->drawn)
        fputs("\r\033[K", p->file);
    p->drawn = false;
}

static void draw(struct gp_progress *p, double now)
{
    char line[512];
    gp_progress_text(line, sizeof line, p->done, p->total, p->name,
                     now - p->start_ms);
    for (char *c = line; *c; c++) { // file names may hold anything
        if ((unsigned char) *c < ' ' || *c == 127)
            *c = '?';
    }
    wipe(p);
    if (p->terminal)
        fprintf(p->file, "%.*s", columns(p), line);
    else
        fprintf(p->file, "glarepp: %s\n", line);
    fflush(p->file);
    p->drawn = p->terminal;
    p->last_ms = now;
}

// -- the clock ---------------------------------------------------------------

static void *tick(void *arg)
{
    struct gp_progress *p = arg;
    pthread_mutex_lock(&p->lock);
    while (p->ticking) {
        struct timespec t;
        clock_gettime(CLOCK_REALTIME, &t); // what a condition waits by
        long long ns = t.tv_nsec + TICK_MS * 1000000LL;
        t.tv_sec += (time_t) (ns / 1000000000);
        t.tv_nsec = (long) (ns % 1000000000);
        pthread_cond_timedwait(&p->wake, &p->lock, &t);
        double now = gp_now_ms();
        if (p->ticking && p->name[0] && now - p->start_ms >= p->patience_ms)
            draw(p, now);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

void gp_progress_open(struct gp_progress *p, FILE *file,
                      enum gp_progress_when when, bool quiet)
{
    bool terminal = isatty(fileno(file));
    bool draws = !quiet && (when == GP_PROGRESS_ALWAYS ||
                            (when == GP_PROGRESS_AUTO && terminal));
    *p = (struct gp_progress) {
        .file = draws ? file : NULL,
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
        wipe(p);
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
    const char *slash = strrchr(name, '/');
    pthread_mutex_lock(&p->lock);
    p->done = done;
    p->total = total;
    snprintf(p->name, sizeof p->name, "%s: %s",
             slash ? slash + 1 : name, stage);
    if (!p->terminal && now - p->last_ms >= PIPE_MS)
        draw(p, now);
    pthread_mutex_unlock(&p->lock);
}

void gp_progress_say(struct gp_progress *p, FILE *file, const char *line)
{
    pthread_mutex_lock(&p->lock);
    if (p->file)
        wipe(p);
    fprintf(file, "%s\n", line);
    pthread_mutex_unlock(&p->lock);
}

// -- messages in the order of frames -------------------------------------------

static void hand_on(const struct gp_frame_log *s, enum gp_level level,
                    const char *line)
{
    if (s->to && s->to->sink)
        s->to->sink(s->to->user, level, line);
}

/* False when memory is full. */
static bool keep(struct gp_frame_log *s, enum gp_level level, const char *line)
{
    const size_t bytes = strlen(line) + 2;
    if (bytes > s->room - s->used) {
        const size_t room = 2 * s->room + bytes;
        char *const text = realloc(s->text, room);
        if (!text)
            return false;
        s->text = text;
        s->room = room;
    }
    s->text[s->used] = (char) level;
    memcpy(s->text + s->used + 1, line, bytes - 1);
    s->used += bytes;
    return true;
}

static void take(void *user, enum gp_level level, const char *line)
{
    struct gp_frame_log *const s = user;
    char named[GP_LINE_BYTES];
    if (level == GP_LEVEL_BARE) {
        snprintf(named, sizeof named, "%s: %s", s->name, line);
        line = named;
        level = GP_LEVEL_ERROR;
    }
    if (level == GP_LEVEL_ERROR)
        snprintf(s->last, sizeof s->last, "%s", line);
    if (gp_flight_head(s->flight) != s->unit && keep(s, level, line))
        return;
    gp_frame_log_flush(s);
    hand_on(s, level, line);
}

void gp_frame_log_open(struct gp_frame_log *s, const struct gp_log *to,
                   const struct gp_flight *flight, int unit,
                   const char *name)
{
    *s = (struct gp_frame_log) {
        .log = {take, s, to ? to->level : GP_LEVEL_ERROR},
        .to = to, .flight = flight, .unit = unit, .name = name,
    };
}

void gp_frame_log_flush(struct gp_frame_log *s)
{
    for (size_t at = 0; at < s->used; at += strlen(s->text + at + 1) + 2)
        hand_on(s, (enum gp_level) s->text[at], s->text + at + 1);
    s->used = 0;
}

void gp_frame_log_close(struct gp_frame_log *s)
{
    free(s->text);
    *s = (struct gp_frame_log) {0};
}

// -- which frames failed -------------------------------------------------------

gp_status gp_failures_make(const struct gp_log *log, const struct gp_jobs *jobs,
                        struct gp_failures *out)
{
    void *block;
    gp_status st = gp_alloc_zero(log, "frame list", (size_t) jobs->n,
                                 sizeof *out->failed, &block);
    if (!st)
        *out = (struct gp_failures) {.jobs = jobs, .failed = block};
    return st;
}

void gp_failures_free(struct gp_failures *t)
{
    gp_free(t->failed);
    *t = (struct gp_failures) {0};
}

/* True when one of `n` jobs from `i` on has failed. */
static bool any_failed(const struct gp_failures *t, int i, int n)
{
    bool failed = false;
    for (int k = i; k < i + n; k++)
        failed = failed || t->failed[k];
    return failed;
}

void gp_failures_add(struct gp_failures *t, int index)
{
    const int n = gp_jobs_of_frame(t->jobs);
    t->bad += !any_failed(t, index - index % n, n);
    t->failed[index] = true;
}

// -- the list ----------------------------------------------------------------

/* The first of `n` jobs of which one failed, from `i` on, a multiple of n;
 * jobs->n when there is none. */
static int next_failed(const struct gp_failures *t, int i, int n)
{
    while (i < t->jobs->n && !any_failed(t, i, n))
        i += n;
    return i;
}

static bool all_numbered(const struct gp_failures *t)
{
    for (int i = 0; i < t->jobs->n; i++) {
        if (t->failed[i] && !t->jobs->job[i].numbered)
            return false;
    }
    return true;
}

/* Writes the item that starts at the failed frame whose first job is *at, a
 * frame or an evenly spaced run, moves *at behind it and returns how many
 * frames it holds. */
static int item(const struct gp_failures *t, int *at, char *text, size_t size)
{
    const struct gp_job *const job = t->jobs->job;
    const int views = gp_jobs_of_frame(t->jobs);
    const int first = *at, second = next_failed(t, first + views, views);
    int last = first, next = second, n = 1;
    const int step = second < t->jobs->n ? job[second].frame - job[first].frame
                                         : 0;
    while (next < t->jobs->n && job[next].frame - job[last].frame == step) {
        last = next;
        next = next_failed(t, next + views, views);
        n++;
    }
    const bool apart = abs(step) != 1;
    if (n == 1 || (n == 2 && apart)) {
        snprintf(text, size, "%d", job[first].frame);
        *at = second;
        return 1;
    }
    if (apart)
        snprintf(text, size, "%d-%dx%d", job[first].frame, job[last].frame,
                 abs(step));
    else
        snprintf(text, size, "%d-%d", job[first].frame, job[last].frame);
    *at = next;
    return n;
}

/* Jobs that one item stands for: a frame's, or in a list of names those of an
 * input. */
static int jobs_of_item(const struct gp_failures *t, bool numbers)
{
    return numbers            ? gp_jobs_of_frame(t->jobs)
           : t->jobs->views > 1 ? t->jobs->views : 1;
}

static int count_items(const struct gp_failures *t, int step)
{
    int n = 0;
    for (int i = 0; (i = next_failed(t, i, step)) < t->jobs->n; i += step)
        n++;
    return n;
}

bool gp_failures_list(const struct gp_failures *t, char *text, size_t size)
{
    enum { MORE = 32 }; // bytes of ", and N more"
    const bool numbers = all_numbered(t);
    const int step = jobs_of_item(t, numbers);
    size_t used = 0;
    int left = count_items(t, step);
    text[0] = '\0';
    for (int i = next_failed(t, 0, step); i < t->jobs->n;) {
        char number[64];
        const char *word = number;
        int n = 1;
        if (numbers) {
            n = item(t, &i, number, sizeof number);
        } else {
            word = t->jobs->job[i].input;
            i = next_failed(t, i + step, step);
        }
        const char *const between = !used ? "" : numbers ? "," : ", ";
        if (used + strlen(between) + strlen(word) + MORE >= size) {
            snprintf(text + used, size - used, "%s%d more",
                     used ? " and " : "", left);
            return false;
        }
        used += (size_t) snprintf(text + used, size - used, "%s%s", between,
                                  word);
        left -= n;
    }
    return numbers;
}

// -- the end -----------------------------------------------------------------

gp_status gp_failures_report(const struct gp_log *log, const struct gp_failures *t)
{
    char list[1200];
    const int views = gp_jobs_of_frame(t->jobs), frames = t->jobs->n / views;
    if (t->kept)
        gp_say(log, GP_LEVEL_WARN,
               "--no-clobber: left %d of %d %s%s alone (all outputs are "
               "there); remove the files to make them anew", t->kept,
               t->jobs->n, views > 1 ? "view" : "frame",
               t->jobs->n == 1 ? "" : "s");
    if (!t->bad)
        return GP_OK;
    const bool numbers = gp_failures_list(t, list, sizeof list);
    return gp_fail(log, GP_ERR_FRAMES,
                   "--skip-bad-frames: %d of %d frame%s failed (%s); mend "
                   "what the lines above say and make them again%s%s",
                   t->bad, frames, frames == 1 ? "" : "s", list,
                   numbers ? " with --frames " : "", numbers ? list : "");
}
