// SPDX-License-Identifier: Apache-2.0
/* Output files: whole under their final name, or not there at all, also where
 * the system says no. */
#include "unit.h"
#include "write_fixture.h"
#include "fail.h"
#include "io/file.h"
#include "io/io_priv.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

static void assert_text(const char *path, const char *text)
{
    size_t n;
    uint8_t *bytes = wf_read(path, &n);
    assert_string_equal((const char *) bytes, text);
    free(bytes);
}

static void write_text(const char *path, const char *text)
{
    struct gp_file *f;
    assert_ok(gp_file_open(&kept_all, path, false, false, &f));
    assert_ok(gp_file_write(f, text, strlen(text)));
    assert_ok(gp_file_commit(&f));
    assert_text(path, text);
}

static void whole_or_nothing(void **state)
{
    struct gp_file *f;
    const char *path = wf_path("whole");
    assert_ok(gp_file_open(&kept_all, path, false, false, &f));
    assert_ok(gp_file_write(f, "abcdef", 6));
    assert_false(gp_file_exists(path));
    assert_int_equal(wf_names(), 1); // the temporary one
    assert_ok(gp_file_patch(f, 1, "XY", 2));
    assert_ok(gp_file_commit(&f));
    assert_null(f);
    assert_int_equal(wf_names(), 1);
    assert_text(path, "aXYdef");

    assert_ok(gp_file_open(&kept_all, path, false, false, &f));
    assert_ok(gp_file_write(f, "other", 5));
    gp_file_discard(&f);
    gp_file_discard(&f); // twice is fine
    assert_text(path, "aXYdef");
    assert_int_equal(wf_names(), 1);
}

static void links_and_permissions_stay(void **state)
{
    struct stat s;
    wf_write_text(wf_path("real"), "old");
    assert_int_equal(chmod(wf_path("real"), 0751), 0); // execute bits too
    assert_int_equal(symlink("real", wf_path("link")), 0);
    write_text(wf_path("link"), "new");
    assert_text(wf_path("real"), "new");
    assert_int_equal(stat(wf_path("real"), &s), 0);
    assert_int_equal(s.st_mode & 0777, 0751);
    remove(wf_path("real"));
    // a missing target is made, by a full path too
    char *const found = gp_file_resolve(wf_path("link"));
    assert_string_equal(found, wf_path("real"));
    assert_int_equal(symlink(found, wf_path("chain")), 0);
    free(found);
    write_text(wf_path("chain"), "made");
    assert_text(wf_path("real"), "made");
    for (int i = 0; i < 2; i++) {
        assert_int_equal(lstat(wf_path(i ? "chain" : "link"), &s), 0);
        assert_true(S_ISLNK(s.st_mode));
    }
}

/* No file has more permissions than it is to keep, not even while it is
 * written. */
static void no_mode_is_wider(void **state)
{
    static const struct {
        mode_t mask, old, want; // old 0: a new file
    } row[] = {
        {0022, 0, 0644},    {0077, 0, 0600},    {0002, 0, 0664},
        {0, 0, 0666},       {0, 0600, 0600},    {0, 0640, 0640},
        {0077, 0644, 0644}, {0077, 0666, 0666}, {0, 0400, 0400},
    };
    const mode_t before = umask(0);
    for (size_t i = 0; i < COUNT(row); i++) {
        struct stat s;
        struct gp_file *f;
        const char *const path = wf_path("moded");
        remove(path);
        if (row[i].old) {
            wf_write_text(path, "old");
            assert_int_equal(chmod(path, row[i].old), 0);
        }
        umask(row[i].mask);
        if (geteuid() == 0 || row[i].old != 0400) {
            assert_ok(gp_file_open(&kept_all, path, false, false, &f));
            assert_int_equal(fail_made_mode & ~row[i].mask & ~row[i].want, 0);
            assert_ok(gp_file_commit(&f));
            assert_int_equal(stat(path, &s), 0);
            assert_int_equal(s.st_mode & 0777, row[i].want);
        }
        umask(0);
    }
    umask(before);
}

static void names(void **state)
{
    static const struct {
        const char *path, *ending;
    } rows[] = {
        {"a.exr", "exr"}, {"x/y/a.EXR", "exr"}, {"/a.b.Png", "png"}, {"a", ""},
        {".exr", ""}, {"x.d/a", ""}, {"a.", ""}, {"-", ""},
        {"a.averyverylongending", ""},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        char ending[16];
        gp_file_ending(rows[i].path, ending, sizeof ending);
        assert_string_equal(ending, rows[i].ending);
    }
    // a name of the greatest length has a temporary name that fits
    char name[256];
    snprintf(name, sizeof name, "%0255d", 0);
    write_text(wf_path(name), "text");
}

