#include "io/crypto.h"

#include "io/colour_name.h"
#include "io/exr/origin.h"
#include "io/exr/view.h"

#include <string.h>
#include <strings.h>

enum { DIGITS = 2 }; // of a layer's rank

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static bool ends_with_rank(const char *layer, size_t len)
{
    return len > DIGITS && is_digit(layer[len - 1]) && is_digit(layer[len - 2]);
}

/* cryptomatte/HASH/name */
static bool names_layer(const exr_attribute_t *a)
{
    static const char first[] = "cryptomatte/", last[] = "/name";
    const size_t len = strlen(a->name), end = sizeof last - 1;
    return a->type == EXR_ATTR_STRING && len > sizeof first - 1 + end &&
           strncmp(a->name, first, sizeof first - 1) == 0 &&
           strcmp(a->name + len - end, last) == 0;
}

void gp_crypto_find(const struct gp_origin *o, struct gp_crypto *out)
{
    *out = (struct gp_crypto) {0};
    for (int part = 0; o && o->exr && part < o->parts; part++) {
        int32_t n = 0;
        if (exr_get_attribute_count(o->exr, part, &n))
            continue;
        for (int32_t i = 0; i < n && out->n < GP_CRYPTO_LAYERS; i++) {
            const exr_attribute_t *a;
            if (!exr_get_attribute_by_index(o->exr, part,
                                            EXR_ATTR_LIST_FILE_ORDER, i, &a) &&
                names_layer(a) && a->string->str && a->string->str[0])
                out->layer[out->n++] = a->string->str;
        }
    }
}

static bool looks_like_ids(const char *layer, size_t len)
{
    static const char word[] = "crypto";
    size_t start = len;
    while (start > 0 && layer[start - 1] != '.')
        start--;
    return ends_with_rank(layer, len) &&
           len - start >= sizeof word - 1 + DIGITS &&
           strncasecmp(layer + start, word, sizeof word - 1) == 0;
}

enum gp_crypto_kind gp_crypto_layer(const struct gp_crypto *c,
                                    const char *layer, size_t len)
{
    bool preview = false;
    for (int i = 0; i < c->n; i++) {
        const size_t n = strlen(c->layer[i]);
        if (n > len || strncmp(c->layer[i], layer, n) != 0)
            continue;
        if (n + DIGITS == len && ends_with_rank(layer, len))
            return GP_CRYPTO_IDS;
        preview |= n == len;
    }
    if (looks_like_ids(layer, len))
        return GP_CRYPTO_IDS;
    return preview ? GP_CRYPTO_PREVIEW : GP_CRYPTO_NONE;
}

enum gp_crypto_kind gp_crypto_channel(const struct gp_crypto *c,
                                      const struct gp_origin *o, int part,
                                      const char *name)
{
    size_t len = gp_layer_length(name);
    if (len > 0)
        return gp_crypto_layer(c, name, len - 1);
    if (!o || !o->exr)
        return GP_CRYPTO_NONE;
    const char *layer;
    len = gp_exr_part_layer(o, part, &layer);
    return gp_crypto_layer(c, layer, len);
}

bool gp_crypto_like(const char *name)
{
    const size_t len = gp_layer_length(name);
    return len > 0 && looks_like_ids(name, len - 1);
}
