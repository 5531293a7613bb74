// SPDX-License-Identifier: Apache-2.0
#include "io/channels.h"

#include "core/bytes.h"
#include "core/parallel.h"
#include "core/half.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* -- names ---------------------------------------------------------------- */

size_t gp_layer_length(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot ? (size_t) (dot - name) + 1 : 0;
}

void gp_channel_list_add(char to[GP_CHANNEL_LIST], const char *part,
                         const char *name)
{
    const size_t used = strlen(to), room = GP_CHANNEL_LIST - used;
    const size_t more = strlen(name) + (part ? strlen(part) : 0);
    if (used >= 3 && strcmp(to + used - 3, "...") == 0)
        return;
    if (more + 10 > room) // two dots and commas, and those of the cut
        snprintf(to + used, room, ", ...");
    else
        snprintf(to + used, room, "%s%s%s%s", used ? ", " : "",
                 part ? part : "", part ? "." : "", name);
}

size_t gp_last_part(const char *name, size_t n)
{
    while (n > 0 && name[n - 1] != '.')
        n--;
    return n;
}

/* -- Cryptomatte ---------------------------------------------------------- */

enum { DIGITS = 2 }; // of a layer's rank

static bool ends_with_rank(const char *layer, size_t len)
{
    static const char digits[] = "0123456789";
    return len > DIGITS && strchr(digits, layer[len - 1]) &&
           strchr(digits, layer[len - 2]);
}

