/* The --hdr output: the frame as it came in, with glare. */
#include "core/memory.h"
#include "io/exr/exr_priv.h"
#include "io/write.h"

#include <string.h>

/* The parts that are made anew. */
struct parts {
    struct gp_exr_sources *sources;  // one for each
    struct gp_exr_part *part;
    int n;
};

static void free_parts(struct parts *s)
{
    for (int i = 0; i < s->n; i++)
        gp_exr_sources_free(&s->sources[i]);
    gp_free(s->sources);
    gp_free(s->part);
}

static bool same_rect(struct gp_rect a, struct gp_rect b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

/* The frames of set[i]'s part, from i on, into `group`; 0 when an earlier one
 * has that part already, -1 when their windows differ. */
static int take_group(const struct gp_hdr_colour *set, int n, int i,
                      struct gp_hdr_colour *group)
{
    int found = 0;
    for (int k = 0; k < n; k++) {
        if (set[k].f->part != set[i].f->part)
            continue;
        if (k < i)
            return 0;
        if (!same_rect(set[k].f->data, set[i].f->data))
            return -1;
        group[found++] = set[k];
    }
    return found;
}

/* A frame of the group must have all channels that the part has. */
static bool is_whole(const struct gp_input *o,
                     const struct gp_hdr_colour *group, int n)
{
    const exr_attr_chlist_t *list;
    if (!o || !o->exr)
        return true;
    if (exr_get_channels(o->exr, group[0].f->part, &list))
        return false;
    for (int i = 0; i < n; i++) {
        if (group[i].f->channels == list->num_channels)
            return true;
    }
    return false;
}

static gp_status make_parts(const struct gp_log *log,
                            const struct gp_write_params *p,
                            const struct gp_hdr_colour *set, int n,
                            struct gp_hdr_colour *group, struct parts *out)
{
    const struct gp_input *o = gp_input_of(set[0].f);
    for (int i = 0; i < n; i++) {
        const int found = take_group(set, n, i, group);
        if (found == 0)
            continue;
        if (found < 0 || !is_whole(o, group, found))
            return gp_fail(log, GP_ERR_BUG, "%s: no frame is the whole part %d",
                           set[i].f->path, set[i].f->part);
        struct gp_exr_sources *s = &out->sources[out->n];
        gp_status st = gp_exr_sources_hdr(log, p, group, found, s);
        if (st)
            return st;
        out->part[out->n++] =
            (struct gp_exr_part) {set[i].f, s->source, s->sources};
    }
    return GP_OK;
}

/* Ids with one bit less are other ids. A compression that would do that was
 * asked for: AUTO loses nothing. */
static gp_status check_ids(const struct gp_log *log,
                           const struct gp_write_params *p, const char *path,
                           const struct parts *parts)
{
    struct gp_crypto crypto;
    for (int i = 0; i < parts->n; i++) {
        const struct gp_exr_part *part = &parts->part[i];
        const struct gp_input *o = gp_input_of(parts->part[0].f);
        gp_exr_crypto(o, &crypto);
        for (int k = 0; k < part->sources; k++) {
            const struct gp_exr_source *s = &part->source[k];
            if (s->data && gp_exr_loses(p->compression, s->type, s->name) &&
                gp_exr_crypto_channel(&crypto, o, part->f->part, s->name) ==
                    GP_CRYPTO_IDS)
                return gp_fail(log, GP_ERR_USAGE,
                               "%s: this compression would change the "
                               "Cryptomatte ids of %s (channel %s); use "
                               "--compression zip", path, part->f->path,
                               s->name);
        }
    }
    return GP_OK;
}

gp_status gp_exr_write_hdr(const struct gp_log *log,
                           const struct gp_write_params *p, const char *path,
                           const struct gp_hdr_colour *set, int n,
                           struct gp_write_stats *stats)
{
    struct parts parts = {0};
    void *sources = NULL, *part = NULL, *group = NULL;
    gp_status st;
    GP_TRY(gp_alloc_zero(log, "parts", (size_t) n, sizeof *parts.sources,
                         &sources));
    parts.sources = sources;
    GP_TRY(gp_alloc_zero(log, "parts", (size_t) n, sizeof *parts.part, &part));
    parts.part = part;
    GP_TRY(gp_alloc(log, "parts", (size_t) n, sizeof *set, &group));
    GP_TRY(make_parts(log, p, set, n, group, &parts));
    GP_TRY(check_ids(log, p, path, &parts));
    const struct gp_exr_job job = {
        .p = p, .path = path, .part = parts.part, .parts = parts.n,
        .kept = p->converted ? GP_EXR_KEEP_CONVERTED : GP_EXR_KEEP_ALL,
    };
    GP_TRY(gp_exr_write_file(log, &job, stats));
out:
    gp_free(group);
    free_parts(&parts);
    return st;
}
