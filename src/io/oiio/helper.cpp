// SPDX-License-Identifier: Apache-2.0
// glarepp-oiio: reads and writes with OpenImageIO for glarepp, which starts it
// with a socket as stdin. A damaged file that crashes its reader ends this
// process only. See io/oiio/protocol.h.
#include "io/oiio/protocol.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <iterator>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

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

using OIIO::ImageInput;
using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

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

void limit_memory(std::uint64_t bytes)
{
    most_memory = gigabyte + bytes;
    limit(RLIMIT_DATA, std::min(most_memory, inherited_data), false);
}

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

// -- the bytes of a file ------------------------------------------------------

// A descriptor as OpenImageIO's file, without a name. Records reads beyond its
// end: libjpeg inside a TIFF fills those with grey.
class Bytes : public OIIO::Filesystem::IOProxy {
public:
    Bytes(int fd, std::size_t size)
        : IOProxy("image", Read), fd_(fd), size_(size)
    {
    }
    ~Bytes() override { ::close(fd_); }
    const char *proxytype() const override { return "glarepp"; }
    std::size_t size() const override { return size_; }
    std::size_t read(void *to, std::size_t n) override
    {
        const std::size_t got = pread(to, n, m_pos);
        m_pos += static_cast<int64_t>(got);
        return got;
    }
    std::size_t pread(void *to, std::size_t n, int64_t at) override
    {
        const std::size_t from = at < 0 ? size_ : static_cast<std::size_t>(at);
        const std::size_t most = from < size_ ? size_ - from : 0;
        std::size_t done = 0;
        while (done < std::min(n, most)) {
            const ssize_t got = ::pread(fd_, static_cast<char *>(to) + done,
                std::min(n, most) - done, static_cast<off_t>(from + done));
            if (got <= 0)
                break;
            done += static_cast<std::size_t>(got);
        }
        if (done < n)
            short_ = true;
        return done;
    }
    bool was_short() const { return short_; }
    void forget_short() { short_ = false; }
    int fd() const { return fd_; }

private:
    const int fd_;
    const std::size_t size_;
    std::atomic<bool> short_{false}; // threads decode
};

// The open file. Members are destroyed from the last: the reader first.
struct File {
    std::unique_ptr<Bytes> bytes;
    std::vector<unsigned char> copy;  // JPEG's reader wants all in memory
    std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;
    std::unique_ptr<ImageInput> input;
    ImageSpec spec;
    int part = 0;
};
std::unique_ptr<File> file; // that is open

// The readers that are asked, by OpenImageIO's names. create() looks for other
// names among its plug-ins, and lets each look at the file.
bool is_allowed(const std::string &format)
{
    static const char *const names[] = {
        "openexr", "tiff", "jpeg", "hdr", "dpx", "targa", "bmp", "pnm", "sgi",
        "webp",
    };
    return std::find(std::begin(names), std::end(names), format) !=
           std::end(names);
}

// The reader of DPX takes memory for the user's data that the header names:
// bytes 32 to 35, all bits set for none (SMPTE 268M, section 4).
void check_dpx(Bytes &bytes)
{
    unsigned char head[36] = {0};
    if (bytes.pread(head, sizeof head, 0) != sizeof head)
        throw std::runtime_error("truncated in its header");
    const bool big = head[0] == 'S';
    std::uint32_t user = 0;
    for (int i = 0; i < 4; i++)
        user = user << 8 | head[32 + (big ? i : 3 - i)];
    if (user != UINT32_MAX && user > bytes.size())
        throw std::runtime_error("truncated in its user data");
}

