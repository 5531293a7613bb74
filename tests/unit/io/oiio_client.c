// SPDX-License-Identifier: Apache-2.0
/* io: the side of glarepp that asks the helper, against helpers that end, hang
 * and lie; and what the real one may not do. */
#include "unit.h"
#include "io/oiio/protocol.h"
#include "fail.h"
#include "oiio_here.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { W = 5, H = 7, MOST = 100 };

static const char ppm[] = "P6\n2 1\n255\n\377\0\0\0\0\377";
static char folder[] = "/tmp/glarepp-helper-XXXXXX";

// -- a helper that is made up -----------------------------------------------

/* Its reply about a picture of W x H x 1, whose samples are its process. */
static const struct gp_oiio_reply sound = {
    .protocol = GP_OIIO_PROTOCOL, .bytes = 10, .spec = {
        .w = W, .h = H, .channels = 1, .attributes = 1, .parts = 1,
    },
};
static const char sound_text[] = "Y\0\0ia\0\1\0\0"; // and its '\0'

static const struct lie {
    const char *name;
    struct gp_oiio_reply reply;
    const char *text; // of 10 bytes
} lies[] = {
#define LIE(name, x, w, h, full_w, channels, attributes, n, text)             \
    {name, {GP_OIIO_PROTOCOL, 0, n, {x, 0, w, h, 0, 0, full_w, 0, channels, 0, \
                                     0, attributes, 0, 1, 0, {0}}}, text}
    LIE("no width", 0, 0, H, 0, 1, 0, 3, "Y\0\0"),
    LIE("negative", 0, W, -1, 0, 1, 0, 3, "Y\0\0"),
    LIE("many pixels", 0, MOST, H, 0, 1, 0, 3, "Y\0\0"),
    LIE("overflow", 0, 1 << 28, 1 << 28, 0, 1, 0, 3, "Y\0\0"),
    LIE("no channels", 0, W, H, 0, 0, 0, 1, "\0"),
    LIE("many channels", 0, W, H, 0, 8193, 0, 3, "Y\0\0"),
    LIE("far", INT_MAX - 2, W, H, 0, 1, 0, 3, "Y\0\0"),
    LIE("display", 0, W, H, INT_MIN, 1, 0, 3, "Y\0\0"),
    LIE("name that does not end", 0, W, H, 0, 1, 0, 3, "YYY"),
    LIE("no colour space", 0, W, H, 0, 1, 0, 2, "Y\0"),
    LIE("fewer names", 0, W, H, 0, 9, 0, 3, "Y\0\0"),
    LIE("fewer attributes", 0, W, H, 0, 1, 1, 3, "Y\0\0"),
    LIE("attributes below 0", 0, W, H, 0, 1, -1, 3, "Y\0\0"),
    LIE("many attributes", 0, W, H, 0, 1, INT_MAX, 3, "Y\0\0"),
    LIE("attribute of no kind", 0, W, H, 0, 1, 1, 10, "Y\0\0xa\0b\0\0"),
    LIE("attribute cut off", 0, W, H, 0, 1, 1, 8, "Y\0\0fa\0\0\0"),
    LIE("text cut off", 0, W, H, 0, 1, 1, 8, "Y\0\0sa\0bb"),
    {"no image", {GP_OIIO_PROTOCOL, 0, 3, {0, 0, W, H, 0, 0, 0, 0, 1, 0, 0,
                                           0, 0, 0, 0, {0}}}, "Y\0\0"},
    {"other version", {GP_OIIO_PROTOCOL + 1, 0, 0, {0}}, ""},
    {"long text", {GP_OIIO_PROTOCOL, 0, UINT_MAX, {0}}, ""},
};
enum { LIES = sizeof lies / sizeof *lies };

static void reply_with(const struct gp_oiio_reply *reply, const char *text)
{
    (void) send(0, reply, sizeof *reply, MSG_NOSIGNAL);
    (void) send(0, text, reply->bytes > 10 ? 10 : reply->bytes, MSG_NOSIGNAL);
}

