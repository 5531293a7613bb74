/* A kernel's file. The last byte chooses centre, turn and normalising. */
#include "glare/kernel.h"
#include "harness.h"
#include "io/io_priv.h"
#include "../unit/views.h"

static void make_kernel(const struct gp_image *f, uint8_t choice)
{
    struct gp_kernel k;
    struct gp_kernel_params p = {0};
    p.centered = choice & 1;
    p.center[0] = f->data.x0 + (choice >> 4) - 2.0;
    p.center[1] = f->data.y1 - 0.5;
    p.normalize = choice & 2 ? GP_NORMALIZE_NONE : p.normalize;
    p.rotate = choice & 4 ? 30.0f : choice & 8 ? -90.0f : 0.0f;
    if (fuzz_line(gp_kernel_from_frame(&fuzz_log, &p, f, &k)))
        return;
    for (int c = 0; c < 3; c++)
        fuzz_touch(k.k.c[c], (size_t) k.w * (size_t) k.h * sizeof(float));
    gp_kernel_free(&k);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const struct gp_read_params p = {.max_pixels = FUZZ_PIXELS};
    struct gp_stream s = gp_stream_of(data, size);
    struct gp_frame f = {0};
    fuzz_begin();
    if (!fuzz_line(gp_read_stream(&fuzz_log, &p, "input", &s, &f))) {
        const struct gp_image v = view_of(&f);
        make_kernel(&v, data[size - 1]);
        gp_frame_free(&f);
    }
    fuzz_end(fuzz_allowed(data, size));
    return 0;
}