std::unique_ptr<File> open_bytes(int fd, const gp_oiio_ask &ask)
{
    const std::string format = ask.format;
    auto f = std::make_unique<File>();
    f->bytes = std::make_unique<Bytes>(fd, ask.size);
    if (!is_allowed(format))
        throw std::runtime_error("not a format that glarepp-oiio reads: " +
                                 format);
    if (format == "dpx")
        check_dpx(*f->bytes);
    f->input = ImageInput::create(format);
    if (!f->input)
        throw std::runtime_error(OIIO::geterror());
    ImageSpec with;
    std::string name = "image";
    OIIO::Filesystem::IOProxy *proxy = f->bytes.get();
    if (format == "jpeg") {
        f->copy.resize(ask.size);
        if (f->bytes->pread(f->copy.data(), f->copy.size(), 0) != ask.size)
            throw std::runtime_error("truncated");
        f->memory = std::make_unique<OIIO::Filesystem::IOMemReader>(
            f->copy.data(), f->copy.size());
        proxy = f->memory.get();
    }
    if (f->input->supports("ioproxy"))
        with.attribute("oiio:ioproxy", TypeDesc::PTR, &proxy);
    else // SGI, whose reader looks at what it gets
        name = "/proc/self/fd/" + std::to_string(fd);
    if (!f->input->open(name, f->spec, with))
        throw std::runtime_error(f->input->geterror());
    if (format == "hdr") // looks for ends of lines in blocks of the file
        f->bytes->forget_short();
    return f;
}

// -- checks before memory is taken --------------------------------------------

std::string size_text(const ImageSpec &spec)
{
    return std::to_string(spec.width) + " x " + std::to_string(spec.height) +
           " pixels";
}

void check_size(const ImageSpec &spec, const gp_oiio_ask &ask)
{
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1)
        throw std::runtime_error("no pixels");
    if (spec.depth > 1 || spec.tile_depth > 1)
        throw std::runtime_error("a volume, not a picture");
    if (spec.deep)
        throw std::runtime_error("deep data");
    const long long pixels = static_cast<long long>(spec.width) * spec.height;
    if (pixels > ask.max_pixels)
        throw std::runtime_error("too large: " + size_text(spec) +
                                 ", at most " +
                                 std::to_string(ask.max_pixels));
    const bool exr = std::strcmp(ask.format, "openexr") == 0;
    if (!exr && (spec.nchannels + 3LL) / 4 > ask.max_pixels / pixels)
        throw std::runtime_error(
            "too large: " + size_text(spec) + " of " +
            std::to_string(spec.nchannels) +
            " channels, each four of which count as pixels; at most " +
            std::to_string(ask.max_pixels));
    // a reader takes memory for whole tiles
    const long long tile = static_cast<long long>(spec.tile_width) *
                           std::max(1, spec.tile_height);
    if (tile > std::max(4 * pixels, 1LL << 20))
        throw std::runtime_error("tiles larger than the picture");
    // DPX's reader goes on after the end; its runs have 32767 pixels in 4 bytes
    if (std::strcmp(ask.format, "dpx") == 0 &&
        static_cast<std::uint64_t>(pixels / 8192) > ask.size)
        throw std::runtime_error(std::to_string(ask.size) +
                                 " bytes cannot hold " + size_text(spec));
    // 2.4 leaves parts of them as its memory was
    if (tile > 0 && spec.format == TypeDesc::DOUBLE &&
        std::strcmp(ask.format, "tiff") == 0 &&
        spec.get_string_attribute("planarconfig") != "separate")
        throw std::runtime_error("tiles of 64-bit floats, which OpenImageIO "
                                 "reads wrong");
}

// -- pixels -------------------------------------------------------------------

// All pixels of channels [c0, c1). Readers may report an error and go on, with
// black pixels.
void read_channels(int c0, int c1, const TypeDesc &type, void *to)
{
    ImageInput &input = *file->input;
    if (!input.read_image(file->part, 0, c0, c1, type, to) || input.has_error())
        throw std::runtime_error(input.geterror());
    if (file->bytes->was_short())
        throw std::runtime_error("truncated");
}

// -- the header ---------------------------------------------------------------

void add_text(std::string &to, const std::string &s)
{
    to.append(s.c_str()); // none of them holds a '\0'
    to.push_back('\0');
}

