#include "io/colour.h"

#include "io/crypto.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

static const char *const letters[3] = {"R", "G", "B"};
static const char *const words[3] = {"red", "green", "blue"};

/* The channel that is called `last` behind the first `len` bytes of `layer`. */
static int find(const char *const *name, int n, const char *layer, size_t len,
                const char *last)
{
    for (int i = 0; i < n; i++) {
        if (strncmp(name[i], layer, len) == 0 &&
            strcmp(name[i] + len, last) == 0)
            return i;
    }
    return -1;
}

/* The channel whose name is the first `len` bytes of `layer` and then `last`;
 * a letter as it is, a word in any case. */
static int find_in_layer(const char *const *name, int n, const char *layer,
                         size_t len, const char *last)
{
    for (int i = 0; i < n; i++) {
        if (strncmp(name[i], layer, len) != 0)
            continue;
        const char *rest = name[i] + len;
        if (last[1] ? strcasecmp(rest, last) == 0 : strcmp(rest, last) == 0)
            return i;
    }
    return -1;
}

/* How many of a set of three there are; `layer` ends with a dot or is "". */
static int find_three(const char *const *name, int n, const char *layer,
                      size_t len, const char *const last[3], int index[3])
{
    int found = 0;
    for (int c = 0; c < 3; c++) {
        index[c] = find_in_layer(name, n, layer, len, last[c]);
        found += index[c] >= 0;
    }
    return found;
}

/* The last part of a layer's name of `len` bytes, which ends with a dot. */
static bool is_picture(const char *layer, size_t len)
{
    static const char *const picture[] = {"combined", "beauty", "rgba"};
    const size_t end = len - 1;
    size_t start = end;
    while (start > 0 && layer[start - 1] != '.')
        start--;
    for (size_t i = 0; i < sizeof picture / sizeof *picture; i++) {
        if (strlen(picture[i]) == end - start &&
            strncasecmp(layer + start, picture[i], end - start) == 0)
            return true;
    }
    return false;
}

/* Whether the names that are not empty ascend, as an EXR's own do. */
static bool ascend(const char *const *name, int n)
{
    const char *last = "";
    for (int i = 0; i < n; i++) {
        if (!name[i][0])
            continue;
        if (strcmp(last, name[i]) > 0)
            return false;
        last = name[i];
    }
    return true;
}

/* All three of a layer, whose first channel is name[i]. Those of a list that
 * ascends stand together: a file may have thousands of layers. */
static bool find_all(const char *const *name, int n, int i, size_t len,
                     bool ascending, int index[3])
{
    const char *const layer = name[i];
    int letter[3] = {-1, -1, -1}, word[3] = {-1, -1, -1};
    for (; i < n; i++) {
        if (strncmp(name[i], layer, len) != 0) {
            if (ascending && name[i][0])
                break;
            continue;
        }
        for (int c = 0; c < 3; c++) {
            if (letter[c] < 0 && strcmp(name[i] + len, letters[c]) == 0)
                letter[c] = i;
            if (word[c] < 0 && strcasecmp(name[i] + len, words[c]) == 0)
                word[c] = i;
        }
    }
    const bool by_letter = letter[0] >= 0 && letter[1] >= 0 && letter[2] >= 0;
    memcpy(index, by_letter ? letter : word, sizeof letter);
    return index[0] >= 0 && index[1] >= 0 && index[2] >= 0;
}

static bool find_layer(const char *const *name, int n, int index[3])
{
    const bool ascending = ascend(name, n);
    const char *last = ""; // with the layer that was looked at last
    size_t last_len = 0;
    bool found = false;
    for (int i = 0; i < n; i++) {
        const char *dot = strrchr(name[i], '.');
        if (!dot || gp_crypto_like(name[i]))
            continue;
        size_t len = (size_t) (dot - name[i]) + 1;
        if (len == last_len && strncmp(name[i], last, len) == 0)
            continue;
        last = name[i];
        last_len = len;
        bool picture = is_picture(name[i], len);
        int at[3];
        if ((found && !picture) ||
            !find_all(name, n, i, len, ascending, at))
            continue;
        memcpy(index, at, sizeof at);
        found = true;
        if (picture)
            break;
    }
    return found;
}

static bool is_alpha(const char *name)
{
    const char *dot = strrchr(name, '.');
    const char *last = dot ? dot + 1 : name;
    return strcmp(last, "A") == 0 || strcasecmp(last, "alpha") == 0;
}

static int find_lone(const char *const *name, int n)
{
    int lone = -1;
    for (int i = 0; i < n; i++) {
        if ((n > 1 && is_alpha(name[i])) || !name[i][0] ||
            gp_crypto_like(name[i]))
            continue;
        if (lone >= 0)
            return -1;
        lone = i;
    }
    return lone;
}

static bool grey(int channel, struct gp_colour_choice *out)
{
    *out = (struct gp_colour_choice) {GP_COLOUR_GREY, {channel, -1, -1}};
    return channel >= 0;
}

/* A set in one layer, or the channels without one where `len` is 0. */
static bool find_set(const char *const *name, int n, const char *layer,
                     size_t len, struct gp_colour_choice *out)
{
    struct gp_colour_choice rgb = {.model = GP_COLOUR_RGB};
    int y = find(name, n, layer, len, "Y");
    int ry = find(name, n, layer, len, "RY");
    int by = find(name, n, layer, len, "BY");
    if (find_three(name, n, layer, len, letters, rgb.index) ||
        find_three(name, n, layer, len, words, rgb.index)) {
        *out = rgb;
        return true;
    }
    if (y >= 0 && (ry >= 0 || by >= 0)) {
        *out = (struct gp_colour_choice) {GP_COLOUR_YC, {ry, y, by}};
        return true;
    }
    return grey(y, out);
}

bool gp_find_colour(const char *const *name, int n, bool lone,
                    struct gp_colour_choice *out)
{
    struct gp_colour_choice rgb = {.model = GP_COLOUR_RGB};
    if (find_set(name, n, "", 0, out))
        return true;
    if (find_layer(name, n, rgb.index)) {
        *out = rgb;
        return true;
    }
    return lone && grey(find_lone(name, n), out);
}

bool gp_find_layer_colour(const char *const *name, int n, const char *layer,
                          bool lone, struct gp_colour_choice *out)
{
    char start[GP_CHANNEL_NAME + 2] = "";
    const size_t len = strlen(layer);
    if (len > GP_CHANNEL_NAME)
        return false;
    if (lone)
        return len > 0 && grey(find(name, n, "", 0, layer), out);
    if (len > 0)
        snprintf(start, sizeof start, "%s.", layer);
    return find_set(name, n, start, strlen(start), out);
}
