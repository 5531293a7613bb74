// glarepp-oiio: reads and writes with OpenImageIO for glarepp, which starts it
// with a socket as stdin. A damaged file that crashes its reader ends this
// process only. See io/oiio/protocol.h.
#include "io/oiio/protocol.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {

const int SOCKET = 0;

// -- limits of the process ----------------------------------------------------

// No network and no other program, for all threads; a kernel that has no
// filters goes on without. OpenImageIO's movie reader would open addresses.
void close_network()
{
#if defined __x86_64__
    const unsigned arch = AUDIT_ARCH_X86_64;
#elif defined __aarch64__
    const unsigned arch = AUDIT_ARCH_AARCH64;
#else
    const unsigned arch = 0;
#endif
    static const unsigned denied[] = {
        SYS_socket, SYS_connect, SYS_bind, SYS_execve, SYS_execveat,
        SYS_ptrace, SYS_kill,
#ifdef SYS_io_uring_setup
        SYS_io_uring_setup,
#endif
    };
    const std::size_t n = sizeof denied / sizeof *denied;
    const unsigned refuse = SECCOMP_RET_ERRNO | EPERM;
    const unsigned x32 = 0x40000000; // x86-64's other numbers
    sock_filter code[n + 8];
    std::size_t at = 0;
    code[at++] = BPF_STMT(BPF_LD | BPF_W | BPF_ABS,
                          offsetof(struct seccomp_data, arch));
    code[at++] = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, arch, 1, 0);
    code[at++] = BPF_STMT(BPF_RET | BPF_K, refuse);
    code[at++] = BPF_STMT(BPF_LD | BPF_W | BPF_ABS,
                          offsetof(struct seccomp_data, nr));
    code[at++] = BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, x32,
                          static_cast<unsigned char>(n + 1), 0);
    for (std::size_t i = 0; i < n; i++)
        code[at++] = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, denied[i],
                              static_cast<unsigned char>(n - i), 0);
    code[at++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    code[at++] = BPF_STMT(BPF_RET | BPF_K, refuse);
    const sock_fprog program = {static_cast<unsigned short>(at), code};
    if (arch != 0 && prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0)
        (void) syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER,
                       SECCOMP_FILTER_FLAG_TSYNC, &program);
}

rlim_t soft_limit(int what)
{
    struct rlimit l;
    return getrlimit(static_cast<__rlimit_resource_t>(what), &l)
               ? RLIM_INFINITY : l.rlim_cur;
}

// Lowers the soft limit, and the hard one too where `hard`; raises none that
// is there.
void limit(int what, rlim_t most, bool hard)
{
    struct rlimit l;
    if (getrlimit(static_cast<__rlimit_resource_t>(what), &l))
        return;
    if (l.rlim_max != RLIM_INFINITY && most > l.rlim_max)
        most = l.rlim_max;
    l.rlim_cur = most;
    if (hard)
        l.rlim_max = most;
    (void) setrlimit(static_cast<__rlimit_resource_t>(what), &l);
}

// The limits of glarepp itself: memory, and bytes of a file.
constexpr rlim_t gigabyte = rlim_t(1) << 30;
rlim_t inherited_data, inherited_space, inherited_file;
rlim_t most_memory = gigabyte; // of the file that is open

// Ends this process with glarepp, also while a decoder hangs.
void end_with_client()
{
    struct pollfd p = {SOCKET, POLLRDHUP, 0};
    while (poll(&p, 1, -1) < 0 && errno == EINTR)
        ;
    _exit(0);
}

// -- the socket ---------------------------------------------------------------

// The next call and the descriptors that came with it, -1 for none.
bool receive_ask(gp_oiio_ask &ask, int fd[2], std::string &text)
{
    alignas(struct cmsghdr) char control[CMSG_SPACE(2 * sizeof(int))];
    struct iovec data = {&ask, sizeof ask};
    struct msghdr m = {};
    m.msg_iov = &data;
    m.msg_iovlen = 1;
    m.msg_control = control;
    m.msg_controllen = sizeof control;
    fd[0] = fd[1] = -1;
    if (recvmsg(SOCKET, &m, MSG_CMSG_CLOEXEC | MSG_WAITALL) !=
        static_cast<ssize_t>(sizeof ask))
        return false;
    const struct cmsghdr *const c = CMSG_FIRSTHDR(&m);
    if (c && c->cmsg_type == SCM_RIGHTS)
        std::memcpy(fd, CMSG_DATA(c), std::min(c->cmsg_len - CMSG_LEN(0),
                                               2 * sizeof(int)));
    text.resize(ask.bytes);
    return text.empty() || recv(SOCKET, &text[0], text.size(), MSG_WAITALL) ==
                               static_cast<ssize_t>(text.size());
}