void describe(ImageSpec &spec, gp_oiio_spec &out, std::string &text)
{
    text.clear();
    if (spec.channelnames.size() != static_cast<std::size_t>(spec.nchannels))
        spec.default_channel_names(); // readers may leave them out
    for (const std::string &name : spec.channelnames)
        add_text(text, name);
    add_text(text, spec.get_string_attribute("oiio:ColorSpace"));
    int attributes = 0;
    for (const OIIO::ParamValue &p : spec.extra_attribs) {
        const bool string = p.type() == TypeDesc::STRING;
        const bool whole = p.type() == TypeDesc::INT;
        if (!string && !whole && p.type() != TypeDesc::FLOAT)
            continue; // no other type goes into every format
        attributes++;
        text.push_back(string ? 's' : whole ? 'i' : 'f');
        add_text(text, p.name().string());
        if (string)
            add_text(text, p.get_string());
        else
            text.append(static_cast<const char *>(p.data()), 4);
    }
    const OIIO::ParamValue *c = spec.find_attribute(
        "chromaticities", TypeDesc(TypeDesc::FLOAT, 8));
    const int bits = spec.format.is_floating_point()
                         ? 0 : static_cast<int>(8 * spec.format.size());
    out = {spec.x, spec.y, spec.width, spec.height, spec.full_x, spec.full_y,
           spec.full_width, spec.full_height, spec.nchannels,
           spec.format == TypeDesc::HALF, bits, attributes, 0, 1,
           c != nullptr, {}};
    if (c)
        std::memcpy(out.chromaticities, c->data(), sizeof out.chromaticities);
}

void open_file(int fd, const gp_oiio_ask &ask, gp_oiio_spec &spec,
                       std::string &text)
{
    file.reset();
    limit_memory(4 * ask.size);
    std::unique_ptr<File> f = open_bytes(fd, ask);
    int parts = 1;
    if (std::strcmp(ask.format, "tiff") == 0 && ask.part == 0) {
        while (parts < GP_OIIO_PARTS && f->input->seek_subimage(parts, 0))
            parts++;
        f->input->geterror(); // there is no more, which is none
    }
    if (!f->input->seek_subimage(ask.part, 0))
        throw std::runtime_error("has no part " + std::to_string(ask.part));
    f->spec = f->input->spec();
    f->part = ask.part;
    check_size(f->spec, ask);
    describe(f->spec, spec, text);
    spec.parts = parts;
    limit_memory(4 * ask.size + 16 * f->spec.image_pixels() *
                                    static_cast<unsigned>(f->spec.nchannels));
    file = std::move(f);
}

void read_pixels(float *to)
{
    const std::size_t n = static_cast<std::size_t>(file->spec.nchannels);
    read_channels(0, file->spec.nchannels, TypeDesc::FLOAT, to);
    // EXR's uint32 channels, whose values floats cannot hold, bit by bit
    const bool exr = std::strcmp(file->input->format_name(), "openexr") == 0;
    for (std::size_t c = 0; exr && c < n; c++) {
        const int channel = static_cast<int>(c);
        if (file->spec.channelformat(channel) != TypeDesc::UINT32)
            continue;
        std::vector<unsigned> bits(file->spec.image_pixels());
        read_channels(channel, channel + 1, TypeDesc::UINT32, bits.data());
        for (std::size_t i = 0; i < bits.size(); i++)
            std::memcpy(to + i * n + c, &bits[i], sizeof bits[i]);
    }
    file.reset();
}

// -- writing ------------------------------------------------------------------

