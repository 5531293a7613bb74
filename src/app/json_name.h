/* Names in JSON, and JSON as text that is whole or is not there. */
#ifndef GP_APP_JSON_NAME_H
#define GP_APP_JSON_NAME_H

#include <jansson.h>

/* A file name or any other bytes: Linux takes what it gets, JSON only UTF-8
 * (RFC 3629). Bytes that are none become U+FFFD. The caller owns it; NULL when
 * memory is full. */
json_t *gp_json_name(const char *s);

/* The text of `o`, which it takes; NULL for a NULL `o` and when memory was
 * full at any time since gp_json_memory_watch(). The caller owns it: free().
 * `flags` as of json_dumps(). */
char *gp_json_print(json_t *o, size_t flags);

#endif