bool send_all(const void *from, std::size_t n)
{
    return send(SOCKET, from, n, MSG_NOSIGNAL) == static_cast<ssize_t>(n);
}

// -- calls --------------------------------------------------------------------

// Memory that glarepp shares.
class Shared {
public:
    Shared(int fd, std::size_t size)
        : size_(size),
          at_(mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0))
    {
        if (at_ == MAP_FAILED)
            throw std::bad_alloc();
    }
    ~Shared() { munmap(at_, size_); }
    float *samples() const { return static_cast<float *>(at_); }

private:
    const std::size_t size_;
    void *const at_;
};

void answer(const gp_oiio_ask &ask, int fd[2], gp_oiio_reply &reply,
            std::string &text)
{
    if (ask.protocol != GP_OIIO_PROTOCOL)
        throw std::runtime_error("glarepp-oiio has another version");
    // never fewer threads than before: OpenImageIO's pool keeps the stacks of
    // those that it ends, which count against the limit of memory
    static int threads = 0;
    if (ask.threads > threads) {
        threads = ask.threads;
        OIIO::attribute("threads", threads);
        OIIO::attribute("exr_threads", threads);
    }
    limit(RLIMIT_FSIZE, ask.call == GP_OIIO_WRITE ? inherited_file : 0, false);
    switch (ask.call) {
    case GP_OIIO_OPEN: {
        const int file = fd[0];
        fd[0] = -1;
        helper::open_file(file, ask, reply.spec, text);
        break;
    }
    case GP_OIIO_PIXELS:
        helper::read_pixels(Shared(fd[0], ask.size).samples());
        text.clear();
        break;
    case GP_OIIO_WRITE:
        helper::write_file(fd[0], ask, text,
                           Shared(fd[1], ask.size).samples());
        text.clear();
        break;
    }
}

// Keeps the first line, as libraries repeat it for each row. Plugins catch
// exceptions and keep only their text. bad_alloc means full memory where
// glarepp's own limits are lower than the helper's (libraries map a gigabyte);
// else the file needs more than its size explains.
void explain(const std::string &why, gp_oiio_reply &reply, std::string &text)
{
    static const char *const memory[] = {
        "bad_alloc", "bad alloc", "ut of memory", "nsufficient memory",
    };
    const bool limited = inherited_data < most_memory ||
                         inherited_space < most_memory + gigabyte;
    reply.end = GP_OIIO_REFUSED;
    text = why.substr(0, std::min<std::size_t>(why.find('\n'), 200));
    for (const char *word : memory) {
        if (why.find(word) == std::string::npos)
            continue;
        text = "needs more memory than its size explains";
        if (limited)
            reply.end = GP_OIIO_MEMORY;
    }
    for (char &c : text) {
        if (c == '\r' || c == '\0')
            c = ' ';
    }
    helper::close_file();
}

} // namespace

void helper::limit_memory(std::uint64_t bytes)
{
    most_memory = gigabyte + bytes;
    limit(RLIMIT_DATA, std::min(most_memory, inherited_data), false);
}

int main()
{
    inherited_data = soft_limit(RLIMIT_DATA);
    inherited_space = soft_limit(RLIMIT_AS);
    inherited_file = soft_limit(RLIMIT_FSIZE);
    limit(RLIMIT_CORE, 0, true);
    limit(RLIMIT_NOFILE, 64, true);
    (void) close_range(3, ~0U, 0);
    close_network();
    std::thread(end_with_client).detach();
    gp_oiio_ask ask;
    gp_oiio_reply reply = {};
    std::string text;
    int fd[2];
    reply.protocol = GP_OIIO_PROTOCOL;
    if (!send_all(&reply, sizeof reply)) // it runs
        return 0;
    while (receive_ask(ask, fd, text)) {
        reply = {};
        reply.protocol = GP_OIIO_PROTOCOL;
        try {
            answer(ask, fd, reply, text);
        } catch (const std::exception &e) {
            explain(e.what(), reply, text);
        } catch (...) {
            explain("OpenImageIO failed", reply, text);
        }
        for (int i = 0; i < 2; i++) {
            if (fd[i] >= 0)
                close(fd[i]);
        }
        reply.bytes = static_cast<std::uint32_t>(text.size());
        if (!send_all(&reply, sizeof reply) ||
            !send_all(text.data(), text.size()))
            break;
    }
    _exit(0); // OpenImageIO's threads have nothing left to say
}
