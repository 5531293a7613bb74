/* Cryptomatte: layers that hold ids of objects as the bits of floats.
 *
 * Such samples are no light. A sum or a mean of two of them is another id, and
 * one bit less is too, so they are never filtered and never stored with loss.
 * Source: Friedman and Jones, "Cryptomatte specification", version 1.2.0: the
 * attribute cryptomatte/HASH/name names a layer NAME, whose ids and coverages
 * are the channels NAME00.R,G,B,A, NAME01.R, ... and whose preview, if there
 * is one, is NAME.R,G,B.
 */
#ifndef GP_IO_CRYPTO_H
#define GP_IO_CRYPTO_H

#include <stdbool.h>
#include <stddef.h>

/* Layers that a file names; more of them are known by their channels' names
 * alone, as in a file that names none. */
enum { GP_CRYPTO_LAYERS = 64 };
struct gp_crypto {
    const char *layer[GP_CRYPTO_LAYERS];  // borrowed from the input
    int n;
};

enum gp_crypto_kind {
    GP_CRYPTO_NONE,
    GP_CRYPTO_PREVIEW,  // a picture of ids, which nothing reads back
    GP_CRYPTO_IDS,
};

/* What the layer of that name of `len` bytes holds. Without an attribute that
 * names it, ids are what begins with "crypto" (any case) behind its last dot
 * and ends with two digits. */
enum gp_crypto_kind gp_crypto_layer(const struct gp_crypto *c,
                                    const char *layer, size_t len);

/* True for channels that are ids by their name alone: CryptoObject00.R. */
bool gp_crypto_like(const char *name);

#endif
