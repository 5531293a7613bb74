#include "app/files.h"

#include "core/memory.h"
#include "io/file_name.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// -- files of options --------------------------------------------------------

/* Plain names; where one is a pattern, its frames are the owner's to add. */
static const struct single {
    const char *what;
    size_t at;  // of its const char * in struct gp_settings
    bool written;
} singles[] = {
#define SINGLE(f, what, written) {what, offsetof(struct gp_settings, f), written}
    SINGLE(report, "--report", true),
    SINGLE(bench.csv, "--csv", true),
    SINGLE(bench.json, "--json", true),
    SINGLE(bench.plot, "--plot", true),
    SINGLE(kernel.source, "--kernel", false),
    SINGLE(sun.camera, "--camera", false),
    SINGLE(sun.lights, "--lights", false),
    SINGLE(sun.flare, "--flare", false),
    SINGLE(sun.depth_file, "--depth-file", false),
    SINGLE(sun.mask_file, "--mask-file", false),
    SINGLE(ocio.config, "--ocio", false),
};
enum { SINGLES = sizeof singles / sizeof singles[0] };

/* Its name, or NULL when it is not given. */
static const char *single_name(const struct gp_settings *s, int i)
{
    const char *name;
    memcpy(&name, (const char *) s + singles[i].at, sizeof name);
    const bool config = strcmp(singles[i].what, "--ocio") == 0;
    if (name && config && (!*name || strcmp(name, "env") == 0))
        return getenv("OCIO");
    return name;
}

// -- folders -----------------------------------------------------------------

/* FNV-1a, 64 bits. */
static uint64_t hash_on(uint64_t h, const char *text, size_t n)
{
    for (size_t i = 0; i < n; i++)
        h = (h ^ (unsigned char) text[i]) * 1099511628211u;
    return h;
}
#define HASH_START 14695981039346656037u

/* A path as --create-dir would make its folders. */
struct walk {
    char *way, *rest;  // a folder that is there; names below it that are not,
                       // each behind a slash
    size_t at, left;   // bytes of these
};