static bool looks_like_ids(const char *layer, size_t len)
{
    static const char word[] = "crypto";
    const size_t start = gp_last_part(layer, len);
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

/* True for channels that are ids by their name: CryptoObject00.R. */
static bool named_like_ids(const char *name)
{
    const size_t len = gp_layer_length(name);
    return len > 0 && looks_like_ids(name, len - 1);
}

/* -- depth by name -------------------------------------------------------- */

/* True for a layer whose name, after its last dot, is one of `n`: words in any
 * case, letters as they are. */
static bool is_called(const char *layer, size_t len, const char *const *name,
                      size_t n)
{
    const size_t start = gp_last_part(layer, len);
    for (size_t i = 0; i < n; i++) {
        if (strlen(name[i]) == len - start &&
            (name[i][1] ? strncasecmp : strncmp)(layer + start, name[i],
                                                 len - start) == 0)
            return true;
    }
    return false;
}

bool gp_is_mist(const char *layer, size_t len)
{
    return is_called(layer, len, (const char *const[]) {"mist"}, 1);
}

static bool is_vector(const char *layer, size_t len)
{
    static const char *const vector[] = {
        "N",        "normal",   "normals",  "Ng",       "Nn",
        "P",        "Pref",     "Pworld",   "pos",      "position",
        "world",    "velocity", "vector",   "motion",   "motionvector",
        "tangent",  "T",        "dPdu",     "dPdv",     "uv",
        "forward",  "backward", "XYZ",
    };
    return is_called(layer, len, vector, sizeof vector / sizeof *vector);
}

/* True where a word of a layer's name, after its last dot, means depth:
 * AOV_depth, camera-z, DepthNormalized. Words begin after a mark and at a
 * capital after a small letter. One letter alone is a layer's name. */
static bool has_depth_word(const char *layer, size_t len)
{
    static const char *const depth[] = {
        "depth", "zdepth", "z", "zbuf", "zbuffer", "distance", "disparity",
    };
    const size_t first = gp_last_part(layer, len);
    for (size_t start = first, end; start < len; start = end + 1) {
        for (end = start; end < len; end++) {
            const unsigned char c = (unsigned char) layer[end];
            if (!isalpha(c) || (isupper(c) && end > start &&
                                islower((unsigned char) layer[end - 1])))
                break;
        }
        for (size_t i = 0; i < sizeof depth / sizeof *depth; i++) {
            if (strlen(depth[i]) == end - start && len - first > 1 &&
                strncasecmp(layer + start, depth[i], end - start) == 0)
                return true;
        }
        // a capital begins the next word, a mark does not
        end -= end < len && isupper((unsigned char) layer[end]);
    }
    return false;
}

bool gp_is_light(const char *layer, size_t len)
{
    static const char *const data[] = {
        "Z",          "mist",        "id",         "mask",
        "matte",      "opacity",     "coverage",   "indexob",
        "indexma",    "zback",       "deepid",     "objectid",
        "object_id",  "materialid",  "material_id", "instanceid",
        "instance_id", "assetid",    "asset_id",   "primid",
        "prim_id",
    };
    return !is_vector(layer, len) && !has_depth_word(layer, len) &&
           !is_called(layer, len, data, sizeof data / sizeof *data);
}

/* True for the Z of vectors, by X and Y beside it or its layer, and of mist. */
static bool is_no_depth(const struct gp_channel *channel, int n,
                        const char *name)
{
    bool has[2] = {false, false};
    const size_t with_dot = gp_layer_length(name);
    const size_t layer = with_dot ? with_dot - 1 : 0;
    if (is_vector(name, layer) || gp_is_mist(name, layer))
        return true;
    for (int i = 0; i < n; i++) {
        const char *const own = channel[i].name;
        for (int axis = 0; axis < 2; axis++)
            has[axis] |= strncmp(own, name, with_dot) == 0 &&
                         strcmp(own + with_dot, axis ? "Y" : "X") == 0;
    }
    return has[0] && has[1];
}

enum { RANKS = 5 };

/* 0 for the likeliest name of depth; RANKS for what is none. The first `skip`
 * bytes are those of a layer that it is in with the colour. */
static int depth_rank(const struct gp_channel *channel, int channels,
                      const char *name, size_t skip)
{
    static const char *const names[RANKS] = {"Z", "depth.Z", "Depth.Z",
                                             ".Depth.Z", ".Z"};
    const char *const own = name + skip;
    const size_t n = strlen(own);
    int rank = 0;
    for (; rank < RANKS; rank++) { // the last two are endings
        const size_t k = strlen(names[rank]);
        if ((rank < 3 ? n == k : n > k) &&
            strcmp(own + n - k, names[rank]) == 0)
            break;
    }
    return (rank == 0 || rank == 4) && is_no_depth(channel, channels, name)
               ? RANKS : rank;
}

/* True for a channel that is no light by its own name or its layer's. */
static bool is_data(const char *name)
{
    const size_t layer = gp_layer_length(name);
    const char *const own = name + layer;
    return strcmp(own, "A") == 0 || strcasecmp(own, "alpha") == 0 ||
           strcasecmp(own, "z") == 0 || !gp_is_light(own, strlen(own)) ||
           (layer > 0 && !gp_is_light(name, layer - 1)) ||
           named_like_ids(name) ||
           // depth, in a file without vectors
           depth_rank(NULL, 0, name, 0) < RANKS;
}

/* -- colour --------------------------------------------------------------- */

static const char letters[3] = {'R', 'G', 'B'};
static const char *const words[3] = {"red", "green", "blue"};

/* The channel named by `len` bytes of `layer`, then `last`; -1: none. */
static int find_exact(const char *const *name, int n, const char *layer,
                      size_t len, const char *last)
{
    for (int i = 0; i < n; i++) {
        if (strncmp(name[i], layer, len) == 0 &&
            strcmp(name[i] + len, last) == 0)
            return i;
    }
    return -1;
}

/* Finds the members of a set of three in a layer; returns how many. */
static int find_three(const char *const *name, int n, const char *layer,
                      size_t len, int index[3])
{
    int letter[3] = {-1, -1, -1}, word[3] = {-1, -1, -1}, found[2] = {0, 0};
    for (int i = 0; i < n; i++) {
        if (strncmp(name[i], layer, len) != 0)
            continue;
        const char *const last = name[i] + len;
        const bool one = last[0] && !last[1];
        for (int c = 0; c < 3; c++) {
            int *const at = one ? &letter[c] : &word[c];
            if (*at < 0 && (one ? last[0] == letters[c]
                                : (last[0] | 32) == words[c][0] &&
                                  strcasecmp(last, words[c]) == 0)) {
                *at = i;
                found[one]++;
            }
        }
    }
    const bool by_letter = found[1] == 3 || (found[1] > 0 && found[0] < 3);
    memcpy(index, by_letter ? letter : word, sizeof letter);
    return found[by_letter];
}

static bool choose_grey(int channel, struct gp_colour_choice *out)
{
    *out = (struct gp_colour_choice) {GP_COLOUR_GREY, {channel, -1, -1}};
    return channel >= 0;
}

/* A set in one layer, or the channels without one where `len` is 0. */
static bool find_set(const char *const *name, int n, const char *layer,
                     size_t len, struct gp_colour_choice *out)
{
    struct gp_colour_choice rgb = {.model = GP_COLOUR_RGB};
    int y = find_exact(name, n, layer, len, "Y");
    int ry = find_exact(name, n, layer, len, "RY");
    int by = find_exact(name, n, layer, len, "BY");
    if (find_three(name, n, layer, len, rgb.index) > 0) {
        *out = rgb;
        return true;
    }
    if (y >= 0 && (ry >= 0 || by >= 0)) {
        *out = (struct gp_colour_choice) {GP_COLOUR_YC, {ry, y, by}};
        return true;
    }
    return choose_grey(y, out);
}

bool gp_find_colour(const char *const *name, int n, bool lone,
                    struct gp_colour_choice *out)
{
    static const char *const pictures[] = {"combined", "beauty", "rgba"};
    const char *last = "";
    size_t last_len = 0;
    bool found = false;
    if (find_set(name, n, "", 0, out))
        return true;
    // the first layer that has all three, or the first such picture
    for (int i = 0; i < n; i++) {
        const size_t len = gp_layer_length(name[i]);
        if (!len || named_like_ids(name[i]) || !gp_is_light(name[i], len - 1))
            continue;
        if (len == last_len && strncmp(name[i], last, len) == 0)
            continue;
        last = name[i];
        last_len = len;
        const bool picture = is_called(last, len - 1, pictures,
                                       sizeof pictures / sizeof *pictures);
        int at[3];
        if ((found && !picture) || find_three(name, n, name[i], len, at) < 3)
            continue;
        *out = (struct gp_colour_choice) {GP_COLOUR_RGB,
                                          {at[0], at[1], at[2]}};
        found = true;
        if (picture)
            break;
    }
    if (found)
        return true;

    // the only channel
    int only = -1;
    for (int i = 0; i < n && lone; i++) {
        if (!name[i][0] || is_data(name[i]))
            continue;
        if (only >= 0)
            return false;
        only = i;
    }
    return choose_grey(only, out);
}

bool gp_find_layer_colour(const char *const *name, int n, const char *layer,
                          bool lone, struct gp_colour_choice *out)
{
    char start[GP_CHANNEL_NAME + 2] = "";
    const size_t len = strlen(layer);
    if (len > GP_CHANNEL_NAME)
        return false;
    if (lone)
        return len > 0 && choose_grey(find_exact(name, n, "", 0, layer), out);
    if (len > 0)
        snprintf(start, sizeof start, "%s.", layer);
    return find_set(name, n, start, strlen(start), out);
}

char *gp_colour_name(const char *name, int c)
{
    static const char *const spelling[][3] = {
        {"R", "G", "B"},
        {"red", "green", "blue"},
        {"Red", "Green", "Blue"},
        {"RED", "GREEN", "BLUE"},
    };
    const size_t layer = gp_layer_length(name);
    const char *own = name + layer, *want = spelling[0][c];
    for (size_t i = 0; i < sizeof spelling / sizeof *spelling; i++) {
        for (int k = 0; k < 3; k++) {
            if (strcmp(own, spelling[i][k]) == 0)
                want = spelling[i][c];
        }
    }
    char *const full = malloc(layer + strlen(want) + 1);
    if (full) {
        memcpy(full, name, layer);
        strcpy(full + layer, want);
    }
    return full;
}

int gp_find_alpha(const struct gp_frame *f)
{
    const char *const colour = gp_frame_colour(f);
    if (!colour)
        return -1;
    const size_t layer = gp_layer_length(colour);
    for (int i = 0; i < f->channels; i++) {
        const char *name = f->channel[i].name;
        if (f->channel[i].colour < 0 && strncmp(name, colour, layer) == 0 &&
            (strcmp(name + layer, "A") == 0 ||
             strcasecmp(name + layer, "alpha") == 0))
            return i;
    }
    return -1;
}

/* -- depth ---------------------------------------------------------------- */

bool gp_channel_is_depth(const struct gp_frame *f, int channel)
{
    return depth_rank(f->channel, f->channels, f->channel[channel].name, 0) <
           RANKS;
}

gp_status gp_find_depth(const struct gp_log *log, const char *path,
    const struct gp_channel *channel, int n, const char *colour, int *out)
{
    int best = -1, second = -1, best_rank = RANKS;
    size_t skip = colour ? gp_layer_length(colour) : 0;
    // in the colour's layer, in the layer around it, ..., anywhere
    for (bool last = false; best < 0 && !last;) {
        last = skip == 0;
        for (int i = 0; i < n; i++) {
            const char *const own = channel[i].name;
            if (skip && strncmp(own, colour, skip) != 0)
                continue;
            const int rank = depth_rank(channel, n, own, skip);
            if (rank < best_rank) {
                best = i;
                second = -1;
                best_rank = rank;
            } else if (rank == best_rank && rank < RANKS && second < 0) {
                second = i;
            }
        }
        skip = skip ? gp_last_part(colour, skip - 1) : 0;
    }
    if (second >= 0)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: two channels could be depth (%s and %s); choose "
                       "with --depth", path, channel[best].name,
                       channel[second].name);
    *out = best;
    return GP_OK;
}

