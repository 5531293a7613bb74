/* Output files where the system says no: folders, links, permissions, names
 * that are taken, more of them at once than a signal can remove. */
#include "unit.h"
#include "write_fixture.h"

#include "io/file.h"
#include "io/io_priv.h"

#include <errno.h>
#include <sys/stat.h>
#include <sys/wait.h>

static void put_file(const char *path, const char *text)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
}

/* One error line that names the file, why, and what to do. */
static void assert_refused(const char *path, bool create_dir, bool checked,
                           const char *why)
{
    struct gp_file *f = NULL;
    const int had = wf_names();
    assert_int_equal(gp_file_check(&wf_log, path, create_dir),
                     checked ? GP_ERR_IO : GP_OK);
    wf_line[0] = '\0';
    assert_int_equal(gp_file_open(&wf_log, path, create_dir, &f), GP_ERR_IO);
    assert_null(f);
    assert_ptr_equal(strstr(wf_line, path), wf_line);
    wf_assert_said(why);
    wf_assert_said("; ");
    assert_int_equal(wf_names(), had); // no temporary file stays
}

static void folders_that_are_none(void **state)
{
    (void) state;
    static const struct {
        const char *name;
        bool create_dir, checked; // told before anything is written
        int why;
    } row[] = {
        {"plain/x", false, true, ENOTDIR},
        {"plain/x", true, true, ENOTDIR},
        {"plain/y/x", false, true, ENOTDIR},
        {"plain/y/x", true, true, ENOTDIR},
        {"dangling/x", false, true, ENOENT},
        {"dangling/x", true, false, EEXIST},
        {"round/x", false, true, ELOOP},
        {"round/x", true, true, ELOOP},
        {"round", false, false, ELOOP},
    };
    put_file(wf_path("plain"), "text");
    assert_int_equal(symlink("nowhere", wf_path("dangling")), 0);
    assert_int_equal(symlink("round", wf_path("round")), 0);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        assert_refused(wf_path(row[i].name), row[i].create_dir,
                       row[i].checked, strerror(row[i].why));
}

static void folders_are_made_or_not(void **state)
{
    (void) state;
    struct stat s;
    put_file(wf_path("plain"), "text");
    errno = 0;
    assert_int_equal(gp_file_make_folders(wf_path("plain/x")), -1);
    assert_int_equal(errno, EEXIST);
    assert_int_equal(gp_file_make_folders(wf_path("plain/a/x")), -1);
    assert_int_equal(symlink("nowhere", wf_path("dangling")), 0);
    assert_int_equal(gp_file_make_folders(wf_path("dangling/x")), -1);
    assert_int_equal(errno, EEXIST);
    assert_int_equal(wf_names(), 2);
    assert_int_equal(gp_file_make_folders(wf_path("new/x")), 0);
    assert_int_equal(gp_file_make_folders(wf_path("new/x")), 0); // it is there
    assert_int_equal(stat(wf_path("new"), &s), 0);
    assert_true(S_ISDIR(s.st_mode));
}

/* A link with a full path to what is not there yet. */
static void links_to_full_paths(void **state)
{
    (void) state;
    struct gp_file *f;
    struct stat s;
    char *const aim = strdup(wf_path("aim"));
    const char *const link = wf_path("link");
    assert_int_equal(symlink(aim, link), 0);
    char *const found = gp_file_resolve(link);
    assert_string_equal(found, aim);
    free(found);
    assert_int_equal(gp_file_open(&wf_log, link, false, &f), GP_OK);
    assert_int_equal(gp_file_write(f, "made", 4), GP_OK);
    assert_int_equal(gp_file_commit(&f), GP_OK);
    assert_true(gp_file_exists(aim));
    assert_int_equal(lstat(link, &s), 0);
    assert_true(S_ISLNK(s.st_mode));
    free(aim);
}

/* Root gives its rights up for a while. False where it cannot. */
static bool become_nobody(void)
{
    return geteuid() != 0 || setresuid(65534, 65534, 0) == 0;
}

