// SPDX-License-Identifier: Apache-2.0
/* Reading for tests: errors go to kept_line, files into a folder. */
#ifndef READING_H
#define READING_H

#include "io/frame.h"
#include "folder.h"
#include "io/read.h"
#include "kept_log.h"
#include "unit.h"

#include <unistd.h>

static gp_status read_file(const char *name, struct gp_frame *f)
{
    const struct gp_read_params p = GP_READ_DEFAULTS;
    kept_clear();
    *f = (struct gp_frame) {0};
    return gp_read_frame(&kept_log, &p, name, f);
}

/* One error line, of this status, that says `what`, and no frame. */
static inline void assert_refused(const char *name, gp_status want,
                                  const char *what)
{
    struct gp_frame f;
    assert_int_equal(read_file(name, &f), want);
    assert_int_equal(kept_errors, 1);
    assert_kept(what);
    assert_ptr_equal(strstr(kept_line, name), kept_line);
    assert_kept("; "); // the hint
    assert_null(f.rgb.c[0]);
}

#endif
