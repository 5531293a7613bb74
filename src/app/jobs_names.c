/* Every name that a run writes, held against the others and the inputs. */
#include "app/jobs.h"

#include "core/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* A name, and who writes it. */
struct entry {
    uint64_t hash;
    int job, target;
};

/* A file, whatever its name. */
struct id {
    dev_t device;
    ino_t node;
    int job;  // that reads it
};

struct names {
    const struct gp_jobs *j;
    struct entry *entry;  // owned
    size_t n;
    struct id *input;     // owned, sorted; NULL until it is needed
    int inputs;
};

/* FNV-1a, 64 bits. */
static uint64_t hash_of(const char *name)
{
    uint64_t h = 14695981039346656037u;
    for (; *name; name++)
        h = (h ^ (unsigned char) *name) * 1099511628211u;
    return h;
}

// -- no name twice -----------------------------------------------------------

static int by_hash(const void *a, const void *b)
{
    const struct entry *x = a, *y = b;
    if (x->hash != y->hash)
        return x->hash > y->hash ? 1 : -1;
    if (x->job != y->job)
        return x->job > y->job ? 1 : -1;
    return (x->target > y->target) - (x->target < y->target);
}

static bool is_same(const struct gp_jobs *j, const struct entry *a,
                    const struct entry *b)
{
    if (a->hash != b->hash)
        return false;
    char *const one = gp_job_name(&j->job[a->job], &j->target[a->target]);
    char *const two = gp_job_name(&j->job[b->job], &j->target[b->target]);
    // a full memory leaves the hash's word
    const bool same = !one || !two || strcmp(one, two) == 0;
    free(one);
    free(two);
    return same;
}

static gp_status fail_twice(const struct gp_log *log, const struct gp_jobs *j,
                            const struct entry *a, const struct entry *b)
{
    const struct gp_job *const x = &j->job[a->job], *const y = &j->job[b->job];
    char *const name = gp_job_name(x, &j->target[a->target]);
    gp_status st = gp_fail(log, GP_ERR_USAGE,
                           "%s: would be written twice (by %s for %s%s%s and "
                           "by %s for %s%s%s); give each a name of its own",
                           name ? name : j->target[a->target].name.path,
                           j->target[a->target].name.path, x->input,
                           x->view ? ", view " : "", x->view ? x->view : "",
                           j->target[b->target].name.path, y->input,
                           y->view ? ", view " : "", y->view ? y->view : "");
    free(name);
    return st;
}

/* Names the first job, in their order, that would write another's file. */
static gp_status check_twice(const struct gp_log *log, const struct names *all)
{
    const struct entry *first = NULL;
    for (size_t i = 1; i < all->n; i++) {
        const struct entry *const e = &all->entry[i];
        if (is_same(all->j, e - 1, e) && (!first || e->job < first->job))
            first = e;
    }
    return first ? fail_twice(log, all->j, first - 1, first) : GP_OK;
}

// -- no input ----------------------------------------------------------------

static int by_id(const void *a, const void *b)
{
    const struct id *x = a, *y = b;
    if (x->device != y->device)
        return x->device > y->device ? 1 : -1;
    return (x->node > y->node) - (x->node < y->node);
}

static gp_status list_inputs(const struct gp_log *log, struct names *all)
{
    const struct gp_jobs *const j = all->j;
    struct stat info;
    void *block;
    gp_status st = gp_alloc(log, "input list", (size_t) j->n,
                            sizeof *all->input, &block);
    if (st)
        return st;
    all->input = block;
    for (int i = 0; i < j->n; i += j->views) {
        if (stat(j->job[i].input, &info) == 0)
            all->input[all->inputs++] =
                (struct id) {info.st_dev, info.st_ino, i};
    }
    if (all->inputs)
        qsort(all->input, (size_t) all->inputs, sizeof *all->input, by_id);
    return GP_OK;
}

/* Refuses to write over a frame that is read, by any of its names. */
static gp_status check_input(const struct gp_log *log, struct names *all,
                             const char *name)
{
    struct stat info;
    gp_status st = GP_OK;
    if (stat(name, &info) != 0 || !S_ISREG(info.st_mode))
        return GP_OK;
    if (!all->input)
        st = list_inputs(log, all);
    const struct id key = {info.st_dev, info.st_ino, 0};
    const struct id *const found =
        st || !all->inputs ? NULL
                           : bsearch(&key, all->input, (size_t) all->inputs,
                                     sizeof key, by_id);
    if (found)
        st = gp_fail(log, GP_ERR_USAGE,
                     "%s: is the input (%s); write to another name", name,
                     all->j->job[found->job].input);
    return st;
}

// -- both --------------------------------------------------------------------

static gp_status add_name(const struct gp_log *log, struct names *all, int job,
                          int target)
{
    const struct gp_output *const t = &all->j->target[target];
    char *const name = gp_job_name(&all->j->job[job], t);
    if (!name)
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory", t->name.path);
    all->entry[all->n++] = (struct entry) {hash_of(name), job, target};
    gp_status st = strcmp(name, "-") == 0
        ? gp_fail(log, GP_ERR_USAGE,
                  "%s: is - for a view, which is stdout; write ./%s",
                  t->name.path, t->name.path)
        : check_input(log, all, name);
    free(name);
    return st;
}

static gp_status add_names(const struct gp_log *log, struct names *all)
{
    gp_status st = GP_OK;
    for (int i = 0; i < all->j->targets; i++) {
        const struct gp_output *const t = &all->j->target[i];
        const int step = t->whole ? all->j->views : 1;
        for (int k = 0; k < all->j->n && !st &&
                        strcmp(t->name.path, "-") != 0; k += step)
            st = add_name(log, all, k, i);
    }
    return st;
}

gp_status gp_jobs_check_names(const struct gp_log *log,
                              const struct gp_jobs *j)
{
    gp_status st;
    struct names all = {.j = j};
    void *block;
    GP_TRY(gp_alloc(log, "output list", (size_t) j->n * (size_t) j->targets +
                    1, sizeof *all.entry, &block));
    all.entry = block;
    GP_TRY(add_names(log, &all));
    qsort(all.entry, all.n, sizeof *all.entry, by_hash);
    GP_TRY(check_twice(log, &all));
out:
    gp_free(all.entry);
    gp_free(all.input);
    return st;
}