static void without_permission(void **state)
{
    (void) state;
    static const struct {
        const char *name;
        bool create_dir, checked;
    } row[] = {
        {"sealed", false, true}, {"sealed", true, true},
        {"closed/x", false, true}, {"closed/x", true, true},
        {"closed/new/x", true, false}, // why the folder cannot be made
    };
    const uid_t user = geteuid();
    struct stat s;
    put_file(wf_path("sealed"), "old");
    assert_int_equal(mkdir(wf_path("closed"), 0555), 0);
    assert_int_equal(chmod(wf_path("sealed"), 0400), 0);
    assert_int_equal(chmod(wf_folder, 0755), 0);
    const bool able = become_nobody();
    for (size_t i = 0; able && i < sizeof row / sizeof *row; i++)
        assert_refused(wf_path(row[i].name), row[i].create_dir,
                       row[i].checked, strerror(EACCES));
    if (user == 0)
        assert_int_equal(setresuid(0, 0, 0), 0);
    assert_int_equal(stat(wf_path("sealed"), &s), 0);
    assert_int_equal(s.st_size, 3);
    assert_int_equal(chmod(wf_path("closed"), 0700), 0);
    if (!able)
        skip(); // a container without other users
}

/* Patches reach as far as what is written, and no byte further. */
static void patches_stay_inside(void **state)
{
    (void) state;
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
    assert_int_equal(gp_file_open(&wf_log, wf_path("p"), false, &f), GP_OK);
    assert_int_equal(gp_file_write(f, "abcdef", 6), GP_OK);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        wf_line[0] = '\0';
        assert_int_equal(gp_file_patch(f, row[i].at, "ABCDEF", row[i].size),
                         row[i].st);
        wf_assert_said(row[i].st ? "outside" : "");
    }
    assert_int_equal(gp_file_commit(&f), GP_OK); // what was refused is undone
    size_t n;
    uint8_t *bytes = wf_read(wf_path("p"), &n);
    assert_string_equal((const char *) bytes, "ABCDEA");
    free(bytes);
}

/* All names of one target that this process may use are taken. */
static void no_name_is_left(void **state)
{
    (void) state;
    enum { TRIES = 1000 };
    const char *const path = wf_path("many");
    for (int i = 0; i < TRIES; i++) {
        char *name = gp_file_temp_name(path, i);
        put_file(name, "");
        free(name);
    }
    assert_refused(path, false, false, strerror(EEXIST));
    assert_int_equal(wf_names(), TRIES);
    // the last of them is as good as the first
    char *last = gp_file_temp_name(path, TRIES - 1);
    struct gp_file *f;
    assert_int_equal(remove(last), 0);
    assert_int_equal(gp_file_open(&wf_log, path, false, &f), GP_OK);
    assert_int_equal(access(last, F_OK), 0);
    assert_int_equal(gp_file_commit(&f), GP_OK);
    free(last);
}

enum { LIVE = 64, OPEN = LIVE + 3 }; // a signal removes so many of them

static void open_many(struct gp_file *f[OPEN])
{
    for (int i = 0; i < OPEN; i++) {
        char name[16];
        snprintf(name, sizeof name, "f%d", i);
        assert_int_equal(gp_file_open(&wf_log, wf_path(name), false, &f[i]),
                         GP_OK);
        assert_int_equal(gp_file_write(f[i], name, strlen(name)), GP_OK);
    }
    assert_int_equal(wf_names(), OPEN);
}

static void more_files_than_a_signal_removes(void **state)
{
    (void) state;
    static struct gp_file *f[OPEN];
    open_many(f);
    for (int i = OPEN - 1; i >= 0; i--) {
        char name[16];
        size_t n;
        snprintf(name, sizeof name, "f%d", i);
        assert_int_equal(gp_file_commit(&f[i]), GP_OK);
        uint8_t *bytes = wf_read(wf_path(name), &n);
        assert_string_equal((const char *) bytes, name);
        free(bytes);
    }
    assert_int_equal(wf_names(), OPEN);
}

static void files_under_way_are_removed(void **state)
{
    (void) state;
    static struct gp_file *f[OPEN];
    fflush(NULL); // or the child would print it once more
    const pid_t child = fork();
    if (child == 0) {
        open_many(f);
        gp_temp_remove_all();
        exit(wf_names() == OPEN - LIVE ? 0 : 1);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    assert_int_equal(wf_names(), OPEN - LIVE);
}

SUITE_OF_EACH(file_hard, wf_start, wf_end,
    folders_that_are_none, folders_are_made_or_not, links_to_full_paths,
    without_permission, patches_stay_inside, no_name_is_left,
    more_files_than_a_signal_removes, files_under_way_are_removed)
