// What is refused before memory is taken for it. See io/oiio/oiio.h.
#include "io/oiio/bridge.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

namespace {

// Most pixels that a byte of a file can hold, with room to spare: formats
// that are raw or have runs of known length. Not here are those that pack
// without such a limit, or may point to the same bytes twice.
const struct {
    const char *format;
    long long pixels;
} density[] = {
    {"targa", 256},  // runs of 128 pixels in 2 bytes
    {"bmp", 256},    // 255 in 2 bytes
    {"hdr", 256},    // 127 in 8 bytes
    {"pnm", 256},    // a pixel a bit
    {"dpx", 8192},   // 32767 in 4 bytes, of one channel
    {"cineon", 256}, // raw
    {"iff", 256},    // 128 in 2 bytes a channel
    {"rla", 256},    // 128 in 2 bytes a channel
    {"softimage", 32768}, // 65535 in 4 bytes
};

std::string size_text(const OIIO::ImageSpec &spec)
{
    return std::to_string(spec.width) + " x " + std::to_string(spec.height) +
           " pixels";
}

void check_density(const OIIO::ImageSpec &spec, const char *format,
                   std::size_t size, long long pixels)
{
    for (const auto &d : density) {
        if (std::strcmp(d.format, format) == 0 &&
            static_cast<std::size_t>(pixels / d.pixels) > size)
            throw std::runtime_error(std::to_string(size) +
                                     " bytes cannot hold " + size_text(spec));
    }
}

} // namespace

void gp_oiio_check_size(const OIIO::ImageSpec &spec, const char *format,
                        std::size_t size, long long max_pixels)
{
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1)
        throw std::runtime_error("no pixels");
    if (spec.depth > 1 || spec.tile_depth > 1)
        throw std::runtime_error("a volume, not a picture");
    if (spec.deep)
        throw std::runtime_error("deep data");
    // so that window edges can be added up without a thought
    const long long far = 1LL << 29;
    for (long long v : {spec.x, spec.y, spec.width, spec.height, spec.full_x,
                        spec.full_y, spec.full_width, spec.full_height}) {
        if (v <= -far || v >= far)
            throw std::runtime_error("windows out of range");
    }
    const long long pixels =
        static_cast<long long>(spec.width) * spec.height;
    if (pixels > max_pixels)
        throw std::runtime_error("too large: " + size_text(spec) +
                                 ", at most " + std::to_string(max_pixels));
    const bool exr = std::strcmp(format, "openexr") == 0;
    const long long fours = (spec.nchannels + 3LL) / 4;
    if (!exr && fours > max_pixels / pixels)
        throw std::runtime_error(
            "too large: " + size_text(spec) + " of " +
            std::to_string(spec.nchannels) +
            " channels, each four of which count as pixels; at most " +
            std::to_string(max_pixels));
    // a reader takes memory for whole tiles
    const long long tile = static_cast<long long>(spec.tile_width) *
                           std::max(1, spec.tile_height);
    if (tile > std::max(4 * pixels, 1LL << 20))
        throw std::runtime_error("tiles larger than the picture");
    check_density(spec, format, size, pixels);
    // 2.4 leaves parts of them as its memory was
    if (tile > 0 && spec.format == OIIO::TypeDesc::DOUBLE &&
        std::strcmp(format, "tiff") == 0 &&
        spec.get_string_attribute("planarconfig") != "separate")
        throw std::runtime_error("tiles of 64-bit floats, which OpenImageIO "
                                 "reads wrong");
}
