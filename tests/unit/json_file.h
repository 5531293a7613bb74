/* Small files for tests of JSON readers. Their log is said.h's. */
#ifndef GP_TEST_JSON_FILE_H
#define GP_TEST_JSON_FILE_H

#include "unit.h"

#include "said.h"

#include <unistd.h>

static char jf_folder[] = "/tmp/glarepp-json-XXXXXX";
static char jf_file[64];

static int jf_setup(void **state)
{
    if (!mkdtemp(jf_folder))
        return -1;
    snprintf(jf_file, sizeof jf_file, "%s/a.json", jf_folder);
    return 0;
}

static int jf_teardown(void **state)
{
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
    said_nothing();
    return jf_file;
}

/* The same of a text, where ' stands for ". */
static inline const char *jf_write(const char *text)
{
    char *const quoted = strdup(text);
    if (!quoted)
        abort();
    for (char *c = quoted; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    jf_write_bytes(quoted, strlen(quoted));
    free(quoted);
    return jf_file;
}

#endif
