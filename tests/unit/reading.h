/* What tests of io/read share: the error lines that were heard, and a folder
 * of their own for those that make files. */
#ifndef READING_H
#define READING_H

#include "core/frame.h"
#include "io/read.h"

#include "unit.h"

#include <unistd.h>

static char folder[] __attribute__((unused)) = "/tmp/glarepp-test-XXXXXX";
static char path[256] __attribute__((unused));

/* The last error line, and how many there were. */
static struct {
    char line[4096];
    int count;
} heard;

static void listen(void *user, enum gp_level level, const char *line)
{
    (void) user;
    if (level != GP_LEVEL_ERROR && level != GP_LEVEL_BARE)
        return;
    snprintf(heard.line, sizeof heard.line, "%s", line);
    heard.count++;
}

static const struct gp_log hear = {listen, NULL, GP_LEVEL_ERROR};

static gp_status read_file(const char *name, struct gp_frame *f)
{
    const struct gp_read_params p = GP_READ_DEFAULTS;
    heard.line[0] = '\0';
    heard.count = 0;
    *f = (struct gp_frame) {0};
    return gp_read_frame(&hear, &p, name, f);
}

/* One error line, of this status, that says `what`, and no frame. */
static inline void assert_refused(const char *name, gp_status want,
                                  const char *what)
{
    struct gp_frame f;
    assert_int_equal(read_file(name, &f), want);
    assert_int_equal(heard.count, 1);
    assert_non_null(strstr(heard.line, what));
    assert_ptr_equal(strstr(heard.line, name), heard.line);
    assert_non_null(strstr(heard.line, "; ")); // what to do
    assert_null(f.rgb.c[0]);
}

static inline int make_folder(void **state)
{
    return mkdtemp(folder) ? 0 : -1;
}

static inline int remove_folder(void **state)
{
    char command[300];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

#endif
