/* Small files for tests of JSON readers, and a log that keeps its last line. */
#ifndef GP_TEST_JSON_FILE_H
#define GP_TEST_JSON_FILE_H

#include "core/status.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char jf_folder[] = "/tmp/glarepp-json-XXXXXX";
static char jf_file[64];
static char jf_line[4096];

static void jf_sink(void *user, enum gp_level level, const char *line)
{
    (void) user;
    (void) level;
    snprintf(jf_line, sizeof jf_line, "%s", line);
}

static const struct gp_log jf_log = {jf_sink, NULL, GP_LEVEL_INFO};

static int jf_setup(void **state)
{
    (void) state;
    if (!mkdtemp(jf_folder))
        return -1;
    snprintf(jf_file, sizeof jf_file, "%s/a.json", jf_folder);
    return 0;
}

static int jf_teardown(void **state)
{
    (void) state;
    unlink(jf_file);
    return rmdir(jf_folder);
}

/* Writes bytes into the one file and gives its path. */
static inline const char *jf_write_bytes(const char *bytes, size_t n)
{
    FILE *f = fopen(jf_file, "wb");
    if (!f || fwrite(bytes, 1, n, f) != n)
        abort();
    fclose(f);
    jf_line[0] = '\0';
    return jf_file;
}

static inline const char *jf_write(const char *text)
{
    return jf_write_bytes(text, strlen(text));
}

#endif