/* Opens both targets, writes to both, and keeps or discards them in turn. */
static void write_both(const char *one, const char *other, bool keep_other)
{
    struct gp_file *a, *b;
    assert_ok(gp_file_open(&kept_all, one, false, false, &a));
    assert_ok(gp_file_open(&kept_all, other, false, false, &b));
    assert_ok(gp_file_write(a, "first", 5));
    assert_ok(gp_file_write(b, "second, longer", 14));
    if (!keep_other)
        gp_file_discard(&b);
    assert_ok(gp_file_commit(&a));
    assert_text(one, "first");
    if (keep_other)
        assert_ok(gp_file_commit(&b));
}

/* Processes with the same number (of other containers or machines) and names
 * that are cut to the same one: each has a temporary file of its own. */
static void taken_names(void **state)
{
    char long_a[256], long_b[256];
    snprintf(long_a, sizeof long_a, "%0254da", 0);
    snprintf(long_b, sizeof long_b, "%0254db", 0);
    char *a = strdup(wf_path(long_a)), *b = strdup(wf_path(long_b));
    char *same = strdup(wf_path("same"));
    write_both(a, b, true);
    assert_text(b, "second, longer");
    write_both(same, same, true);
    assert_text(same, "second, longer");
    write_both(same, same, false);
    char tail[64];
    snprintf(tail, sizeof tail, ".same.%ld.tmp", (long) getpid());
    char *stranger = strdup(wf_path(tail));
    wf_write_text(stranger, "another run's");
    write_both(same, a, false);
    assert_text(stranger, "another run's");
    char *const made[] = {a, b, same, stranger};
    for (size_t i = 0; i < COUNT(made); i++) {
        remove(made[i]);
        free(made[i]);
    }
    assert_int_equal(wf_names(), 0); // nothing is left
}

/* Writes 4 MiB to `path`; the first failure. */
static gp_status write_much(const char *path)
{
    struct gp_file *f;
    static uint8_t block[1 << 16];
    gp_status st = gp_file_open(&kept_all, path, false, false, &f);
    if (st)
        return st;
    for (int i = 0; i < 64 && !st; i++)
        st = gp_file_write(f, block, sizeof block);
    gp_status last = gp_file_commit(&f);
    assert_int_equal(st ? st : last, last); // commit repeats the failure
    return last;
}

static void full_disk(void **state)
{
    if (access("/dev/full", W_OK) == 0) {
        assert_int_equal(write_much("/dev/full"), GP_ERR_IO);
        assert_kept(strerror(ENOSPC));
    }
    if (geteuid() == 0 && mount("none", folder, "tmpfs", 0, "size=1m") == 0) {
        wf_write_text(wf_path("f"), "old");
        assert_int_equal(write_much(wf_path("f")), GP_ERR_IO);
        assert_kept(strerror(ENOSPC));
        assert_int_equal(wf_names(), 1);
        assert_text(wf_path("f"), "old");
        assert_int_equal(umount(folder), 0);
    }
    // a limit on the size of files, for those who may not mount
    struct rlimit old, small = {1 << 20, 1 << 20};
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    small.rlim_max = old.rlim_max;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    gp_status st = write_much(wf_path("limited"));
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    assert_int_equal(st, GP_ERR_IO);
    assert_kept(strerror(EFBIG));
    assert_int_equal(wf_names(), 0);
}

/* Network file systems report a full disk when a file is closed. */
static void a_close_that_fails(void **state)
{
    struct gp_file *f;
    wf_write_text(wf_path("f"), "old");
    for (int straight = 0; straight < 2; straight++) {
        assert_ok(gp_file_open(&kept_all, straight ? "/dev/null" : wf_path("f"),
                               false, false, &f));
        assert_ok(gp_file_write(f, "new", 3));
        fail_always.closes = true;
        const gp_status st = gp_file_commit(&f);
        fail_always.closes = false;
        assert_int_equal(st, GP_ERR_IO);
        assert_kept(strerror(EIO));
    }
    assert_int_equal(wf_names(), 1);
    assert_text(wf_path("f"), "old");
}

