#include "io/channels.h"

#include "core/parallel.h"
#include "io/half.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

bool gp_channel_list_add(char to[GP_CHANNEL_LIST], const char *part,
                         const char *name)
{
    const size_t used = strlen(to), room = GP_CHANNEL_LIST - used;
    const size_t more = strlen(name) + (part ? strlen(part) : 0);
    if (more + 10 > room) { // two dots and commas, and those of the cut
        snprintf(to + used, room, ", ...");
        return false;
    }
    snprintf(to + used, room, "%s%s%s%s", used ? ", " : "", part ? part : "",
             part ? "." : "", name);
    return true;
}

static int channel_index(const struct gp_frame *f, const char *name)
{
    for (int i = 0; i < f->channels; i++) {
        if (strcmp(f->channel[i].name, name) == 0)
            return i;
    }
    return -1;
}

gp_status gp_find_channel(const struct gp_log *log, const struct gp_frame *f,
                          const char *name, int *out)
{
    char list[GP_CHANNEL_LIST] = "";
    const int at = channel_index(f, name);
    if (at >= 0) {
        *out = at;
        return GP_OK;
    }
    for (int i = 0; i < f->channels; i++) {
        if (!gp_channel_list_add(list, NULL, f->channel[i].name))
            break;
    }
    return gp_fail(log, GP_ERR_USAGE,
                   "%s: has no channel %s (it has %s); give one of those",
                   f->path, name, list);
}

/* -- depth ---------------------------------------------------------------- */

static bool ends_with(const char *s, const char *end)
{
    size_t n = strlen(s), m = strlen(end);
    return n > m && strcmp(s + n - m, end) == 0;
}

/* "layer.Z" of a layer that holds vectors: it has X and Y too, or says so by
 * the last part of its name. */
static bool is_vector(const struct gp_frame *f, const char *name)
{
    static const char *const vector[] = {
        "N",        "normal",   "normals",  "Ng",       "Nn",
        "P",        "Pref",     "Pworld",   "pos",      "position",
        "world",    "velocity", "vector",   "motion",   "motionvector",
        "tangent",  "T",        "dPdu",     "dPdv",     "uv",
        "forward",  "backward", "XYZ",
    };
    char other[256];
    const int layer = (int) (strrchr(name, '.') - name);
    int start = layer;
    while (start > 0 && name[start - 1] != '.')
        start--;
    for (size_t i = 0; i < sizeof vector / sizeof *vector; i++) {
        if (strlen(vector[i]) == (size_t) (layer - start) &&
            strncasecmp(name + start, vector[i], strlen(vector[i])) == 0)
            return true;
    }
    for (const char *axis = "XY"; *axis; axis++) {
        int n = snprintf(other, sizeof other, "%.*s.%c", layer, name, *axis);
        if (n >= (int) sizeof other || channel_index(f, other) < 0)
            return false;
    }
    return true;
}

enum { RANKS = 5 };

/* 0 for the likeliest name of depth; RANKS for what is none. */
static int depth_rank(const struct gp_frame *f, const char *name)
{
    static const char *const exact[] = {"Z", "depth.Z", "Depth.Z"};
    // a part of its own has a layer's channels without the layer's name
    if (strcmp(name, "Z") == 0 && channel_index(f, "X") >= 0 &&
        channel_index(f, "Y") >= 0)
        return RANKS;
    for (int i = 0; i < 3; i++) {
        if (strcmp(name, exact[i]) == 0)
            return i;
    }
    if (ends_with(name, ".Depth.Z"))
        return 3;
    return ends_with(name, ".Z") && !is_vector(f, name) ? 4 : RANKS;
}

gp_status gp_find_depth(const struct gp_log *log, const struct gp_frame *f,
                        const char *name, int *out)
{
    int best = -1, second = -1, best_rank = RANKS;
    if (name)
        return gp_find_channel(log, f, name, out);
    for (int i = 0; i < f->channels; i++) {
        int rank = depth_rank(f, f->channel[i].name);
        if (rank < best_rank) {
            best = i;
            second = -1;
            best_rank = rank;
        } else if (rank == best_rank && rank < RANKS && second < 0) {
            second = i;
        }
    }
    if (second >= 0)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: two channels could be depth (%s and %s); choose "
                       "with --depth", f->path, f->channel[best].name,
                       f->channel[second].name);
    *out = best;
    return GP_OK;
}

/* -- samples -------------------------------------------------------------- */

static void row_to_floats(const struct gp_channel *c, size_t row, float *out)
{
    const size_t w = (size_t) c->w;
    const uint8_t *from =
        (const uint8_t *) c->data + row * w * gp_type_size(c->type);
    if (c->type == GP_HALF) {
        gp_half_to_float((const uint16_t *) (const void *) from, out, w);
        return;
    }
    memcpy(out, from, w * sizeof *out);
    for (size_t x = 0; c->type == GP_UINT && x < w; x++) {
        uint32_t u;
        memcpy(&u, &out[x], sizeof u);
        out[x] = (float) u;
    }
}

/* The sample that covers position `at` >= 0 of a window that begins with a
 * multiple of the sampling, as EXR's do. */
static int sample(int at, int step, int count)
{
    int i = at / step;
    return i < count ? i : count - 1;
}

struct rows {
    const struct gp_frame *f;
    const struct gp_channel *c;
    float *out;
};

static void fill_row(void *ctx, int y, int thread)
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
    row_to_floats(c, (size_t) sample(y, c->ys, c->h), row);
    // from the right, so that no sample is overwritten before its use
    for (int x = w - 1; x >= 0 && c->xs > 1; x--)
        row[x] = row[sample(x, c->xs, c->w)];
}

void gp_channel_floats(const struct gp_frame *f, int channel, float *out)
{
    const struct gp_channel *c = &f->channel[channel];
    struct rows r = {f, c, out};
    if (!c->data || (c->w > 0 && c->h > 0))
        gp_parallel_do(gp_frame_h(f), fill_row, &r);
}
