/* Names in JSON. */
#ifndef GP_APP_JSON_NAME_H
#define GP_APP_JSON_NAME_H

#include <jansson.h>

/* A file name or any other bytes: Linux takes what it gets, JSON only UTF-8
 * (RFC 3629). Bytes that are none become U+FFFD. The caller owns it; NULL when
 * memory is full. */
json_t *gp_json_name(const char *s);

#endif
