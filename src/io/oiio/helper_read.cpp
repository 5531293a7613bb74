// Reading by OpenImageIO. See io/oiio/protocol.h.
#include "io/oiio/protocol.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <unistd.h>

namespace {

using OIIO::ImageInput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

// -- bytes --------------------------------------------------------------------

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
std::unique_ptr<File> file;

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
    const ImageSpec &s = file->spec;
    const bool read =
        s.tile_width > 0
            ? input.read_tiles(file->part, 0, s.x, s.x + s.width, s.y,
                               s.y + s.height, s.z, s.z + 1, c0, c1, type, to)
            : input.read_scanlines(file->part, 0, s.y, s.y + s.height, s.z,
                                   c0, c1, type, to);
    if (!read || input.has_error())
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

} // namespace

void helper::open_file(int fd, const gp_oiio_ask &ask, gp_oiio_spec &spec,
                       std::string &text)
{
    close_file();
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

void helper::read_pixels(float *to)
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
    close_file();
}

void helper::close_file()
{
    file.reset();
}
