// SPDX-License-Identifier: Apache-2.0
#include "cli/jobs.h"

#include "core/memory.h"
#include "io/file.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A file that is written, by an output with a name of its own. */
struct output {
    dev_t device;
    ino_t node;           // the file's, or its folder's
    uint64_t hash;        // of the name in the folder; 0: the file exists
    bool open;            // a descriptor, which may be given several times
    size_t order;
    char *name;           // of the file, as written; owned
    char what[24];        // the option
    const char *as, *of;  // as given
};

/* Returns the file of a plain name that an option writes, or reads; or NULL. */
static const char *file_of(const struct gp_settings *s,
                           const struct gp_option *o, bool written)
{
    const char *name;
    const bool config = o->at == offsetof(struct gp_settings, tone.map.config);
    if (o->kind != GP_KIND_TEXT || !(config || strstr(o->arg, "FILE")) ||
        o->once != written || (o->aside && !written))
        return NULL;
    memcpy(&name, (const char *) s + o->at, sizeof name);
    return name;
}

// -- files that are still to be made -----------------------------------------

/* Identifies the file that will be made under a name that does not exist: by
 * device and node of the deepest folder in it that exists, and a hash of the
 * names after it, FNV-1a from last to first; --create-dir would make these
 * folders. */
static gp_status find_place(const struct gp_log *log, const char *path,
                            struct output *file)
{
    const size_t room = strlen(path) + 3;
    char *const way = malloc(room), *slash;
    uint64_t hash = 14695981039346656037u;
    struct stat info = {0};
    int up = 0; // names before that a ".." takes back
    if (!way)
        return gp_no_memory(log, path);
    snprintf(way, room, "%s%s", *path == '/' ? "" : "./", path);
    do {
        slash = strrchr(way, '/');
        const char *name = slash + 1;
        if (strcmp(name, "..") == 0)
            up++;
        else if (*name && strcmp(name, ".") != 0 && up > 0)
            up--;
        else if (*name && strcmp(name, ".") != 0) {
            for (; *name; name++)
                hash = (hash ^ (unsigned char) *name) * 1099511628211u;
            hash = (hash ^ '/') * 1099511628211u;
        }
        slash[slash == way] = '\0';
    } while ((stat(way, &info) != 0 || !S_ISDIR(info.st_mode)) &&
             slash != way && strcmp(way, ".") != 0);
    if (up > 0) {
        while (up-- > 0)
            strcat(way, "/.."); // shorter than the names that were cut off
        if (stat(way, &info) != 0) // removed meanwhile
            info = (struct stat) {0};
    }
    gp_free(way);
    file->device = info.st_dev;
    file->node = info.st_ino;
    file->hash = hash | 1;
    return GP_OK;
}

// -- the list ----------------------------------------------------------------

static gp_status append(struct gp_output_guard *c, struct output file)
{
    void *block = c->file;
    const gp_status st = gp_resize(c->log, "output list",
                                   (c->n + 1) * sizeof file, &block);
    if (st)
        return st;
    c->file = block;
    file.order = c->n;
    file.name = gp_strdup(file.name);
    if (!file.name)
        return gp_no_memory(c->log, file.as);
    c->file[c->n++] = file;
    return GP_OK;
}

gp_status gp_output_guard_add(struct gp_output_guard *c, const char *path,
                              const char *what, const char *as, const char *of)
{
    struct output file = {.name = (char *) (uintptr_t) path, .as = as,
                          .of = of};
    struct stat info;
    bool exists, link = false;
    gp_status st = GP_OK;
    snprintf(file.what, sizeof file.what, "%s", what);
    if (gp_is_dash(path)) { // `-` itself, and the file that stdout may be
        file.hash = 1;      // no folder has device 0 and node 0
        st = append(c, file);
        exists = fstat(STDOUT_FILENO, &info) == 0;
        if (st || !exists)
            return st;
        file.hash = 0;
        file.open = true;
    } else {
        link = lstat(path, &info) == 0 && S_ISLNK(info.st_mode);
        exists = stat(path, &info) == 0;
        file.open = exists && gp_file_descriptor(path) >= 0;
    }
    if (exists && !S_ISREG(info.st_mode))
        return GP_OK;
    if (exists) {
        file.device = info.st_dev;
        file.node = info.st_ino;
        c->exists = true;
        return append(c, file);
    }
    // writing through a dangling link makes its target; a link that cannot be
    // resolved is reported when it is opened
    char *const end = link ? gp_file_resolve(path) : NULL;
    if (link && !end && errno == ENOMEM)
        return gp_no_memory(c->log, path);
    st = find_place(c->log, end ? end : path, &file);
    gp_free(end);
    return st ? st : append(c, file);
}