static bool is_folder(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

static size_t add_name(char *to, size_t at, const char *name, size_t n)
{
    to[at] = '/';
    memcpy(to + at + 1, name, n);
    to[at + 1 + n] = '\0';
    return at + 1 + n;
}

static void step(struct walk *w, const char *name, size_t n)
{
    if (n == 0 || (n == 1 && *name == '.'))
        return;
    if (w->left && n == 2 && memcmp(name, "..", 2) == 0) {
        while (w->rest[--w->left] != '/')
            ;
        w->rest[w->left] = '\0';
        return;
    }
    if (!w->left) {
        const size_t end = add_name(w->way, w->at, name, n);
        if (is_folder(w->way)) {
            w->at = end;
            return;
        }
        w->way[w->at] = '\0';
    }
    w->left = add_name(w->rest, w->left, name, n);
}

static gp_status look_at_folder(const struct gp_files *f,
                                struct gp_file_folder *to)
{
    const size_t room = strlen(to->path) + 3;
    struct stat info;
    void *block;
    to->tail = HASH_START;
    if (stat(to->path, &info) != 0) {
        gp_status st = gp_alloc_zero(f->log, "file names", 2, room, &block);
        if (st)
            return st;
        struct walk w = {.way = block, .rest = (char *) block + room, .at = 1};
        w.way[0] = to->path[0] == '/' ? '/' : '.';
        for (const char *p = to->path; *p; p += *p == '/') {
            const size_t n = strcspn(p, "/");
            step(&w, p, n);
            p += n;
        }
        to->tail = hash_on(to->tail, w.rest, w.left);
        if (stat(w.way, &info) != 0) // taken away meanwhile
            info.st_dev = info.st_ino = 0;
        gp_free(block);
    }
    to->device = info.st_dev;
    to->node = info.st_ino;
    return GP_OK;
}

/* The folder that `path` is in; the last few are kept. */
static gp_status find_folder(struct gp_files *f, const char *path,
                             const struct gp_file_folder **out)
{
    char *const name = gp_file_folder(path);
    if (!name)
        return gp_fail(f->log, GP_ERR_BUG, "%s: out of memory", path);
    for (int i = 0; i < GP_FILE_FOLDERS; i++) {
        *out = &f->folder[i];
        if ((*out)->path && strcmp((*out)->path, name) == 0) {
            gp_free(name);
            return GP_OK;
        }
    }
    struct gp_file_folder *const to =
        &f->folder[f->folders++ % GP_FILE_FOLDERS];
    gp_free(to->path);
    to->path = name;
    *out = to;
    return look_at_folder(f, to);
}

// -- files -------------------------------------------------------------------

/* The file that will be made under a name that is not there. */
static gp_status find_made(struct gp_files *f, const char *path,
                           struct gp_file_id *id)
{
    const struct gp_file_folder *folder = f->folder;
    gp_status st = find_folder(f, path, &folder);
    if (st)
        return st;
    const char *const slash = strrchr(path, '/');
    const char *const base = slash ? slash + 1 : path;
    const uint64_t tail = hash_on(hash_on(folder->tail, "/", 1), base,
                                  strlen(base));
    id->device = folder->device;
    id->node = folder->node;
    id->tail = tail ? tail : 1;
    return GP_OK;
}

/* The file that a link to nothing will make; where the link cannot be followed
 * there will be none, and opening it says why. */
static gp_status find_linked(struct gp_files *f, const char *path,
                             struct gp_file_id *id)
{
    char *const end = gp_file_resolve(path);
    if (!end && errno == ENOMEM)
        return gp_fail(f->log, GP_ERR_BUG, "%s: out of memory", path);
    const gp_status st = find_made(f, end ? end : path, id);
    gp_free(end);
    return st;
}

/* Sets what tells the file from others; *counts: it may be lost. */
static gp_status identify(struct gp_files *f, const char *path,
                          struct gp_file_id *id, bool *counts)
{
    struct stat info;
    *counts = true;
    bool there = lstat(path, &info) == 0;
    const bool link = there && S_ISLNK(info.st_mode);
    if (link)
        there = stat(path, &info) == 0;
    if (!there)
        return link ? find_linked(f, path, id) : find_made(f, path, id);
    id->device = info.st_dev;
    id->node = info.st_ino;
    id->open = *path == '/' && gp_file_is_straight(path);
    *counts = S_ISREG(info.st_mode);
    f->there = f->there || *counts;
    return GP_OK;
}

// -- the list ----------------------------------------------------------------

static gp_status add(struct gp_files *f, struct gp_file_id id)
{
    if (f->n == f->room) {
        const size_t room = f->room ? 2 * f->room : 16;
        void *block = f->id;
        gp_status st = gp_resize(f->log, "output list", room * sizeof id,
                                 &block);
        if (st)
            return st;
        f->id = block;
        f->room = room;
    }
    f->id[f->n++] = id;
    return GP_OK;
}

/* `-` itself, and the file that it may stand for. */
static gp_status add_stdout(struct gp_files *f, struct gp_file_id id)
{
    struct stat info;
    id.tail = 1; // of no folder: none has device 0 and node 0
    gp_status st = add(f, id);
    if (st || fstat(STDOUT_FILENO, &info) != 0 || !S_ISREG(info.st_mode))
        return st;
    id.device = info.st_dev;
    id.node = info.st_ino;
    id.tail = 0;
    id.open = true;
    f->there = true;
    return add(f, id);
}

gp_status gp_files_write(struct gp_files *f, const char *path, int role,
                         int item)
{
    struct gp_file_id id = {.role = role, .item = item};
    bool counts;
    if (strcmp(path, "-") == 0)
        return add_stdout(f, id);
    gp_status st = identify(f, path, &id, &counts);
    return st || !counts ? st : add(f, id);
}

gp_status gp_files_begin(const struct gp_log *log,
                         const struct gp_settings *s,
                         struct gp_file_owner (*owner)(
                             const void *user, const struct gp_file_id *id),
                         const void *user, struct gp_files *out)
{
    gp_status st = GP_OK;
    *out = (struct gp_files) {
        .log = log, .s = s, .owner = owner, .user = user,
    };
    for (int i = 0; i < SINGLES && !st; i++) {
        const char *const name = single_name(s, i);
        if (name && singles[i].written)
            st = gp_files_write(out, name, -1 - i, 0);
    }
    return st;
}

void gp_files_end(struct gp_files *f)
{
    for (int i = 0; i < GP_FILE_FOLDERS; i++)
        gp_free(f->folder[i].path);
    gp_free(f->id);
    *f = (struct gp_files) {0};
}

// -- one against the other ---------------------------------------------------

/* Order of files alone. */
static int by_file(const void *a, const void *b)
{
    const struct gp_file_id *x = a, *y = b;
    if (x->device != y->device)
        return x->device > y->device ? 1 : -1;
    if (x->node != y->node)
        return x->node > y->node ? 1 : -1;
    return (x->tail > y->tail) - (x->tail < y->tail);
}

/* Those of one file in the order of the command line's items. */
static int by_id(const void *a, const void *b)
{
    const struct gp_file_id *x = a, *y = b;
    const int order = by_file(a, b);
    if (order)
        return order;
    if (x->item != y->item)
        return x->item > y->item ? 1 : -1;
    return (x->role > y->role) - (x->role < y->role);
}

static struct gp_file_owner owner_of(const struct gp_files *f,
                                     const struct gp_file_id *id)
{
    if (id->role >= 0)
        return f->owner(f->user, id);
    const char *const name = single_name(f->s, -1 - id->role);
    return (struct gp_file_owner) {
        .name = gp_strdup(name), .what = singles[-1 - id->role].what,
        .as = name,
    };
}

/* The words behind a name. */
#define OF(o)                                                                 \
    (o).of ? " for " : "", (o).of ? (o).of : "", (o).view ? ", view " : "",   \
    (o).view ? (o).view : ""

/* "" for a full memory, where the line is the least of the troubles. */
static const char *shown(const struct gp_file_owner *o)
{
    return o->name ? o->name : "";
}

static gp_status fail_twice(const struct gp_files *f,
                            const struct gp_file_id *a,
                            const struct gp_file_id *b)
{
    const struct gp_file_owner x = owner_of(f, a), y = owner_of(f, b);
    const bool dash = strcmp(shown(&x), "-") == 0;
    gp_status st = gp_fail(
        f->log, GP_ERR_USAGE,
        "%s: given for two outputs (%s %s%s%s%s%s and %s %s%s%s%s%s); %s",
        shown(&x), x.what, x.as, OF(x), y.what, y.as, OF(y),
        dash ? "only one can go to stdout" : "give each a name of its own");
    gp_free(x.name);
    gp_free(y.name);
    return st;
}

gp_status gp_files_settle(struct gp_files *f)
{
    const struct gp_file_id *first = NULL;
    gp_status st = GP_OK;
    if (f->n)
        qsort(f->id, f->n, sizeof *f->id, by_id);
    for (size_t i = 1; i < f->n; i++) {
        const struct gp_file_id *const id = &f->id[i];
        const bool same = by_file(id - 1, id) == 0 &&
                          !(id[-1].open && id->open);
        if (same && (!first || id->item < first->item))
            first = id;
    }
    if (first)
        return fail_twice(f, first - 1, first);
    for (int i = 0; i < SINGLES && !st; i++) {
        const char *const name = single_name(f->s, i);
        if (name && !singles[i].written)
            st = gp_files_read(f, singles[i].what, name);
    }
    return st;
}

gp_status gp_files_read(const struct gp_files *f, const char *what,
                        const char *path)
{
    struct stat info;
    if (!f->there || (strcmp(path, "-") == 0 ? fstat(STDIN_FILENO, &info)
                                             : stat(path, &info)) != 0)
        return GP_OK;
    const struct gp_file_id key = {.device = info.st_dev,
                                   .node = info.st_ino};
    const struct gp_file_id *const found =
        bsearch(&key, f->id, f->n, sizeof key, by_file);
    if (!found)
        return GP_OK;
    const struct gp_file_owner o = owner_of(f, found);
    gp_status st = gp_fail(f->log, GP_ERR_USAGE,
                           "%s: %s would replace a file that is read (%s %s); "
                           "write to another name", shown(&o), o.what, what,
                           path);
    gp_free(o.name);
    return st;
}
