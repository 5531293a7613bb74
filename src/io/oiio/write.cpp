// Writing by OpenImageIO. See io/oiio/oiio.h.
#include "io/oiio/bridge.hpp"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string>

#include <sys/resource.h>

namespace {

using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

TypeDesc type_of(const std::string &type)
{
    if (type == "half")
        return TypeDesc::HALF;
    if (type == "uint8")
        return TypeDesc::UINT8;
    if (type == "uint16")
        return TypeDesc::UINT16;
    return TypeDesc::FLOAT;
}

// enum gp_pixel_type
TypeDesc type_of_channel(int type)
{
    return type == 0   ? TypeDesc::UINT32
           : type == 1 ? TypeDesc::HALF
                       : TypeDesc::FLOAT;
}

ImageSpec make_spec(const gp_oiio_image *img, const std::string &type,
                    const std::string &compression)
{
    ImageSpec spec(img->w, img->h, img->channels, type_of(type));
    spec.x = img->x;
    spec.y = img->y;
    spec.full_x = img->full_x;
    spec.full_y = img->full_y;
    spec.full_width = img->full_w;
    spec.full_height = img->full_h;
    for (int c = 0; c < img->channels && img->channel_name; c++)
        spec.channelnames[static_cast<std::size_t>(c)] = img->channel_name[c];
    for (int c = 0; c < img->channels && img->channel_type; c++)
        spec.channelformats.push_back(type_of_channel(img->channel_type[c]));
    if (img->channels == 4 && !img->native) {
        spec.alpha_channel = 3;
        if (type == "uint8" || type == "uint16")
            spec.attribute("oiio:UnassociatedAlpha", 1);
    }
    if (img->colour_space && img->colour_space[0])
        spec.attribute("oiio:ColorSpace", img->colour_space);
    if (img->has_chromaticities)
        spec.attribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8),
                       img->chromaticities);
    if (!compression.empty())
        spec.attribute("compression", compression);
    return spec;
}

// Plugins whose files hold what they were given, each a column of `make
// hardcases`. Of 2.4's others RLA loses samples, FITS writes its rows one too
// high, IFF 1x1 as black and what its memory held beside the picture, GIF is
// not the same from run to run, HEIF's writer reads past the end of its rows,
// and icons are not read back; JPEG 2000 wants a file that is called so, which
// one in memory is not; Zfile holds depth alone; null and term write no file.
bool is_right(const std::string &plugin)
{
    static const char *const right[] = {"bmp", "dpx", "hdr",  "jpeg",
                                        "openexr", "png", "pnm", "sgi",
                                        "targa", "tiff", "webp"};
    return std::find(std::begin(right), std::end(right), plugin) !=
           std::end(right);
}

// Most writers do not look whether their last bytes got into the file. Where
// files may not grow, one whose bytes might not fit, packed as they come out at
// worst, is not begun. Empty when all is well.
std::string over_limit(const ImageSpec &spec, bool native)
{
    const std::uint64_t most = 2 * static_cast<std::uint64_t>(
                                       spec.image_bytes(native)) +
                               (std::uint64_t(1) << 16);
    struct rlimit limit;
    if (getrlimit(RLIMIT_FSIZE, &limit) || limit.rlim_cur == RLIM_INFINITY ||
        most <= limit.rlim_cur)
        return "";
    return "up to " + std::to_string(most) + " bytes, but files may have " +
           std::to_string(limit.rlim_cur) + ", see ulimit -f";
}

} // namespace

int gp_oiio_write(const char *path, const char *format,
                  const struct gp_oiio_image *img, const char *type,
                  const char *compression, char *why, std::size_t why_size)
try {
    ImageSpec spec = make_spec(img, type, compression);
    const std::string over = over_limit(spec, img->native);
    if (!over.empty())
        return gp_oiio_why(why, why_size, over);
    std::unique_ptr<ImageOutput> out = ImageOutput::create(format);
    if (!out)
        return gp_oiio_why(why, why_size, OIIO::geterror());
    // TIFF's writer puts the time of writing where there is no date, and other
    // bytes into the file each second; a date that is no string is not stored
    if (std::string(out->format_name()) == "tiff")
        spec.attribute("DateTime", 0);
    if (!out->open(path, spec))
        return gp_oiio_why(why, why_size, out->geterror());
    // TypeUnknown: each channel in its own type, as spec.channelformats says
    const bool written =
        img->native ? out->write_image(TypeDesc::UNKNOWN, img->native)
                    : out->write_image(TypeDesc::FLOAT, img->pixels);
    const bool closed = out->close();
    if (!written || !closed)
        return gp_oiio_why(why, why_size, out->geterror());
    return 0;
} catch (...) {
    return gp_oiio_caught(why, why_size);
}

int gp_oiio_can_write(const char *format)
try {
    const std::string name = format;
    if (name.empty())
        return 0;
    std::unique_ptr<ImageOutput> out = ImageOutput::create(name);
    (void) OIIO::geterror(); // an unknown name is an answer, not a fault
    if (!out)
        return 0;
    const std::string plugin = out->format_name();
    // EXR's other endings would get codes
    return is_right(plugin) && (plugin != "openexr" || name == "exr");
} catch (...) {
    return 0;
}