/* The next call, with its text; the last descriptor that came, or -1. */
static int hear(struct gp_oiio_ask *ask)
{
    _Alignas(struct cmsghdr) char control[CMSG_SPACE(2 * sizeof(int))];
    char text[4096];
    struct iovec data = {ask, sizeof *ask};
    struct msghdr m = {.msg_iov = &data, .msg_iovlen = 1,
                       .msg_control = control,
                       .msg_controllen = sizeof control};
    int fd[2] = {-1, -1};
    if (recvmsg(0, &m, MSG_WAITALL) != (ssize_t) sizeof *ask)
        _exit(0);
    const struct cmsghdr *const c = CMSG_FIRSTHDR(&m);
    if (c)
        memcpy(fd, CMSG_DATA(c), c->cmsg_len - CMSG_LEN(0));
    if (ask->bytes > 0 && recv(0, text, ask->bytes, MSG_WAITALL) < 0)
        _exit(0);
    return fd[1] >= 0 ? fd[1] : fd[0];
}

/* Floats to the shared memory. */
static void show_picture(const struct gp_oiio_ask *ask, int fd)
{
    float *const to = mmap(NULL, ask->size, PROT_READ | PROT_WRITE, MAP_SHARED,
                           fd, 0);
    if (ftruncate(fd, 1) == 0)
        _exit(9); // under glarepp's feet
    for (int i = 0; i < W * H; i++)
        to[i] = (float) i;
}

/* Plays a helper as MADE_UP says: this program, started by that name. */
__attribute__((constructor)) static void play(void)
{
    const char *const part = getenv("MADE_UP");
    const struct gp_oiio_reply hello = {.protocol = GP_OIIO_PROTOCOL};
    struct gp_oiio_reply no = hello;
    struct gp_oiio_ask ask;
    if (!part || strcmp(program_invocation_short_name, "glarepp-oiio") != 0)
        return;
    if (strcmp(part, "ends at its start") == 0)
        _exit(3);
    if (strcmp(part, "says nothing") == 0)
        pause();
    reply_with(&hello, "");
    for (;;) {
        const int fd = hear(&ask);
        if (ask.call == GP_OIIO_PIXELS && strcmp(part, "ends amid them") == 0)
            raise(SIGSEGV);
        if (ask.call == GP_OIIO_PIXELS) {
            show_picture(&ask, fd);
            reply_with(&hello, "");
            continue;
        }
        if (strcmp(part, "ends") == 0)
            raise(SIGKILL);
        if (strcmp(part, "hangs") == 0)
            pause();
        if (strcmp(part, "stops talking") == 0) {
            (void) send(0, &sound, sizeof sound / 2, 0);
            _exit(0);
        }
        no.end = strcmp(part, "is full") == 0 ? GP_OIIO_MEMORY
                                              : GP_OIIO_REFUSED;
        no.bytes = 3;
        if (strcmp(part, "is full") == 0 || strcmp(part, "refuses") == 0)
            reply_with(&no, "why");
        else if (strcmp(part, "writes nothing") == 0)
            reply_with(&hello, "");
        else if (*part >= '0' && *part <= '9')
            reply_with(&lies[atoi(part)].reply, lies[atoi(part)].text);
        else
            reply_with(&sound, sound_text);
        if (strcmp(part, "ends amid them") != 0 && strcmp(part, "shows") != 0)
            _exit(0);
    }
}

static void cast(const char *part)
{
    setenv("MADE_UP", part, 1);
    set_env("GLAREPP_BRIDGES", folder);
    setenv("GLAREPP_HELPER_SECONDS", "1", 1);
}

static int make_up(void **state)
{
    char self[PATH_MAX] = "", name[PATH_MAX];
    if (!mkdtemp(folder) ||
        readlink("/proc/self/exe", self, sizeof self - 1) < 0)
        return -1;
    snprintf(name, sizeof name, "%s/glarepp-oiio", folder);
    return symlink(self, name);
}

