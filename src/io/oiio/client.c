// SPDX-License-Identifier: Apache-2.0
/* Starts, limits and asks the helper; see io/oiio/oiio.h and protocol.h. */
#include "io/oiio/oiio.h"

#include "core/bridge.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/oiio/protocol.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

enum {
    MOST_TEXT = 1 << 24,     // bytes of names and attributes
    MOST_CHANNELS = 8192,
    MOST_EDGE = 1 << 29,     // of windows: sums of two fit an int
    SECONDS = 60,
    WHY_BYTES = 512,
};

/* The helper; a frame waits until that of another is read or written. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct {
    pid_t pid;               // 0: none runs
    bool killed;             // by a signal or the time limit
    int socket;
    unsigned seconds;        // for the call that it works on
    bool starved;            // memory was full when it answered
    char cause[WHY_BYTES];   // why it ended
} helper;

// -- start and end ------------------------------------------------------------

/* Ends the helper and keeps the reason; `why` NULL: it ended by itself. */
static void end_helper(const char *why)
{
    char *const cause = helper.cause;
    int status = 0;
    kill(helper.pid, SIGKILL); // one that has ended keeps its status
    (void) waitpid(helper.pid, &status, 0);
    helper.killed = !why && WIFSIGNALED(status);
    if (why)
        snprintf(cause, WHY_BYTES, "%s", why);
    else if (helper.killed)
        snprintf(cause, WHY_BYTES, "was killed by signal %d, %s",
                 WTERMSIG(status), strsignal(WTERMSIG(status)));
    else
        snprintf(cause, WHY_BYTES, "exited with status %d",
                 WEXITSTATUS(status));
    close(helper.socket);
    helper.pid = 0;
}

/* Reads `n` bytes of an answer; a helper that gives none, or too late, ends. */
static bool receive(void *to, size_t n)
{
    char late[64];
    const ssize_t got = n ? recv(helper.socket, to, n, MSG_WAITALL) : 0;
    if (got == (ssize_t) n)
        return true;
    snprintf(late, sizeof late, "took more than %u s", helper.seconds);
    const bool is_late = got < 0 && errno == EAGAIN;
    end_helper(is_late ? late : NULL);
    helper.killed = helper.killed || is_late;
    return false;
}

/* The next reply, and its text with a '\0'; free *text. */
static bool receive_reply(struct gp_oiio_reply *reply, char **text)
{
    const struct timeval most = {.tv_sec = helper.seconds};
    *text = NULL;
    (void) setsockopt(helper.socket, SOL_SOCKET, SO_RCVTIMEO, &most,
                      sizeof most);
    if (!receive(reply, sizeof *reply))
        return false;
    if (reply->protocol != GP_OIIO_PROTOCOL || reply->bytes > MOST_TEXT) {
        end_helper("has another version");
        return false;
    }
    helper.starved = gp_alloc(NULL, "text", reply->bytes + 1, 1, text);
    if (helper.starved) {
        end_helper("sent more than memory can hold");
        return false;
    }
    (*text)[reply->bytes] = '\0';
    if (receive(*text, reply->bytes))
        return true;
    GP_FREE(*text);
    return false;
}

/* Seconds for a call on so many bytes. */
static unsigned seconds_for(uint64_t bytes)
{
    const char *const given = getenv("GLAREPP_HELPER_SECONDS");
    char *end = NULL;
    const long base = given ? strtol(given, &end, 10) : 0;
    const bool is_number = base > 0 && base < 1000000 && !*end;
    return (unsigned) (is_number ? base : SECONDS) +
           (unsigned) (bytes >> 20 < 1000000 ? bytes >> 20 : 1000000);
}

