// Writing by OpenImageIO. See io/oiio/protocol.h.
#include "io/oiio/protocol.h"

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include <sys/resource.h>
#include <unistd.h>

namespace {

using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

ImageSpec make_spec(const gp_oiio_ask &ask, const std::string &text)
{
    const gp_oiio_spec &s = ask.spec;
    const std::string type = ask.type;
    const char *at = text.c_str();
    ImageSpec spec(s.w, s.h, s.channels,
                   type == "half"     ? TypeDesc::HALF
                   : type == "uint8"  ? TypeDesc::UINT8
                   : type == "uint16" ? TypeDesc::UINT16
                                      : TypeDesc::FLOAT);
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
        if (type == "uint8" || type == "uint16")
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

} // namespace

void helper::write_file(int fd, const gp_oiio_ask &ask,
                        const std::string &text, const void *pixels)
{
    close_file();
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
