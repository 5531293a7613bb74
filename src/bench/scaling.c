/* The whole program with several numbers of threads: time, busy cores and the
 * serial share of each stage (Amdahl 1967). */
#include "bench/bench_priv.h"

#include "core/clock.h"
#include "core/json.h"
#include "io/file.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <sched.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

static const int predicted[] = {8, 16, 64}; // threads
enum { PREDICTED = sizeof predicted / sizeof *predicted };

/* A stage, what is outside of all of them, or the process. */
struct row {
    char name[24];
    double wall[GP_COUNTS], cpu[GP_COUNTS]; // ms, of the least wall time
    double serial, parallel;                // ms of the fitted line
};
enum { ROWS = 24 };

struct table {
    struct row row[ROWS];
    int n;
    cpu_set_t usable; // processors that the runs may use
    double own;       // CPU time of all runs, ms
    double others;    // of these, what other programs kept busy meanwhile; NaN
};                    // when unknown

/* The row of that name, which is made where it is missing and there is room. */
static struct row *row_of(struct table *t, const char *name)
{
    int i = 0;
    while (i < t->n && strcmp(t->row[i].name, name) != 0)
        i++;
    if (i == ROWS)
        return &t->row[ROWS - 1];
    struct row *const r = &t->row[i];
    if (i == t->n) {
        t->n++;
        snprintf(r->name, sizeof r->name, "%s", name);
        for (int k = 0; k < GP_COUNTS; k++)
            r->wall[k] = INFINITY;
    }
    return r;
}

static void keep_least(struct row *r, int k, double wall, double cpu)
{
    if (r->wall[k] <= wall)
        return;
    r->wall[k] = wall;
    r->cpu[k] = cpu;
}

// -- one run -----------------------------------------------------------------

/* Makes the words of a run, the pointers and their text in one block; NULL when
 * memory is full. Free with free(). */
static char **make_words(const struct gp_scaling_request *req, int threads)
{
    char number[16], *text = NULL;
    size_t size = 0;
    const char *const last[] = {
        "--threads", number, "--quiet", "-o", "-", "--stdout-format", "png",
        "--report", "/dev/fd/3", "--", req->input,
    };
    enum { LAST = sizeof last / sizeof *last };
    const int n = 1 + req->words + LAST;
    snprintf(number, sizeof number, "%d", threads);
    FILE *const f = open_memstream(&text, &size);
    for (int i = 0; i <= n && f; i++) // room for the pointers
        fwrite(&(char *) {NULL}, sizeof(char *), 1, f);
    for (int i = 0; i < n && f; i++) {
        const char *const word = i == 0            ? "glarepp"
                                 : i <= req->words ? req->word[i - 1]
                                                   : last[i - 1 - req->words];
        fwrite(word, 1, strlen(word) + 1, f);
    }
    if (!f || fclose(f)) {
        free(text);
        return NULL;
    }
    char **const words = (void *) text;
    char *at = text + (size_t) (n + 1) * sizeof *words;
    for (int i = 0; i < n; i++) {
        words[i] = at;
        at += strlen(at) + 1;
    }
    return words;
}

/* Starts the program: its picture goes nowhere, its report to `to`. Returns
 * errno. */