static int clean_up(void **state)
{
    char name[PATH_MAX];
    snprintf(name, sizeof name, "%s/glarepp-oiio", folder);
    unlink(name);
    return rmdir(folder);
}

/* The process of a helper of `parent` that lives, 0 when there is none. */
static pid_t helper_of(pid_t parent)
{
    char name[300], line[300];
    DIR *const d = opendir("/proc");
    pid_t found = 0;
    for (struct dirent *e; d && !found && (e = readdir(d));) {
        int of = 0;
        char state = 0, what[32] = "";
        snprintf(name, sizeof name, "/proc/%.20s/stat", e->d_name);
        FILE *const f = fopen(name, "r");
        if (f && fgets(line, sizeof line, f) &&
            sscanf(line, "%*d (%31[^)]) %c %d", what, &state, &of) == 3 &&
            of == parent && state != 'Z' && strcmp(what, "glarepp-oiio") == 0)
            found = atoi(e->d_name);
        if (f)
            fclose(f);
    }
    if (d)
        closedir(d);
    return found;
}

static void await_end(void)
{
    for (int i = 0; i < 2000 && helper_of(getpid()); i++)
        usleep(1000);
}

static gp_status open_ppm(struct gp_decoded *image)
{
    static struct gp_stream s;
    s = gp_stream_of(ppm, sizeof ppm - 1);
    kept_clear();
    *image = (struct gp_decoded) {0};
    return gp_oiio_open(&kept_log, "a.ppm", &s, "pnm", 0, MOST, image);
}

/* Whatever a helper does: one line about the file, nothing left, and the next
 * helper is asked as if nothing had been. */
static void helpers_that_fail(void **state)
{
    static const struct {
        const char *part;
        gp_status st;
    } row[] = {
        {"ends at its start", GP_ERR_IO}, {"says nothing", GP_ERR_DATA},
        {"ends", GP_ERR_DATA},            {"hangs", GP_ERR_DATA},
        {"stops talking", GP_ERR_DATA},   {"refuses", GP_ERR_DATA},
        {"is full", GP_ERR_BUG},          {"ends amid them", GP_ERR_DATA},
    };
    for (size_t i = 0; i < COUNT(row) + LIES; i++) {
        const size_t lie = i - COUNT(row);
        char part[32];
        struct gp_decoded image;
        snprintf(part, sizeof part, "%zu", lie);
        cast(lie < LIES ? part : row[i].part);
        const long blocks = fail_blocks();
        if (open_ppm(&image) != (lie < LIES ? GP_ERR_DATA : row[i].st))
            fail_msg("%s: %s", lie < LIES ? lies[lie].name : row[i].part,
                     kept_line);
        assert_int_equal(kept_errors, 1);
        assert_ptr_equal(strstr(kept_line, "a.ppm: "), kept_line);
        assert_null(image.own);
        assert_int_equal(fail_blocks(), blocks);
        await_end(); // the next one is started
    }
}

/* Its memory stays as large as it was, whatever the helper does to it. */
static void a_helper_that_shows(void **state)
{
    struct gp_decoded image;
    cast("shows");
    assert_ok(open_ppm(&image));
    for (int i = 0; i < W * H; i++)
        assert_true(image.pixels[i] == (float) i);
    gp_decoded_close(&image);
    for (pid_t old; (old = helper_of(getpid()));)
        kill(old, SIGKILL);
}

static void helpers_that_write_nothing(void **state)
{
    static const char *const part[] = {"ends", "hangs", "stops talking",
                                       "writes nothing", "refuses"};
    static const char *const grey[] = {"Y"};
    float v[6] = {0};
    const struct gp_decoded image = image_of(v, 3, 2, grey, 1, "");
    for (int i = 0; i < 5; i++) {
        cast(part[i]);
        assert_int_equal(write_image("none/a", "tif", &image, "half", ""),
                         GP_ERR_IO);
        assert_int_equal(kept_errors, 1);
        await_end();
    }
}

