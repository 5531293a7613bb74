#include "io/crypto.h"

#include "io/colour_name.h"

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

bool gp_crypto_like(const char *name)
{
    const size_t len = gp_layer_length(name);
    return len > 0 && looks_like_ids(name, len - 1);
}
