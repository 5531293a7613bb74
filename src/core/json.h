/* JSON as jansson makes it, of strings that need not be UTF-8. */
#ifndef GP_CORE_JSON_H
#define GP_CORE_JSON_H

#include <jansson.h>

/* A file name or any other bytes: Linux allows any, JSON only UTF-8
 * (RFC 3629). Bytes that are not UTF-8 become U+FFFD. The caller owns it; NULL
 * when memory is full. */
json_t *gp_json_name(const char *s);

/* The text of `o`, whose reference it takes; NULL for a NULL `o` and when
 * memory is full. The caller owns it: free(). `flags` as of json_dumps(). */
char *gp_json_print(json_t *o, size_t flags);

#endif