static void pipes(void **state)
{
    char path[64];
    int ends[2];
    struct gp_file *f;
    assert_int_equal(pipe(ends), 0);
    snprintf(path, sizeof path, "/dev/fd/%d", ends[1]);
    assert_ok(gp_file_open(&kept_all, path, false, false, &f));
    assert_ok(gp_file_write(f, "abc", 3));
    assert_ok(gp_file_patch(f, 0, "A", 1));
    assert_ok(gp_file_commit(&f));
    char got[4] = "";
    assert_int_equal(read(ends[0], got, 3), 3);
    assert_string_equal(got, "Abc");
    close(ends[0]);
    signal(SIGPIPE, SIG_IGN);
    assert_int_equal(write_much(path), GP_ERR_IO);
    assert_kept(strerror(EPIPE));
    close(ends[1]);
}

/* A descriptor's file is written on from where it is. */
static void descriptors(void **state)
{
    static const struct {
        const char *name;
        int fd;
    } row[] = {
        {"-", 1}, {"/dev/stdout", 1}, {"/dev/stderr", 2}, {"/dev/fd/07", 7},
        {"/proc/self/fd/12", 12}, {"/dev/fd/", -1}, {"/dev/fd/-1", -1},
        {"/dev/fd/1x", -1}, {"/dev/fd/99999999999", -1}, {"dev/fd/1", -1},
        {"/proc/1/fd/1", -1}, {"stdout", -1},
        {"/proc/thread-self/fd/9", 9}, {"/dev/../dev/stdout", 1},
        {"/proc/self/fdinfo/1", -1}, {"/proc/self/fd/", -1},
        {"/proc/self/task/1/fd/1", -1},
    };
    for (size_t i = 0; i < COUNT(row); i++)
        assert_int_equal(gp_file_descriptor(row[i].name), row[i].fd);
    struct gp_file *f;
    char path[512];
    wf_write_text(wf_path("log"), "a long old log;");
    const int fd = open(wf_path("log"), O_WRONLY | O_APPEND);
    for (int i = 0; i < 2; i++) {
        snprintf(path, sizeof path, "/%s/fd/%d", i ? "proc/self" : "dev", fd);
        assert_ok(gp_file_open(&kept_all, path, false, false, &f));
        assert_ok(gp_file_write(f, "new", 3));
        assert_ok(gp_file_commit(&f));
    }
    assert_text(wf_path("log"), "a long old log;newnew");
    assert_int_equal(symlink(path, wf_path("link")), 0);
    assert_int_equal(gp_file_descriptor(wf_path("link")), fd);
    assert_true(gp_file_is_straight(wf_path("link")));
    close(fd);
    wf_write_text(wf_path("f"), "old");
    snprintf(path, sizeof path, "/proc/self/root%s", wf_path("f"));
    assert_int_equal(gp_file_open(&kept_all, path, false, false, &f),
                     GP_ERR_IO);
    assert_kept("own folder");
    assert_text(wf_path("f"), "old");
}

