// Reading and resizing by OpenImageIO. See io/oiio/oiio.h.
#include "io/oiio/bridge.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>

namespace {

using OIIO::ImageInput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

// Bytes in memory as a file with a name, for formats whose reader wants one.
class MemoryFile {
public:
    MemoryFile(const void *data, std::size_t size)
        : fd_(memfd_create("glarepp", MFD_CLOEXEC))
    {
        const char *at = static_cast<const char *>(data);
        while (fd_ >= 0 && size > 0) {
            ssize_t n = ::write(fd_, at, size);
            if (n <= 0) {
                ::close(fd_);
                throw std::runtime_error("no room for a copy in memory");
            }
            at += n;
            size -= static_cast<std::size_t>(n);
        }
    }
    ~MemoryFile()
    {
        if (fd_ >= 0)
            ::close(fd_);
    }
    MemoryFile(const MemoryFile &) = delete;
    MemoryFile &operator=(const MemoryFile &) = delete;
    std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

private:
    int fd_;
};

// Where the bytes come from; it lives as long as the reader.
struct Source {
    std::unique_ptr<MemoryFile> file;
    std::unique_ptr<ImageInput> input;
};

// What a gp_oiio_image points into, and where its rows still come from.
struct Owned {
    std::vector<float> pixels;
    std::vector<std::string> text;
    std::vector<const char *> names;
    std::vector<gp_oiio_attribute> attributes;
    Source source;
    ImageSpec spec;
    int part = 0;
};

Source open_source(const std::string &path, const void *data,
                   std::size_t size)
{
    Source s;
    std::string name = path;
    if (data) {
        s.file = std::make_unique<MemoryFile>(data, size);
        name = s.file->path();
    }
    s.input = ImageInput::open(name);
    if (!s.input)
        throw std::runtime_error(OIIO::geterror());
    // 2.4's readers write past their memory in icons of a few pixels, and take
    // each row of a FITS for the one above
    if (std::strcmp(s.input->format_name(), "ico") == 0)
        throw std::runtime_error("an icon, which is no picture here");
    if (std::strcmp(s.input->format_name(), "fits") == 0)
        throw std::runtime_error("a FITS, which OpenImageIO reads a row off");
    if (s.input->supports("procedural"))
        throw std::runtime_error(
            std::string(s.input->format_name()) +
            ", whose pictures OpenImageIO makes up from a name");
    return s;
}

// Readers may say what was wrong and go on, with black in its place.
void check_read(const ImageInput &input, bool read)
{
    if (!read || input.has_error())
        throw std::runtime_error(input.geterror());
}

// EXR's uint32 channels, whose values floats cannot hold, bit by bit.
void read_uints(ImageInput &input, const ImageSpec &spec, int part,
                std::vector<float> &pixels)
{
    const std::size_t n = static_cast<std::size_t>(spec.nchannels);
    for (int c = 0; c < spec.nchannels; c++) {
        if (spec.channelformat(c) != TypeDesc::UINT32)
            continue;
        std::vector<unsigned> bits(pixels.size() / n);
        check_read(input, input.read_image(part, 0, c, c + 1,
                                           TypeDesc::UINT32, bits.data()));
        for (std::size_t i = 0; i < bits.size(); i++)
            std::memcpy(&pixels[i * n + static_cast<std::size_t>(c)],
                        &bits[i], sizeof bits[i]);
    }
}

void add_attribute(const OIIO::ParamValue &p, Owned &own)
{
    gp_oiio_attribute a = {};
    if (p.type() == TypeDesc::STRING)
        a.kind = 0;
    else if (p.type() == TypeDesc::INT)
        a.kind = 1;
    else if (p.type() == TypeDesc::FLOAT)
        a.kind = 2;
    else
        return; // no other type goes into every format
    own.text.push_back(p.name().string());
    own.text.push_back(a.kind == 0 ? p.get_string() : std::string());
    a.whole = a.kind == 1 ? p.get_int() : 0;
    a.real = a.kind == 2 ? p.get_float() : 0.0f;
    own.attributes.push_back(a);
}

// Pointers into `own` are taken last, when its vectors no longer move.
void describe(Owned &own, gp_oiio_image *out)
{
    ImageSpec &spec = own.spec;
    const std::size_t n = static_cast<std::size_t>(spec.nchannels);
    if (spec.channelnames.size() != n) // nothing holds a reader to it
        spec.default_channel_names();
    for (const std::string &name : spec.channelnames)
        own.text.push_back(name);
    own.text.push_back(spec.get_string_attribute("oiio:ColorSpace"));
    const std::size_t first = own.text.size();
    for (const OIIO::ParamValue &p : spec.extra_attribs)
        add_attribute(p, own);
    for (std::size_t i = 0; i < n; i++)
        own.names.push_back(own.text[i].c_str());
    for (std::size_t i = 0; i < own.attributes.size(); i++) {
        own.attributes[i].name = own.text[first + 2 * i].c_str();
        own.attributes[i].text = own.text[first + 2 * i + 1].c_str();
    }
    out->x = spec.x;
    out->y = spec.y;
    out->w = spec.width;
    out->h = spec.height;
    out->full_x = spec.full_x;
    out->full_y = spec.full_y;
    out->full_w = spec.full_width;
    out->full_h = spec.full_height;
    out->channels = spec.nchannels;
    out->channel_name = own.names.data();
    out->half = spec.format == TypeDesc::HALF;
    out->bits = spec.format.is_floating_point()
                    ? 0 : static_cast<int>(8 * spec.format.size());
    out->pixels = own.pixels.data();
    const OIIO::ParamValue *c = spec.find_attribute(
        "chromaticities", TypeDesc(TypeDesc::FLOAT, 8));
    out->has_chromaticities = c != nullptr;
    if (c)
        std::memcpy(out->chromaticities, c->data(),
                    sizeof out->chromaticities);
    out->colour_space = own.text[n].c_str();
    out->attribute = own.attributes.data();
    out->attributes = static_cast<int>(own.attributes.size());
}

// Rows of one block: those of a row of tiles or, near 16 MiB, whole strips:
// of a packed strip that is read in parts OpenImageIO loses doubles.
int block_rows(const ImageSpec &spec, const char *format)
{
    if (spec.tile_width > 0)
        return std::min(spec.tile_height, spec.height);
    const std::size_t row = static_cast<std::size_t>(spec.width) *
                            static_cast<std::size_t>(spec.nchannels) *
                            sizeof(float);
    const int room = static_cast<int>(
        std::max<std::size_t>(1, (std::size_t(16) << 20) / row));
    int strip = 1;
    if (std::strcmp(format, "tiff") == 0)
        strip = spec.get_int_attribute("tiff:RowsPerStrip", spec.height);
    if (strip < 1 || strip > spec.height)
        strip = spec.height;
    return std::min(std::max(room - room % strip, strip), spec.height);
}

std::unique_ptr<Owned> open_part(const char *path, const void *data,
                                 std::size_t size, int part,
                                 long long max_pixels)
{
    auto own = std::make_unique<Owned>();
    own->source = open_source(path, data, size);
    ImageInput &input = *own->source.input;
    if (!input.seek_subimage(part, 0))
        throw std::runtime_error("part " + std::to_string(part) +
                                 " is not there");
    own->spec = input.spec();
    own->part = part;
    gp_oiio_check_size(own->spec, input.format_name(), size, max_pixels);
    return own;
}

void publish(std::unique_ptr<Owned> own, gp_oiio_image *out)
{
    *out = {};
    describe(*own, out);
    out->own = own.release();
}

int read(const char *path, const void *data, std::size_t size, int part,
         long long max_pixels, gp_oiio_image *out, char *why,
         std::size_t why_size)
try {
    auto own = open_part(path, data, size, part, max_pixels);
    ImageInput &input = *own->source.input;
    const ImageSpec &spec = own->spec;
    own->pixels.resize(spec.image_pixels() *
                       static_cast<std::size_t>(spec.nchannels));
    check_read(input, input.read_image(part, 0, 0, spec.nchannels,
                                       TypeDesc::FLOAT, own->pixels.data()));
    if (std::strcmp(input.format_name(), "openexr") == 0)
        read_uints(input, spec, part, own->pixels);
    own->source = {};
    publish(std::move(own), out);
    return 0;
} catch (...) {
    return gp_oiio_caught(why, why_size);
}

int open(const char *path, const void *data, std::size_t size, int part,
         long long max_pixels, gp_oiio_image *out, char *why,
         std::size_t why_size)
try {
    auto own = open_part(path, data, size, part, max_pixels);
    const int block = block_rows(own->spec, own->source.input->format_name());
    publish(std::move(own), out);
    out->block = block;
    out->pixels = nullptr;
    return 0;
} catch (...) {
    return gp_oiio_caught(why, why_size);
}

int rows(gp_oiio_image *image, int y, float *to, char *why,
         std::size_t why_size)
try {
    Owned &own = *static_cast<Owned *>(image->own);
    ImageInput &input = *own.source.input;
    const ImageSpec &spec = own.spec;
    const int y0 = spec.y + y;
    const int y1 = spec.y + std::min(y + image->block, spec.height);
    const bool read =
        spec.tile_width > 0
            ? input.read_tiles(own.part, 0, spec.x, spec.x + spec.width, y0,
                               y1, spec.z, spec.z + 1, 0, spec.nchannels,
                               TypeDesc::FLOAT, to)
            : input.read_scanlines(own.part, 0, y0, y1, spec.z, 0,
                                   spec.nchannels, TypeDesc::FLOAT, to);
    check_read(input, read);
    return 0;
} catch (...) {
    return gp_oiio_caught(why, why_size);
}

void image_free(gp_oiio_image *image)
{
    delete static_cast<Owned *>(image->own);
    *image = {};
}

// Scales each channel of `to` so that its mean is that of `from`. A mean that
// cancels, or changes a lot, says nothing about flux and is left alone.
void keep_means(const gp_oiio_image *from, gp_oiio_image *to)
{
    const int n = to->channels;
    const std::size_t in = static_cast<std::size_t>(from->w) *
                           static_cast<std::size_t>(from->h);
    const std::size_t out =
        static_cast<std::size_t>(to->w) * static_cast<std::size_t>(to->h);
    for (int c = 0; c < n; c++) {
        double a = 0.0, b = 0.0;
        for (std::size_t i = 0; i < in; i++)
            a += static_cast<double>(from->pixels[i * n + c]);
        for (std::size_t i = 0; i < out; i++)
            b += static_cast<double>(to->pixels[i * n + c]);
        double scale = (a / static_cast<double>(in)) /
                       (b / static_cast<double>(out));
        if (!(scale > 0.5 && scale < 2.0))
            continue;
        for (std::size_t i = 0; i < out; i++)
            to->pixels[i * n + c] *= static_cast<float>(scale);
    }
}

int resize(const gp_oiio_image *img, int w, int h, gp_oiio_image *out,
           char *why, std::size_t why_size)
try {
    ImageSpec in(img->w, img->h, img->channels, TypeDesc::FLOAT);
    for (int c = 0; c < img->channels && img->channel_name; c++)
        in.channelnames[static_cast<std::size_t>(c)] = img->channel_name[c];
    OIIO::ImageBuf from(in, img->pixels);
    ImageSpec wanted(w, h, img->channels, TypeDesc::FLOAT);
    wanted.channelnames = in.channelnames;
    OIIO::ImageBuf to(wanted);
    if (!OIIO::ImageBufAlgo::resize(to, from, "lanczos3"))
        throw std::runtime_error(to.geterror());
    auto own = std::make_unique<Owned>();
    own->pixels.resize(wanted.image_pixels() *
                       static_cast<std::size_t>(img->channels));
    if (!to.get_pixels(OIIO::ROI::All(), TypeDesc::FLOAT,
                       own->pixels.data()))
        throw std::runtime_error(to.geterror());
    own->spec = wanted;
    publish(std::move(own), out);
    keep_means(img, out);
    return 0;
} catch (...) {
    return gp_oiio_caught(why, why_size);
}

const struct gp_oiio_api api = {
    GP_OIIO_API_VERSION, read,   open, rows, image_free, gp_oiio_write,
    gp_oiio_can_write,   resize,
};

} // namespace

int gp_oiio_why(char *why, std::size_t why_size, const std::string &text)
{
    // plugins catch what is thrown and keep its words alone
    static const char *const memory[] = {
        "bad_alloc", "bad alloc", "ut of memory", "nsufficient memory",
        "no room for a copy in memory",
    };
    int status = -1;
    for (const char *word : memory) {
        if (text.find(word) != std::string::npos)
            status = GP_OIIO_MEMORY;
    }
    if (why_size == 0)
        return status;
    std::size_t n = std::min(text.size(), why_size - 1);
    std::copy_n(text.begin(), n, why);
    why[n] = '\0';
    std::replace(why, why + n, '\n', ' ');
    std::replace(why, why + n, '\r', ' ');
    return status;
}

int gp_oiio_caught(char *why, std::size_t why_size)
try {
    throw;
} catch (const std::exception &e) {
    return gp_oiio_why(why, why_size, e.what());
} catch (...) {
    return gp_oiio_why(why, why_size, "OpenImageIO failed");
}

extern "C" __attribute__((visibility("default"))) const struct gp_oiio_api *
gp_oiio_api(void)
{
    return &api;
}