/* Starts the program with `socket` as its stdin; an errno. */
static int spawn(const char *program, int socket, pid_t *pid)
{
    static char name[] = "glarepp-oiio";
    char *const argv[] = {name, NULL};
    posix_spawn_file_actions_t files;
    posix_spawnattr_t how;
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawn_file_actions_init(&files); // Linux: neither of both fails
    posix_spawnattr_init(&how);
    // signals as in a fresh process; and Ctrl-C is for glarepp, whose end is the
    // helper's
    posix_spawnattr_setflags(&how, POSIX_SPAWN_SETSIGMASK |
                                       POSIX_SPAWN_SETSIGDEF |
                                       POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setsigmask(&how, &none);
    posix_spawnattr_setsigdefault(&how, &all);
    const bool full =
        posix_spawn_file_actions_adddup2(&files, socket, 0) ||
        posix_spawn_file_actions_addopen(&files, 1, "/dev/null", O_WRONLY, 0) ||
        posix_spawn_file_actions_adddup2(&files, 1, 2);
    const int error =
        full ? ENOMEM : posix_spawn(pid, program, &files, &how, argv, environ);
    posix_spawnattr_destroy(&how);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

/* False: its cause says why none runs. */
static bool start_helper(void)
{
    char program[PATH_MAX];
    struct gp_oiio_reply hello;
    char *text = NULL;
    int pair[2], error;
    helper.killed = false;
    if (!gp_bridge_find("glarepp-oiio", program, sizeof program)) {
        snprintf(helper.cause, sizeof helper.cause, "glarepp-oiio not found");
        return false;
    }
    error = socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair)
                ? errno : 0;
    if (!error) {
        error = spawn(program, pair[1], &helper.pid);
        close(pair[1]);
        if (error)
            close(pair[0]);
    }
    if (error) {
        helper.pid = 0;
        snprintf(helper.cause, sizeof helper.cause, "%.300s: %s", program,
                 strerror(error));
        return false;
    }
    helper.socket = pair[0];
    helper.seconds = seconds_for(0);
    if (receive_reply(&hello, &text)) {
        gp_free(text);
        return true;
    }
    if (helper.killed)
        return false;
    char cause[WHY_BYTES];
    snprintf(cause, sizeof cause, "%.300s %.150s", program, helper.cause);
    memcpy(helper.cause, cause, sizeof cause);
    return false;
}

/* Prints the line for a call that failed; `reply` NULL: the helper ended. */
static gp_status call_failed(const struct gp_log *log, const char *path,
    bool writes, const struct gp_oiio_reply *reply, const char *text)
{
    const gp_status st = writes ? GP_ERR_IO : GP_ERR_DATA;
    const char *const what = writes ? "cannot be written"
                                    : "cannot be read";
    const char *const hint = writes ? "write .exr or .png"
                                    : "give an EXR or convert it";
    if (reply ? reply->end == GP_OIIO_MEMORY : helper.starved)
        return gp_no_memory(log, path);
    if (!reply)
        return gp_fail(log, st, "%s: %s (glarepp-oiio %s); %s", path, what,
                       helper.cause, hint);
    return gp_fail(log, st, "%s: %s (%s); %s", path, what,
                   text[0] ? text : "truncated or damaged", hint);
}

/* Takes the helper, which is started where none runs; unlock it. */
static gp_status take_helper(const struct gp_log *log, const char *path,
                             bool writes)
{
    pthread_mutex_lock(&lock);
    helper.starved = false;
    // an idle one sends nothing: readable means that it ended
    struct pollfd idle = {.fd = helper.socket, .events = POLLIN};
    if (helper.pid && poll(&idle, 1, 0) > 0)
        end_helper(NULL);
    if (helper.pid || start_helper())
        return GP_OK;
    const gp_status st =
        helper.starved ? gp_no_memory(log, path) :
        helper.killed ? call_failed(log, path, writes, NULL, "") :
        gp_fail(log, GP_ERR_IO, "%s: this format needs the program "
            "glarepp-oiio (%s); install it, or use EXR or PNG", path,
            helper.cause);
    pthread_mutex_unlock(&lock);
    return st;
}

gp_status gp_oiio_check(const struct gp_log *log, const char *path)
{
    const gp_status st = take_helper(log, path, true);
    if (!st)
        pthread_mutex_unlock(&lock);
    return st;
}

// -- calls --------------------------------------------------------------------

/* Sends a call, its text, and up to two descriptors; -1 for none. */
static bool send_ask(struct gp_oiio_ask *ask, const char *text,
                     const int fd[2])
{
    _Alignas(struct cmsghdr) char control[CMSG_SPACE(2 * sizeof(int))] = {0};
    struct iovec data = {ask, sizeof *ask};
    struct msghdr m = {.msg_iov = &data, .msg_iovlen = 1};
    const size_t fds = (fd[0] >= 0) + (size_t) (fd[1] >= 0);
    ask->protocol = GP_OIIO_PROTOCOL;
    ask->threads = gp_threads();
    if (fds > 0) {
        m.msg_control = control;
        m.msg_controllen = CMSG_SPACE(fds * sizeof *fd);
        struct cmsghdr *const c = CMSG_FIRSTHDR(&m);
        c->cmsg_level = SOL_SOCKET;
        c->cmsg_type = SCM_RIGHTS;
        c->cmsg_len = CMSG_LEN(fds * sizeof *fd);
        memcpy(CMSG_DATA(c), fd, fds * sizeof *fd);
    }
    if (sendmsg(helper.socket, &m, MSG_NOSIGNAL) == (ssize_t) sizeof *ask &&
        (!ask->bytes || send(helper.socket, text, ask->bytes, MSG_NOSIGNAL) ==
                            (ssize_t) ask->bytes))
        return true;
    end_helper(NULL);
    return false;
}

/* Makes a call and waits for its reply; gp_free() its text in any case. */
static gp_status call(const struct gp_log *log, const char *path,
    struct gp_oiio_ask *ask, const char *text, const int fd[2],
    struct gp_oiio_reply *reply, char **answer)
{
    const bool writes = ask->call == GP_OIIO_WRITE;
    if (!send_ask(ask, text, fd) || !receive_reply(reply, answer))
        return call_failed(log, path, writes, NULL, "");
    return reply->end ? call_failed(log, path, writes, reply, *answer)
                      : GP_OK;
}

// -- reading ------------------------------------------------------------------

/* The memory that a gp_decoded points into. */
struct input {
    struct gp_shared pixels;
    float chromaticities[8];
    char *text;
    const char **names;
    struct gp_attribute *attributes;
};

/* The string at *at, which moves after it; NULL: it does not end. */
static const char *next_text(const char **at, const char *end)
{
    const char *const text = *at;
    const char *const zero =
        text < end ? memchr(text, '\0', (size_t) (end - text)) : NULL;
    *at = zero ? zero + 1 : end;
    return zero ? text : NULL;
}

static bool next_attribute(const char **at, const char *end,
                           struct gp_attribute *a)
{
    const char kind = *at < end ? *(*at)++ : '\0';
    const char *const name = next_text(at, end);
    *a = (struct gp_attribute) {.name = (char *) (uintptr_t) name};
    a->kind = kind == 's'   ? GP_ATTRIBUTE_TEXT
              : kind == 'i' ? GP_ATTRIBUTE_INT : GP_ATTRIBUTE_FLOAT;
    if (!name || kind == 's')
        return name && (a->text = (char *) (uintptr_t) next_text(at, end));
    if (end - *at < 4)
        return false;
    memcpy(kind == 'i' ? (void *) &a->number : (void *) &a->real, *at, 4);
    *at += 4;
    return kind == 'i' || kind == 'f';
}

/* Makes the image that a reply describes, which points into in->text.
 * GP_ERR_DATA without a line: the reply is invalid. */
static gp_status make_image(const struct gp_log *log,
    const struct gp_oiio_reply *reply, long long max_pixels, struct input *in,
    struct gp_decoded *image)
{
    gp_status st;
    const struct gp_oiio_spec *const s = &reply->spec;
    const char *at = in->text, *const end = at + reply->bytes;
    const int32_t edge[] = {s->x, s->y, s->w, s->h, s->full_x, s->full_y,
                            s->full_w, s->full_h};
    for (size_t i = 0; i < sizeof edge / sizeof *edge; i++) {
        if (edge[i] <= -MOST_EDGE || edge[i] >= MOST_EDGE)
            return GP_ERR_DATA;
    }
    if (s->w <= 0 || s->h <= 0 || (long long) s->w * s->h > max_pixels ||
        s->channels <= 0 || s->channels > MOST_CHANNELS ||
        s->attributes < 0 || s->attributes > MOST_TEXT || s->parts < 1 ||
        s->parts > GP_OIIO_PARTS)
        return GP_ERR_DATA;
    GP_TRY(gp_alloc(log, "channel names", (size_t) s->channels,
                    sizeof *in->names, &in->names));
    GP_TRY(gp_alloc(log, "attributes", (size_t) s->attributes + 1,
                    sizeof *in->attributes, &in->attributes));
    const char **const name = in->names;
    struct gp_attribute *const attribute = in->attributes;
    bool whole = true;
    for (int i = 0; i < s->channels; i++)
        whole = (name[i] = next_text(&at, end)) && whole;
    image->colour_space = next_text(&at, end);
    for (int i = 0; i < s->attributes && whole; i++) {
        whole = next_attribute(&at, end, &attribute[i]);
        if (whole && attribute[i].kind == GP_ATTRIBUTE_FLOAT &&
            strcmp(attribute[i].name, "PixelAspectRatio") == 0)
            image->pixel_aspect = attribute[i].real;
    }
    if (!whole || !image->colour_space)
        return GP_ERR_DATA;
    image->data = (struct gp_rect) {s->x, s->y, s->x + s->w, s->y + s->h};
    image->display = (struct gp_rect) {s->full_x, s->full_y,
                                       s->full_x + s->full_w,
                                       s->full_y + s->full_h};
    if (s->has_chromaticities)
        image->chromaticities = memcpy(in->chromaticities, s->chromaticities,
                                       sizeof s->chromaticities);
    image->parts = s->parts;
    image->channels = s->channels;
    image->channel_name = name;
    image->half = s->half;
    image->bits = s->bits;
    image->attribute = attribute;
    image->attributes = s->attributes;
out:
    return st;
}

static void close_image(struct gp_decoded *image)
{
    struct input *const in = image->own;
    gp_shared_free(&in->pixels);
    gp_free(in->text);
    gp_free(in->names);
    gp_free(in->attributes);
    gp_free(in);
}

/* Reads header and pixels from the file `fd`. */
static gp_status read_by(const struct gp_log *log, struct gp_oiio_ask *ask,
                         int fd, struct gp_decoded *image)
{
    struct input *const in = image->own;
    struct gp_oiio_reply reply;
    char *text = NULL;
    helper.seconds = seconds_for(ask->size);
    gp_status st = call(log, image->path, ask, NULL, (int[]) {fd, -1},
                        &reply, &in->text);
    if (st)
        return st;
    st = make_image(log, &reply, ask->max_pixels, in, image);
    if (st == GP_ERR_DATA) {
        end_helper("sent an invalid header");
        return call_failed(log, image->path, false, NULL, "");
    }
    const size_t bytes =
        gp_rect_pixels(image->data) * (size_t) image->channels * sizeof(float);
    if (!st)
        st = gp_shared_make(log, image->path, bytes, &in->pixels);
    if (st)
        return st;
    image->pixels = in->pixels.at;
    helper.seconds = seconds_for(ask->size + bytes);
    *ask = (struct gp_oiio_ask) {.call = GP_OIIO_PIXELS, .size = bytes};
    st = call(log, image->path, ask, NULL, (int[]) {in->pixels.fd, -1},
              &reply, &text);
    gp_free(text);
    return st;
}

gp_status gp_oiio_open(const struct gp_log *log, const char *path,
                       const struct gp_stream *stream, const char *reader,
                       int part, long long max_pixels, struct gp_decoded *out)
{
    struct input *in;
    struct gp_shared copy = {0};
    struct gp_oiio_ask ask = {
        .call = GP_OIIO_OPEN, .part = part, .size = stream->size,
        .max_pixels = max_pixels,
    };
    snprintf(ask.format, sizeof ask.format, "%s", reader);
    gp_status st = gp_alloc_zero(log, path, 1, sizeof *in, &in);
    if (st)
        return st;
    struct gp_decoded image = {.path = path, .close = close_image, .own = in};
    if (stream->data) {
        GP_TRY(gp_shared_make(log, path, stream->size, &copy));
        memcpy(copy.at, stream->data, stream->size);
    }
    GP_TRY(take_helper(log, path, false));
    st = read_by(log, &ask, stream->data ? copy.fd : stream->fd, &image);
    pthread_mutex_unlock(&lock);
out:
    gp_shared_free(&copy);
    if (st)
        gp_decoded_close(&image);
    else
        *out = image;
    return st;
}

// -- writing ------------------------------------------------------------------

gp_status gp_oiio_write(const struct gp_log *log,
    const struct gp_decoded *image, const int *types,
    const struct gp_shared *pixels, const char *ending, const char *type,
    const char *compression, struct gp_stream *out)
{
    gp_status st;
    const char *const path = image->path;
    const struct gp_rect data = image->data, display = image->display;
    struct gp_oiio_reply reply;
    struct gp_oiio_ask ask = {
        .call = GP_OIIO_WRITE, .size = pixels->size,
        .spec = {
            .x = data.x0, .y = data.y0, .w = gp_rect_w(data),
            .h = gp_rect_h(data), .full_x = display.x0, .full_y = display.y0,
            .full_w = gp_rect_w(display), .full_h = gp_rect_h(display),
            .channels = image->channels, .typed = types != NULL,
            .has_chromaticities = image->chromaticities != NULL,
        },
    };
    bool taken = false;
    char *text = NULL, *why = NULL;
    size_t room = strlen(image->colour_space) + 1 + (size_t) image->channels;
    if (image->chromaticities)
        memcpy(ask.spec.chromaticities, image->chromaticities,
               sizeof ask.spec.chromaticities);
    snprintf(ask.format, sizeof ask.format, "%s", ending);
    snprintf(ask.type, sizeof ask.type, "%s", type);
    snprintf(ask.compression, sizeof ask.compression, "%s", compression);
    *out = (struct gp_stream) GP_STREAM_EMPTY;
    for (int i = 0; i < image->channels; i++)
        room += strlen(image->channel_name[i]) + 1;
    GP_TRY(gp_alloc(log, "channel names", room, 1, &text));
    char *to = text; // as gp_oiio_spec has it
    for (int i = 0; i < image->channels; i++)
        to = stpcpy(to, image->channel_name[i]) + 1;
    to = stpcpy(to, image->colour_space) + 1;
    for (int i = 0; i < image->channels && types; i++)
        *to++ = (char) types[i];
    ask.bytes = (uint32_t) (to - text);
    out->fd = memfd_create("glarepp", MFD_CLOEXEC);
    if (out->fd < 0)
        GP_TRY(gp_fail(log, GP_ERR_IO, "%s: cannot make a file in memory "
                       "(%s); write .exr or .png", path, strerror(errno)));
    GP_TRY(take_helper(log, path, true));
    taken = true;
    helper.seconds = seconds_for(pixels->size);
    GP_TRY(call(log, path, &ask, text, (int[]) {out->fd, pixels->fd},
                &reply, &why));
    out->more = true; // from its start: the helper opened it anew
    GP_TRY(gp_stream_fill(log, path, INT64_MAX, out));
    if (!out->size)
        GP_TRY(gp_fail(log, GP_ERR_IO,
                       "%s: OpenImageIO wrote no bytes; write "
                       "another format",
                       path));
out:
    if (taken)
        pthread_mutex_unlock(&lock);
    gp_free(why);
    gp_free(text);
    if (st)
        gp_stream_close(out);
    return st;
}