ImageSpec make_spec(const gp_oiio_ask &ask, const std::string &text)
{
    const gp_oiio_spec &s = ask.spec;
    const char *at = text.c_str();
    ImageSpec spec(s.w, s.h, s.channels, TypeDesc(ask.type));
    spec.x = s.x;
    spec.y = s.y;
    spec.full_x = s.full_x;
    spec.full_y = s.full_y;
    spec.full_width = s.full_w;
    spec.full_height = s.full_h;
    for (std::string &name : spec.channelnames) {
        name = at;
        at += name.size() + 1;
    }
    const std::string space = at;
    at += space.size() + 1;
    for (int c = 0; c < s.channels && s.typed; c++)
        spec.channelformats.push_back(at[c] == 0   ? TypeDesc::UINT32
                                      : at[c] == 1 ? TypeDesc::HALF
                                                   : TypeDesc::FLOAT);
    if (s.channels == 4 && !s.typed) {
        spec.alpha_channel = 3;
        if (!spec.format.is_floating_point())
            spec.attribute("oiio:UnassociatedAlpha", 1);
    }
    if (!space.empty())
        spec.attribute("oiio:ColorSpace", space);
    if (s.has_chromaticities)
        spec.attribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8),
                       s.chromaticities);
    if (ask.compression[0])
        spec.attribute("compression", ask.compression);
    return spec;
}

// Fields for a name that OpenImageIO fills with other bytes in each run. SGI's
// it leaves as its memory was, addresses and all ("The SGI Image File Format",
// 1.00); DPX's gets the number of a descriptor (SMPTE 268M, section 7.1).
void clear_name(int fd)
{
    static const struct {
        char magic[5];
        std::size_t magics; // bytes of magic
        off_t at;
        std::size_t size;
    } fields[] = {
        {"\x01\xda", 2, 24, 80}, {"SDPX", 4, 36, 100}, {"XPDS", 4, 36, 100},
    };
    static const char none[100] = {0};
    char magic[4] = {0};
    if (pread(fd, magic, sizeof magic, 0) != sizeof magic)
        return;
    for (const auto &f : fields) {
        if (std::memcmp(magic, f.magic, f.magics) == 0 &&
            pwrite(fd, none, f.size, f.at) != static_cast<ssize_t>(f.size))
            throw std::runtime_error("its header cannot be written again");
    }
}

void write_file(int fd, const gp_oiio_ask &ask,
                        const std::string &text, const void *pixels)
{
    file.reset();
    limit_memory(4 * ask.size);
    ImageSpec spec = make_spec(ask, text);
    // Most writers do not check whether their last bytes were written. Under a
    // limit of file sizes, refuses a file that may be larger, at worst packing.
    const std::uint64_t most = 2 * static_cast<std::uint64_t>(
        spec.image_bytes(ask.spec.typed)) + (std::uint64_t(1) << 16);
    struct rlimit limit;
    if (!getrlimit(RLIMIT_FSIZE, &limit) && limit.rlim_cur != RLIM_INFINITY &&
        most > limit.rlim_cur)
        throw std::runtime_error(
            "needs up to " + std::to_string(most) +
            " bytes, over the limit of " + std::to_string(limit.rlim_cur) +
            ", see ulimit -f");
    std::unique_ptr<ImageOutput> out = ImageOutput::create(ask.format);
    if (!out)
        throw std::runtime_error(OIIO::geterror());
    // TIFF's writer puts the time of writing where there is no date, and other
    // bytes into the file each second; a date that is no string is not stored
    if (std::string(out->format_name()) == "tiff")
        spec.attribute("DateTime", 0);
    if (!out->open("/proc/self/fd/" + std::to_string(fd), spec))
        throw std::runtime_error(out->geterror());
    // TypeUnknown: each channel in its own type, as spec.channelformats says
    const bool written = out->write_image(
        ask.spec.typed ? TypeDesc::UNKNOWN : TypeDesc::FLOAT, pixels);
    const bool closed = out->close();
    if (!written || !closed)
        throw std::runtime_error(out->geterror());
    clear_name(fd);
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
    if (ask.call == GP_OIIO_OPEN) {
        const int given = fd[0];
        fd[0] = -1;
        open_file(given, ask, reply.spec, text);
        return;
    }
    if (ask.call == GP_OIIO_PIXELS)
        read_pixels(Shared(fd[0], ask.size).samples());
    else
        write_file(fd[0], ask, text, Shared(fd[1], ask.size).samples());
    text.clear();
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
    file.reset();
}

} // namespace

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