void gp_output_guard_end(struct gp_output_guard *c)
{
    for (size_t i = 0; i < c->n; i++)
        gp_free(c->file[i].name);
    gp_free(c->file);
    *c = (struct gp_output_guard) {0};
}

// -- comparing ---------------------------------------------------------------

#define ORDER(a, b) (((a) > (b)) - ((a) < (b)))

/* Orders by file identity. */
static int by_file(const void *a, const void *b)
{
    const struct output *x = a, *y = b;
    return x->device != y->device ? ORDER(x->device, y->device)
         : x->node != y->node     ? ORDER(x->node, y->node)
                                  : ORDER(x->hash, y->hash);
}

static int by_file_and_order(const void *a, const void *b)
{
    const struct output *x = a, *y = b;
    const int order = by_file(a, b);
    return order ? order : ORDER(x->order, y->order);
}

gp_status gp_output_guard_settle(struct gp_output_guard *c)
{
    const struct output *first = NULL;
    gp_status st = GP_OK;
    char what[24];
    for (const struct gp_option *o = gp_options; o->name && !st; o++) {
        const char *const name = file_of(c->s, o, true);
        snprintf(what, sizeof what, "--%s", o->name);
        if (name)
            st = gp_output_guard_add(c, name, what, name, NULL);
    }
    if (c->n)
        qsort(c->file, c->n, sizeof *c->file, by_file_and_order);
    for (size_t i = 1; i < c->n; i++) {
        const struct output *const file = &c->file[i];
        const bool same = by_file(file - 1, file) == 0 &&
                          !(file[-1].open && file->open);
        if (same && (!first || file->order < first->order))
            first = file;
    }
    if (first && !st) {
        const struct output x = first[-1], y = first[0];
        st = gp_fail(c->log, GP_ERR_USAGE, "%s: given for two outputs (%s "
            "%s%s%s and %s %s%s%s); %s", x.name, x.what, x.as,
            x.of ? " for " : "", x.of ? x.of : "", y.what, y.as,
            y.of ? " for " : "", y.of ? y.of : "", gp_is_dash(x.name)
            ? "only one can go to stdout" : "give each a name of its own");
    }
    char path[PATH_MAX];
    for (int i = 0; !st && gp_kernel_file(c->s, i, path); i++) {
        if (*path)
            st = gp_output_guard_input(
                c, i < c->s->kernel.words.n ? "--kernel" : "--light-group",
                path);
    }
    for (int i = 0; i < c->s->words.settings.n && !st; i++)
        st = gp_output_guard_input(c, "--settings", c->s->words.settings.at[i]);
    for (int i = 0; i < c->s->keyeds && !st; i++) {
        const struct gp_keyed *const k = &c->s->keyed[i];
        snprintf(what, sizeof what, "--%s", k->option->name);
        if (k->file)
            st = gp_output_guard_input(c, what, k->file);
    }
    for (const struct gp_option *o = gp_options; o->name && !st; o++) {
        const char *const name = file_of(c->s, o, false);
        snprintf(what, sizeof what, "--%s", o->name);
        if (name)
            st = gp_output_guard_input(c, what, name);
    }
    return st;
}

gp_status gp_output_guard_input(const struct gp_output_guard *c, const char *what,
                           const char *path)
{
    struct stat info;
    if (!c->exists || (gp_is_dash(path) ? fstat(STDIN_FILENO, &info)
                                        : stat(path, &info)) != 0)
        return GP_OK;
    const struct output key = {.device = info.st_dev, .node = info.st_ino};
    const struct output *const found =
        bsearch(&key, c->file, c->n, sizeof key, by_file);
    return !found ? GP_OK
                  : gp_fail(c->log, GP_ERR_USAGE, "%s: %s would replace a file "
                        "that is read (%s %s); write to another name",
                        found->name, found->what, what, path);
}

gp_status gp_output_guard_check(const struct gp_log *log,
    const struct gp_settings *s, const char *what, const char *path)
{
    struct gp_output_guard c = {.log = log, .s = s};
    enum gp_target_kind kind;
    const char *out;
    gp_status st = GP_OK;
    for (int i = 0; (out = gp_output_at(s, i, &kind)) && !st; i++)
        st = gp_output_guard_add(
            &c, out, kind == GP_TARGET_PICTURE ? "-o" : "--debug", out, NULL);
    st = st ? st : gp_output_guard_settle(&c);
    if (!st && path)
        st = gp_output_guard_input(&c, what, path);
    gp_output_guard_end(&c);
    return st;
}