// -- the real one -------------------------------------------------------------

static void real_one(void)
{
    void *none = NULL;
    for (pid_t old; (old = helper_of(getpid()));) // an idle one may end
        kill(old, SIGKILL);
    unsetenv("MADE_UP");
    set_env("GLAREPP_BRIDGES", NULL);
    unsetenv("GLAREPP_HELPER_SECONDS");
    // one that was killed may not be seen to end at once
    for (int i = 0; i < 2000 && !helper_of(getpid()); i++) {
        usleep(1000);
        if (open_oiio(&none) || !has_oiio)
            skip_for("no OpenImageIO");
    }
}

/* It does not outlive glarepp, whatever ended that. */
static void it_ends_with_glarepp(void **state)
{
    pid_t helper = 0;
    real_one();
    const pid_t child = fork();
    if (child == 0) {
        execl("/proc/self/exe", "io", "oiio_client", "--wait", (char *) NULL);
        _exit(1);
    }
    for (int i = 0; i < 2000 && !helper; i++) {
        usleep(10000);
        helper = helper_of(child);
    }
    kill(child, SIGKILL);
    assert_int_equal(waitpid(child, NULL, 0), child);
    assert_true(helper > 0);
    int gone = -1;
    for (int i = 0; i < 2000 && gone != 0; i++) {
        usleep(10000);
        char name[64];
        snprintf(name, sizeof name, "/proc/%d/root", helper);
        gone = access(name, F_OK); // a zombie of another's has none
        gone = gone == 0;
    }
    assert_int_equal(gone, 0);
}

/* No network, few files, no core, and no descriptors of glarepp's. */
static void it_is_confined(void **state)
{
    char name[64], line[256];
    int seccomp = -1, open_files = 0;
    struct rlimit l;
    real_one();
    const pid_t helper = helper_of(getpid());
    assert_true(helper > 0);
    snprintf(name, sizeof name, "/proc/%d/status", helper);
    FILE *const f = fopen(name, "r");
    assert_non_null(f);
    while (fgets(line, sizeof line, f))
        (void) sscanf(line, "Seccomp: %d", &seccomp);
    fclose(f);
    assert_true(seccomp == 2 || seccomp == -1); // -1: a kernel without
    snprintf(name, sizeof name, "/proc/%d/fd", helper);
    DIR *const d = opendir(name);
    assert_non_null(d);
    for (struct dirent *e; (e = readdir(d));)
        open_files += e->d_name[0] != '.';
    closedir(d);
    assert_true(open_files <= 4); // stdin, stdout, stderr, and one of memory
    assert_int_equal(prlimit(helper, RLIMIT_CORE, NULL, &l), 0);
    assert_int_equal(l.rlim_max, 0);
    assert_int_equal(prlimit(helper, RLIMIT_NOFILE, NULL, &l), 0);
    assert_int_equal(l.rlim_max, 64);
    struct gp_decoded image; // and yet it reads
    assert_ok(open_ppm(&image));
    assert_int_equal(prlimit(helper, RLIMIT_DATA, NULL, &l), 0);
    assert_true(l.rlim_cur < (rlim_t) 2 << 30);
    gp_decoded_close(&image);
}

SUITE(oiio_client)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_ends_with_glarepp),
        cmocka_unit_test(it_is_confined),
    };
    const struct CMUnitTest made_up[] = {
        cmocka_unit_test(helpers_that_fail),
        cmocka_unit_test(a_helper_that_shows),
        cmocka_unit_test(helpers_that_write_nothing),
    };
    if (argc > 1 && strcmp(argv[1], "--wait") == 0) {
        real_one();
        pause();
    }
    const int failed = cmocka_run_group_tests(made_up, make_up, clean_up);
    return failed + cmocka_run_group_tests(tests, NULL, NULL);
}
