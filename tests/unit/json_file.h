// SPDX-License-Identifier: Apache-2.0
/* Small files for tests of JSON readers. Their log is kept_log.h's. */
#ifndef GP_TEST_JSON_FILE_H
#define GP_TEST_JSON_FILE_H

#include "folder.h"
#include "kept_log.h"
#include "unit.h"

/* Writes bytes into the one file, a.json, and returns its path. */
static inline const char *jf_write_bytes(const char *bytes, size_t n)
{
    FILE *f = fopen(in_folder("a.json"), "wb");
    if (!f || fwrite(bytes, 1, n, f) != n)
        abort();
    fclose(f);
    kept_clear();
    return path;
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
    return path;
}

#endif