static void checks(void **state)
{
    static const struct {
        const char *path;
        enum gp_compression compression;
        int bits;
        gp_status st;
        const char *text;
    } rows[] = {
        {"a.exr", GP_COMPRESSION_AUTO, 8, GP_OK, ""},
        {"a.png", GP_COMPRESSION_PIZ, 16, GP_OK, ""},
        {"-", GP_COMPRESSION_AUTO, 8, GP_OK, ""},
        {"a.pfm", GP_COMPRESSION_AUTO, 8, GP_OK, ""},
        {"/dev/null", GP_COMPRESSION_AUTO, 8, GP_OK, ""},
        {"a", GP_COMPRESSION_AUTO, 8, GP_ERR_USAGE, "ending"},
        {"a.jpg", GP_COMPRESSION_AUTO, 16, GP_ERR_USAGE, "8 bits"},
        {"a.tif", GP_COMPRESSION_PIZ, 8, GP_ERR_USAGE, "compression"},
        {"no/where/a.exr", GP_COMPRESSION_AUTO, 8, GP_ERR_IO, "no/where"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_write_params p = GP_WRITE_DEFAULTS;
        p.compression = rows[i].compression;
        p.depth_bits = rows[i].bits;
        kept_clear();
        assert_int_equal(gp_write_check(&kept_all, &p, rows[i].path),
                         rows[i].st);
        assert_kept(rows[i].text);
        const bool exr = strstr(rows[i].path, ".exr") ||
                         strchr("-/", rows[i].path[0]);
        kept_clear();
        assert_int_equal(gp_write_hdr_check(&kept_all, &p, "-x keeps it",
                                            rows[i].path),
                         exr ? rows[i].st : GP_ERR_USAGE);
        assert_kept(exr ? rows[i].text : "-x keeps it, which only EXR can");
    }
}

// -- errors of the system ----------------------------------------------------

struct refused_row {
    const char *name;
    bool create_dir, checked; // reported before anything is written
    int why;
};

/* One error line that names the file, why, and what to do. */
static void assert_refused(const struct refused_row *row)
{
    struct gp_file *f = NULL;
    const char *const path = wf_path(row->name);
    const int had = wf_names();
    assert_int_equal(gp_file_check(&kept_all, path, row->create_dir),
                     row->checked ? GP_ERR_IO : GP_OK);
    kept_clear();
    assert_int_equal(gp_file_open(&kept_all, path, row->create_dir, false, &f),
                     GP_ERR_IO);
    assert_null(f);
    assert_ptr_equal(strstr(kept_line, path), kept_line);
    assert_kept(strerror(row->why));
    assert_kept("; ");
    assert_int_equal(wf_names(), had); // no temporary file stays
}

static void folders_are_made_or_not(void **state)
{
    static const struct refused_row row[] = {
        {"plain/x", true, true, ENOTDIR}, {"plain/a/x", true, true, ENOTDIR},
        {"dangling/x", true, false, EEXIST},
    };
    struct stat s;
    wf_write_text(wf_path("plain"), "text");
    assert_int_equal(symlink("nowhere", wf_path("dangling")), 0);
    for (size_t i = 0; i < COUNT(row); i++)
        assert_refused(&row[i]);
    for (int i = 0; i < 2; i++) { // missing, and there
        struct gp_file *f;
        assert_ok(
            gp_file_open(&kept_all, wf_path("new/er/x"), true, false, &f));
        gp_file_discard(&f);
        assert_int_equal(stat(wf_path("new/er"), &s), 0);
        assert_true(S_ISDIR(s.st_mode));
    }
}

static void without_permission(void **state)
{
    static const struct refused_row row[] = {
        {"sealed", false, true, EACCES}, {"sealed", true, true, EACCES},
        {"closed/x", false, true, EACCES}, {"closed/x", true, true, EACCES},
        {"closed/new/x", true, false, EACCES}, // cannot be made
    };
    const uid_t user = geteuid();
    wf_write_text(wf_path("sealed"), "old");
    assert_int_equal(mkdir(wf_path("closed"), 0555), 0);
    assert_int_equal(chmod(wf_path("sealed"), 0400), 0);
    assert_int_equal(chmod(folder, 0755), 0);
    // root gives its rights up for a while
    const bool able = user != 0 || setresuid(65534, 65534, 0) == 0;
    for (size_t i = 0; able && i < COUNT(row); i++)
        assert_refused(&row[i]);
    if (user == 0)
        assert_int_equal(setresuid(0, 0, 0), 0);
    assert_text(wf_path("sealed"), "old");
    assert_int_equal(chmod(wf_path("closed"), 0700), 0);
    if (!able)
        skip_for("no other users"); // a container without other users
}

/* Patches reach as far as what is written, and no byte further. */
static void patches_stay_inside(void **state)
{
    static const struct {
        uint64_t at;
        size_t size;
        gp_status st;
    } row[] = {
        {0, 6, GP_OK}, {5, 1, GP_OK}, {6, 0, GP_OK}, {6, 1, GP_ERR_BUG},
        {7, 0, GP_ERR_BUG}, {UINT64_MAX, 1, GP_ERR_BUG},
        {1, SIZE_MAX, GP_ERR_BUG},
    };
    struct gp_file *f;
    assert_ok(gp_file_open(&kept_all, wf_path("p"), false, false, &f));
    assert_ok(gp_file_write(f, "abcdef", 6));
    for (size_t i = 0; i < COUNT(row); i++) {
        kept_clear();
        assert_int_equal(gp_file_patch(f, row[i].at, "ABCDEF", row[i].size),
                         row[i].st);
        assert_kept(row[i].st ? "outside" : "");
    }
    assert_ok(gp_file_commit(&f)); // the refused write is undone
    assert_text(wf_path("p"), "ABCDEA");
}

SUITE_OF_EACH(file, wf_start, remove_folder, whole_or_nothing,
              links_and_permissions_stay,
              no_mode_is_wider, descriptors, names, taken_names, full_disk,
              a_close_that_fails, pipes, checks, folders_are_made_or_not,
              without_permission, patches_stay_inside)