static int start(char *const words[], int to, pid_t *pid)
{
    posix_spawn_file_actions_t files;
    int error = posix_spawn_file_actions_init(&files);
    if (error)
        return error;
    error = posix_spawn_file_actions_addopen(&files, 1, "/dev/null", O_WRONLY,
                                             0);
    if (!error)
        error = posix_spawn_file_actions_adddup2(&files, to, 3);
    if (!error)
        error = posix_spawn(pid, "/proc/self/exe", &files, NULL, words,
                            environ);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

static double ms_of(struct timeval t)
{
    return (double) t.tv_sec * 1e3 + (double) t.tv_usec * 1e-3;
}

/* Adds a run with the k-th number of threads to the table. */
static void keep_run(struct table *t, int k, const json_t *report, double wall,
                     double cpu)
{
    const char *name;
    json_t *v, *const walls = json_object_get(report, "times_ms");
    const json_t *const cpus = json_object_get(report, "cpu_ms");
    const double process = wall, all = cpu;
    t->own += cpu;
    json_object_foreach(walls, name, v) {
        const double ms = json_number_value(v);
        const double own = json_number_value(json_object_get(cpus, name));
        if (strcmp(name, "total") == 0)
            continue;
        keep_least(row_of(t, name), k, ms, own);
        wall -= ms;
        cpu -= own;
    }
    keep_least(row_of(t, "outside"), k, fmax(wall, 0.0), fmax(cpu, 0.0));
    keep_least(row_of(t, "process"), k, process, all);
}

static gp_status run_once(const struct gp_log *log,
                          const struct gp_scaling_request *req, int k,
                          struct table *t)
{
    gp_status st = GP_OK;
    int ends[2], status = 0;
    struct rusage used = {0};
    pid_t pid;
    char **const words = make_words(req, req->threads.v[k]);
    if (!words)
        return gp_no_memory(log, req->input);
    int error = pipe2(ends, O_CLOEXEC) ? errno : 0;
    FILE *const from = error ? NULL : fdopen(ends[0], "r");
    const double begin = gp_now_ms();
    if (!error) {
        error = from ? start(words, ends[1], &pid) : errno;
        close(ends[1]);
        if (!from)
            close(ends[0]);
    }
    free(words);
    if (error) {
        if (from)
            fclose(from);
        return gp_fail(log, GP_ERR_IO, "%s: no run can be started (%s); close "
                       "other programs, and see that /proc is mounted",
                       req->input, strerror(error));
    }
    json_t *const report = json_loadf(from, JSON_DISABLE_EOF_CHECK, NULL);
    while (getc(from) != EOF)
        ;
    fclose(from);
    while (wait4(pid, &status, 0, &used) < 0 && errno == EINTR)
        ;
    if (WIFEXITED(status) && WEXITSTATUS(status))
        st = (gp_status) WEXITSTATUS(status); // has said why
    else if (!WIFEXITED(status) || !report)
        st = gp_fail(log, GP_ERR_BUG, "%s: a run with %d threads ended without "
                     "a report (%s); run it without bench", req->input,
                     req->threads.v[k], WIFSIGNALED(status)
                         ? strsignal(WTERMSIG(status)) : "no signal");
    else
        keep_run(t, k, report, gp_now_ms() - begin,
                 ms_of(used.ru_utime) + ms_of(used.ru_stime));
    json_decref(report);
    return st;
}

// -- other programs ----------------------------------------------------------

/* Wall time from which the ticks of /proc/stat, of 10 ms, are fine enough. */
static const double SURE_MS = 500.0;

/* CPU time of all programs on those processors since the machine's start, ms;
 * NaN when /proc/stat does not say. */
static double busy_ms(const cpu_set_t *of)
{
    // user nice system idle iowait irq softirq steal; proc(5)
    static const bool counts[] = {true, true, true, false, false, true, true,
                                  true};
    enum { FIELDS = sizeof counts / sizeof *counts };
    const long ticks = sysconf(_SC_CLK_TCK); // a second
    char line[512];
    FILE *const f = fopen("/proc/stat", "re");
    double sum = 0.0;
    int seen = 0;
    while (f && fgets(line, sizeof line, f) && strncmp(line, "cpu", 3) == 0) {
        char *at = line + 3;
        if (*at == ' ') // the sum of all
            continue;
        const long cpu = strtol(at, &at, 10);
        if (cpu < 0 || cpu >= CPU_SETSIZE || !CPU_ISSET((size_t) cpu, of))
            continue;
        for (int i = 0; i < FIELDS; i++) {
            const double n = strtod(at, &at);
            sum += counts[i] ? n : 0.0;
        }
        seen++;
    }
    if (f)
        fclose(f);
    return seen && ticks > 0 ? sum * 1e3 / (double) ticks : (double) NAN;
}

/* Prints a line where other programs made the times longer. */
static void print_others(const struct table *t)
{
    const int most = CPU_COUNT(&t->usable);
    if (t->others > 0.1 * most)
        printf("other programs kept %.1f of %d processors busy: times and "
               "predictions are too long; repeat on an idle machine\n",
               t->others, most);
}

// -- the line ----------------------------------------------------------------

/* The numbers of threads that the line goes through: one for each processor,
 * as more than that share them and are no faster. */
static struct gp_counts fitted(const struct gp_counts *n, int processors)
{
    struct gp_counts some = {0};
    for (int k = 0; k < n->n; k++) {
        if (n->v[k] <= processors)
            some.v[some.n++] = k;
    }
    return some;
}

/* Fits wall = serial + parallel / threads by least squares, neither under 0, to
 * those numbers of threads; NaN where they are not two different ones. */
static void fit_line(const struct gp_counts *n, const struct gp_counts *some,
                     struct row *r)
{
    double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (int i = 0; i < some->n; i++) {
        const int k = some->v[i];
        const double at = 1.0 / n->v[k], share = 1.0 / some->n;
        x += share * at;
        y += share * r->wall[k];
        xx += share * at * at;
        xy += share * at * r->wall[k];
    }
    const double spread = xx - x * x;
    r->parallel = spread > 1e-12 ? fmax((xy - x * y) / spread, 0.0)
                                 : (double) NAN;
    r->serial = y - r->parallel * x;
    if (r->serial < 0.0) { // more than n times as fast with n threads
        r->serial = 0.0;
        r->parallel = xy / xx;
    }
}

/* Returns true when the numbers of threads make a line. */
static bool has_line(const struct table *t)
{
    return isfinite(t->row[0].parallel);
}

/* Prints a line where numbers of threads are left out of the fit, or leave too
 * few for it. */
static void print_fitted(const struct gp_counts *n, const struct table *t)
{
    const int most = CPU_COUNT(&t->usable);
    if (!has_line(t))
        printf("no serial share: it takes two different numbers of threads, up "
               "to %d here (the processors that glarepp may use)\n", most);
    else if (fitted(n, most).n < n->n)
        printf("left out of the line: numbers of threads above %d (the "
               "processors that glarepp may use)\n", most);
}

// -- printing ----------------------------------------------------------------

/* Returns true when every number of threads has a time. */
static bool ran(const struct gp_counts *n, const struct row *r)
{
    for (int k = 0; k < n->n; k++) {
        if (!isfinite(r->wall[k]))
            return false;
    }
    return true;
}

static void print_table(const struct gp_scaling_request *req,
                        const struct table *t)
{
    const struct gp_counts *const n = &req->threads;
    printf("%s to PNG, the whole program from cold; least of %d runs\n\n%-9s",
           gp_printable(req->input).text, req->runs, "threads");
    for (int k = 0; k < n->n; k++)
        printf("%9d       ", n->v[k]);
    printf("%s\n%-9s", has_line(t) ? "  serial  predicted ms at" : "", "");
    for (int k = 0; k < n->n; k++)
        printf("%9s %6s", "ms", "cores");
    printf("%s", has_line(t) ? "   share" : "");
    for (int i = 0; i < PREDICTED && has_line(t); i++)
        printf("%8d", predicted[i]);
    putchar('\n');
    for (int i = 0; i < t->n; i++) {
        const struct row *const r = &t->row[i];
        if (!ran(n, r))
            continue;
        const double sum = r->serial + r->parallel;
        printf("%-9s", r->name);
        for (int k = 0; k < n->n; k++)
            printf("%9.2f %6.2f", r->wall[k],
                   r->wall[k] > 0.0 ? r->cpu[k] / r->wall[k] : 0.0);
        if (isfinite(r->parallel)) {
            printf("%7.1f%%", sum > 0.0 ? 100.0 * r->serial / sum : 0.0);
            for (int p = 0; p < PREDICTED; p++)
                printf("%8.2f", r->serial + r->parallel / predicted[p]);
        }
        putchar('\n');
    }
    printf("\ncores: CPU time of all threads over wall time\n"
           "outside: start, plans and the end, which no stage counts\n%s",
           has_line(t) ? "serial share, predictions: by the line a + b / "
                         "threads through the wall times\n" : "");
    print_fitted(n, t);
    print_others(t);
}

static gp_status save_json(const struct gp_log *log,
                           const struct gp_scaling_request *req,
                           const struct table *t)
{
    json_t *const rows = json_array();
    for (int i = 0; i < t->n; i++) {
        const struct row *const r = &t->row[i];
        if (!ran(&req->threads, r))
            continue;
        json_t *const runs = json_array();
        for (int k = 0; k < req->threads.n; k++)
            json_array_append_new(runs, json_pack("{si sf sf}",
                "threads", req->threads.v[k], "ms", r->wall[k], "cpu_ms",
                r->cpu[k]));
        json_t *const o = json_pack("{ss so}", "name", r->name, "runs", runs);
        if (isfinite(r->parallel)) {
            json_object_set_new(o, "serial_ms", json_real(r->serial));
            json_object_set_new(o, "parallel_ms", json_real(r->parallel));
        }
        json_array_append_new(rows, o);
    }
    json_t *const o = json_pack("{so si si so ss}",
        "input", gp_json_name(req->input), "runs", req->runs, "processors",
        CPU_COUNT(&t->usable), "rows", rows, "version", GP_VERSION);
    if (isfinite(t->others))
        json_object_set_new(o, "other_cores", json_real(t->others));
    return gp_bench_save_json(log, o, req->json);
}

gp_status gp_scaling_run(const struct gp_log *log,
                         const struct gp_scaling_request *req)
{
    gp_status st;
    struct table t = {.n = 0};
    const bool dash = req->json && gp_is_dash(req->json);
    if (req->json && !dash)
        GP_TRY(gp_file_check(log, req->json, false));
    if (sched_getaffinity(0, sizeof t.usable, &t.usable)) {
        CPU_ZERO(&t.usable); // over 1024 processors: the first
        CPU_SET(0, &t.usable);
    }
    const struct gp_counts some = fitted(&req->threads, CPU_COUNT(&t.usable));
    const double begin = gp_now_ms(), busy = busy_ms(&t.usable);
    for (int i = 0; i < req->runs; i++) {
        for (int k = 0; k < req->threads.n; k++)
            GP_TRY(run_once(log, req, k, &t));
    }
    const double wall = gp_now_ms() - begin;
    t.others = wall < SURE_MS ? (double) NAN
                              : fmax(busy_ms(&t.usable) - busy - t.own, 0.0) / wall;
    for (int i = 0; i < t.n; i++)
        fit_line(&req->threads, &some, &t.row[i]);
    if (!dash)
        print_table(req, &t);
    if (req->json)
        GP_TRY(save_json(log, req, &t));
    st = gp_flush_stdout(log);
out:
    return st;
}
