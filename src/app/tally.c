#include "app/tally.h"

#include "core/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

gp_status gp_tally_make(const struct gp_log *log, const struct gp_jobs *jobs,
                        struct gp_tally *out)
{
    void *block;
    gp_status st = gp_alloc_zero(log, "frame list", (size_t) jobs->n,
                                 sizeof *out->failed, &block);
    if (!st)
        *out = (struct gp_tally) {.jobs = jobs, .failed = block};
    return st;
}

void gp_tally_free(struct gp_tally *t)
{
    gp_free(t->failed);
    *t = (struct gp_tally) {0};
}

/* True when one of `n` jobs from `i` on has failed. */
static bool any_failed(const struct gp_tally *t, int i, int n)
{
    bool failed = false;
    for (int k = i; k < i + n; k++)
        failed = failed || t->failed[k];
    return failed;
}

void gp_tally_fail(struct gp_tally *t, int index)
{
    const int n = gp_jobs_of_frame(t->jobs);
    t->bad += !any_failed(t, index - index % n, n);
    t->failed[index] = true;
}

// -- the list ----------------------------------------------------------------

/* The first of `n` jobs of which one failed, from `i` on, a multiple of n;
 * jobs->n when there is none. */
static int next_failed(const struct gp_tally *t, int i, int n)
{
    while (i < t->jobs->n && !any_failed(t, i, n))
        i += n;
    return i;
}

static bool all_numbered(const struct gp_tally *t)
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
static int item(const struct gp_tally *t, int *at, char *text, size_t size)
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
static int jobs_of_item(const struct gp_tally *t, bool numbers)
{
    return numbers            ? gp_jobs_of_frame(t->jobs)
           : t->jobs->views > 1 ? t->jobs->views : 1;
}

static int count_items(const struct gp_tally *t, int step)
{
    int n = 0;
    for (int i = 0; (i = next_failed(t, i, step)) < t->jobs->n; i += step)
        n++;
    return n;
}

bool gp_tally_list(const struct gp_tally *t, char *text, size_t size)
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

gp_status gp_tally_end(const struct gp_log *log, const struct gp_tally *t)
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
    const bool numbers = gp_tally_list(t, list, sizeof list);
    return gp_fail(log, GP_ERR_FRAMES,
                   "--skip-bad-frames: %d of %d frame%s failed (%s); mend "
                   "what the lines above say and make them again%s%s",
                   t->bad, frames, frames == 1 ? "" : "s", list,
                   numbers ? " with --frames " : "", numbers ? list : "");
}
