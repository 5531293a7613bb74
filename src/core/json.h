// SPDX-License-Identifier: Apache-2.0
/* JSON by jansson. Reads files strictly: every key is known, every number has a
 * range, and messages name the file, the place ("element 3") and the key. Makes
 * JSON of strings that need not be UTF-8. */
#ifndef GP_CORE_JSON_H
#define GP_CORE_JSON_H

#include "core/status.h"

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

/* Has gp_json_print() see what jansson could not allocate. jansson's allocator is
 * the process's: for programs, before any value is made. */
void gp_json_watch_memory(void);

/* A file name or any other bytes: Linux allows any, JSON only UTF-8
 * (RFC 3629). Bytes that are not UTF-8 become U+FFFD. The caller owns it; NULL
 * when memory is full, or was for `s`, which is NULL then. */
json_t *gp_json_name(const char *s);

/* Returns the text of `o`, whose reference it takes; NULL for a NULL `o`, and
 * when memory was full for any value made on this thread since the last text, as
 * gp_json_watch_memory() sees: calls that build `o` need no check. The caller frees it by free(). `flags`
 * are those of json_dumps(). */
char *gp_json_print(json_t *o, size_t flags);

/* The place of a value, for messages. */
struct gp_json_place {
    const struct gp_log *log;
    const char *path;  // file
    const char *what;  // "light", "element", "frame"
    int index;         // from 1; -1 - N: N, counted from 0; 0: the file itself
};

/* Prints "lights.json: light 3: TEXT", or "lights.json: TEXT"; returns
 * GP_ERR_DATA. */
gp_status gp_json_fail(const struct gp_json_place *p, const char *fmt, ...)
    GP_PRINTF(2, 3);

/* Opens a regular file to be read; never waits, as it would for a FIFO.
 *   fd    written on GP_OK only; close()
 *   size  of the file in bytes; written on GP_OK only
 * Errors: GP_ERR_IO cannot be opened, is a folder; GP_ERR_DATA a FIFO, device
 * or socket. */
GP_MUST_CHECK gp_status gp_open_regular(const struct gp_log *log,
    const char *path, int *fd, uint64_t *size);

/* Reads the first bytes of such a file, all that it has or `most`, and ends them
 * with a null byte.
 *   out   written on GP_OK only; gp_free()
 *   size  of the file in bytes; more than `most`: the rest is not read
 * Errors: those of gp_open_regular(); GP_ERR_IO cannot be read, shrank
 * meanwhile; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_load_regular(const struct gp_log *log,
    const char *path, size_t most, void **out, uint64_t *size);

/* Reads a regular file of at most `most` bytes. Duplicate keys are refused. Every
 * number is read as a JSON_REAL, so that long integers (ids of
 * other programs) are no error. A byte order mark before the text is skipped.
 * Memory may reach 80 times the file's size.
 *   out  written on GP_OK only; json_decref()
 * Errors: those of gp_load_regular(); GP_ERR_DATA too large, or not JSON (line
 * and column). */
enum { GP_JSON_SMALL = 1 << 20 }; // bytes
GP_MUST_CHECK gp_status gp_json_read(const struct gp_log *log, const char *path,
                                     size_t most, json_t **out);

/* The same of text in memory, the JSON of a file of another kind, which `path`
 * names in messages. Errors: GP_ERR_DATA; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_json_parse(const struct gp_log *log,
    const char *path, const char *text, size_t bytes, json_t **out);

/* Returns about how many bytes of memory gp_json_parse() would take for a text,
 * rather more, by the characters that begin values (jansson 2.14 with 64 bits:
 * an empty object has 228, an array 134, a key and its number 120). */
size_t gp_json_memory(const char *text, size_t bytes);

/* The array that a file holds: itself, or value `key` of its object, whose
 * other keys are left to gp_json_keys(). *out is borrowed from root.
 * Errors: GP_ERR_DATA neither, or more than `most` items. */
GP_MUST_CHECK gp_status gp_json_array(const struct gp_json_place *p,
    json_t *root, const char *key, size_t most, json_t **out);

/* Checks that all keys of `o` are among `keys` (NULL ends).
 * Errors: GP_ERR_DATA `o` is no object, or has another key; the message lists
 * `keys`. */
GP_MUST_CHECK gp_status gp_json_keys(const struct gp_json_place *p, json_t *o,
                                     const char *const keys[]);

/* Values of a key: `out` stays as it is when the key is missing. Numbers are
 * finite and within [lo, hi]; ints are whole.
 * Errors: GP_ERR_DATA with file, place, key, what was found, the range. */
GP_MUST_CHECK gp_status gp_json_number(const struct gp_json_place *p, json_t *o,
    const char *key, double lo, double hi, double *out);
GP_MUST_CHECK gp_status gp_json_int(const struct gp_json_place *p, json_t *o,
    const char *key, int lo, int hi, int *out);

/* `count` numbers; where that is negative, -count of them, or one for all. */
GP_MUST_CHECK gp_status gp_json_numbers(const struct gp_json_place *p,
    json_t *o, const char *key, int count, double lo, double hi, double *out);

/* Borrowed from o. */
GP_MUST_CHECK gp_status gp_json_text(const struct gp_json_place *p, json_t *o,
    const char *key, const char **out);

/* Index into `names` (NULL ends) of a text. */
GP_MUST_CHECK gp_status gp_json_choice(const struct gp_json_place *p, json_t *o,
    const char *key, const char *const names[], int *out);

#endif
