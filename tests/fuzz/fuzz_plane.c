/* A file of its own for depth or coverage, from disk. */
#include "io/frame.h"
#include "harness.h"
#include "io/plane.h"

static void read_plane(const char *path, const char *name, bool depth)
{
    const struct gp_read_params p = {.max_pixels = FUZZ_PIXELS};
    struct gp_plane plane = {0};
    if (fuzz_line(gp_read_plane_file(&fuzz_log, &p, path, name, depth,
                                     &plane)))
        return;
    fuzz_touch(plane.v, (size_t) gp_rect_w(plane.window) *
                            (size_t) gp_rect_h(plane.window) * sizeof(float));
    gp_plane_free(&plane);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *const path = size ? fuzz_file(data, size) : NULL;
    fuzz_begin();
    if (path) {
        read_plane(path, NULL, true);
        read_plane(path, NULL, false);
        read_plane(path, "part.Z", true);
    }
    fuzz_end(fuzz_allowed(data, size));
    fuzz_file_close();
    return 0;
}
