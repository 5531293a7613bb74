// SPDX-License-Identifier: Apache-2.0
// The peer of the whole process: what OpenEXR's C++ library and plain 2-D FFTW
// take for the same files, and nothing else.
//
//   plain copy  IN OUT THREADS                    decodes and encodes R, G, B
//   plain glare IN OUT THREADS KERNEL WIDTH HEIGHT  ... with the convolution
//
// OUT is half ZIP. WIDTH x HEIGHT is the padded transform; plans are estimated,
// as a run that makes one picture would.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfThreading.h>
#include <fftw3.h>
#include <half.h>
#include <omp.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

static const char *const names[3] = {"R", "G", "B"};

template <class T> struct Image {
    int w = 0, h = 0;
    std::vector<T> plane[3];
};

template <class T>
static void load(const char *path, Imf::PixelType type, Image<T> &m)
{
    Imf::InputFile in(path);
    const auto d = in.header().dataWindow();
    m.w = d.max.x - d.min.x + 1;
    m.h = d.max.y - d.min.y + 1;
    Imf::FrameBuffer fb;
    for (int c = 0; c < 3; c++) {
        m.plane[c].resize((size_t) m.w * m.h);
        fb.insert(names[c],
                  Imf::Slice(type,
                             (char *) (m.plane[c].data() - d.min.x -
                                       (ptrdiff_t) d.min.y * m.w),
                             sizeof(T), sizeof(T) * (size_t) m.w));
    }
    in.setFrameBuffer(fb);
    in.readPixels(d.min.y, d.max.y);
}

static void store(const char *path, const Image<half> &m)
{
    Imf::Header header(m.w, m.h);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer fb;
    for (int c = 0; c < 3; c++) {
        header.channels().insert(names[c], Imf::Channel(Imf::HALF));
        fb.insert(names[c], Imf::Slice(Imf::HALF, (char *) m.plane[c].data(),
                                       2, 2 * (size_t) m.w));
    }
    Imf::OutputFile out(path, header);
    out.setFrameBuffer(fb);
    out.writePixels(m.h);
}

static void copy(const char *in, const char *out)
{
    Image<half> m;
    load(in, Imf::HALF, m);
    store(out, m);
}

static void glare(const char *in, const char *out, const char *kernel, int w,
                  int h)
{
    Image<float> a, k;
    load(in, Imf::FLOAT, a);
    load(kernel, Imf::FLOAT, k);
    const size_t pitch = 2 * (size_t) (w / 2 + 1), n = pitch * (size_t) h;
    float *const z = fftwf_alloc_real(n), *const s = fftwf_alloc_real(n);
    fftwf_init_threads();
    fftwf_plan_with_nthreads(omp_get_max_threads());
    const fftwf_plan there = fftwf_plan_dft_r2c_2d(
        h, w, z, (fftwf_complex *) z, FFTW_ESTIMATE);
    const fftwf_plan back = fftwf_plan_dft_c2r_2d(
        h, w, (fftwf_complex *) z, z, FFTW_ESTIMATE);
    Image<half> o;
    o.w = a.w;
    o.h = a.h;
    for (int c = 0; c < 3; c++) {
        o.plane[c].resize(a.plane[c].size());
        memset(s, 0, n * sizeof *s);
        for (int y = 0; y < k.h; y++)
            for (int x = 0; x < k.w; x++)
                s[(size_t) ((y - k.h / 2 + h) % h) * pitch +
                  (size_t) ((x - k.w / 2 + w) % w)] =
                    k.plane[c][(size_t) y * k.w + x] / ((float) w * (float) h);
        fftwf_execute_dft_r2c(there, s, (fftwf_complex *) s);
#pragma omp parallel for
        for (int y = 0; y < h; y++) {
            float *const row = z + (size_t) y * pitch;
            memset(row, 0, pitch * sizeof *row);
            for (int x = 0; y < a.h && x < a.w; x++) {
                const size_t i = (size_t) y * a.w + x;
                const float lum = .2126f * a.plane[0][i] +
                                  .7152f * a.plane[1][i] +
                                  .0722f * a.plane[2][i];
                row[x] = lum > 1.f ? a.plane[c][i] : 0.f;
            }
        }
        fftwf_execute(there);
#pragma omp parallel for
        for (size_t i = 0; i < n / 2; i++) {
            const float u = z[2 * i], v = z[2 * i + 1];
            z[2 * i] = u * s[2 * i] - v * s[2 * i + 1];
            z[2 * i + 1] = u * s[2 * i + 1] + v * s[2 * i];
        }
        fftwf_execute(back);
#pragma omp parallel for
        for (int y = 0; y < a.h; y++)
            for (int x = 0; x < a.w; x++) {
                const size_t i = (size_t) y * a.w + x;
                o.plane[c][i] = a.plane[c][i] + z[(size_t) y * pitch + x];
            }
    }
    store(out, o);
}

int main(int argc, char **argv)
try {
    const std::string what = argc > 1 ? argv[1] : "";
    if (!(what == "copy" && argc == 5) && !(what == "glare" && argc == 8)) {
        fprintf(stderr, "usage: plain copy IN OUT THREADS\n"
                        "       plain glare IN OUT THREADS KERNEL W H\n");
        return 2;
    }
    const int threads = atoi(argv[4]);
    omp_set_num_threads(threads);
    Imf::setGlobalThreadCount(threads > 1 ? threads : 0);
    if (what == "copy")
        copy(argv[2], argv[3]);
    else
        glare(argv[2], argv[3], argv[5], atoi(argv[6]), atoi(argv[7]));
    return 0;
} catch (const std::exception &e) {
    fprintf(stderr, "plain: %s\n", e.what());
    return 3;
}