/* -- samples -------------------------------------------------------------- */

struct rows {
    const struct gp_frame *f;
    const struct gp_channel *c;
    float *out;
};

static void float_row(void *ctx, int y, int thread)
{
    (void) thread;
    const struct rows *r = ctx;
    const struct gp_channel *c = r->c;
    const int w = gp_frame_w(r->f);
    float *row = r->out + (size_t) y * (size_t) w;
    if (!c->data) {
        memcpy(row, r->f->rgb.c[c->colour] + (size_t) y * (size_t) w,
               (size_t) w * sizeof *row);
        return;
    }
    // sampled from the window's start; the last sample also covers the rest
    const size_t n = (size_t) c->w;
    const int line = y / c->ys < c->h ? y / c->ys : c->h - 1;
    const uint8_t *const from = (const uint8_t *) c->data +
                                (size_t) line * n * gp_type_size(c->type);
    if (c->type == GP_HALF)
        gp_half_to_float((const uint16_t *) (const void *) from, row, n);
    else
        memcpy(row, from, n * sizeof *row);
    for (size_t x = 0; c->type == GP_UINT && x < n; x++)
        row[x] = (float) gp_bits_of(row[x]);
    // from the right, so that no sample is overwritten before its use
    for (int x = w - 1; x >= 0 && c->xs > 1; x--)
        row[x] = row[x / c->xs < c->w ? x / c->xs : c->w - 1];
}

void gp_channel_floats(const struct gp_frame *f, int channel, float *out)
{
    const struct gp_channel *c = &f->channel[channel];
    struct rows r = {f, c, out};
    if (!c->data || (c->w > 0 && c->h > 0))
        gp_parallel_do(gp_frame_h(f), float_row, &r);
}
