#include "app/progress.h"

#include "core/clock.h"

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
