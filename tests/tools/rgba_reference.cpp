// SPDX-License-Identifier: Apache-2.0
// Writes the pixels that OpenEXR's RgbaInputFile reads from a file to stdout: raw
// floats, R, G, B of each pixel of the data window. It is the reference for
// formats where OpenImageIO cannot be: luminance-chroma, which it does not read,
// and DWA, which the tested bridge reads by it.
#include <ImfRgbaFile.h>

#include <cstddef>
#include <cstdio>
#include <exception>
#include <vector>

int main(int argc, char **argv)
try {
    if (argc != 2) {
        std::fprintf(stderr, "usage: rgba_reference FILE\n");
        return 2;
    }
    Imf::RgbaInputFile file(argv[1]);
    const Imath::Box2i data = file.dataWindow();
    const std::size_t w = static_cast<std::size_t>(data.max.x - data.min.x) + 1;
    const std::size_t h = static_cast<std::size_t>(data.max.y - data.min.y) + 1;
    std::vector<Imf::Rgba> pixels(w * h);
    std::vector<float> row(3 * w);
    const std::ptrdiff_t origin =
        data.min.x + data.min.y * static_cast<std::ptrdiff_t>(w);
    file.setFrameBuffer(pixels.data() - origin, 1, w);
    file.readPixels(data.min.y, data.max.y);
    for (std::size_t y = 0; y < h; y++) {
        for (std::size_t x = 0; x < w; x++) {
            const Imf::Rgba &p = pixels[y * w + x];
            row[3 * x] = p.r;
            row[3 * x + 1] = p.g;
            row[3 * x + 2] = p.b;
        }
        if (std::fwrite(row.data(), sizeof(float), row.size(), stdout) !=
            row.size())
            return 3;
    }
    return 0;
} catch (const std::exception &e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 4;
}
