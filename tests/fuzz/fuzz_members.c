// SPDX-License-Identifier: Apache-2.0
/* Several images in one pipe. */
#include "harness.h"
#include "io/read.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    enum { MOST = 16 }; // frames to read of one input
    const struct gp_read_params p = {.max_pixels = FUZZ_PIXELS};
    struct gp_members m = {.stream = GP_STREAM_EMPTY};
    const char *const path = fuzz_pipe(data, size);
    fuzz_begin();
    if (path && !fuzz_line(gp_members_read(&fuzz_log, &p, path, &m))) {
        uint64_t end = 0;
        for (int i = 0; i < m.n; i++) { // in order, none over another
            if (m.member[i].at < end || m.member[i].size == 0 ||
                m.member[i].size > size - m.member[i].at)
                abort();
            end = m.member[i].at + m.member[i].size;
        }
        for (int i = 0; i < m.n && i < MOST; i++) {
            struct gp_frame f = {0};
            if (!fuzz_line(gp_members_frame(&fuzz_log, &p, "input", &m, i,
                                            &f)))
                gp_frame_free(&f);
        }
        gp_members_free(&m);
    }
    fuzz_end(fuzz_allowed(data, size));
    fuzz_pipe_close();
    return 0;
}
