/* Writes one EXR file: its parts, their headers and chunks. */
#include "io/exr/exr_priv.h"

#include "core/bytes.h"
#include "core/memory.h"
#include "io/channels.h"

#include <string.h>

/* -- compressions --------------------------------------------------------- */

bool gp_exr_loses(enum gp_compression compression, enum gp_pixel_type type,
                  const char *name)
{
    static const char *const dwa[] = {"R", "G", "B", "Y", "RY", "BY"};
    const char *last = name + gp_layer_length(name);
    bool colour = false;
    switch (compression) {
    case GP_COMPRESSION_PXR24:
        return type == GP_FLOAT;
    case GP_COMPRESSION_B44:
    case GP_COMPRESSION_B44A:
        return type == GP_HALF;
    case GP_COMPRESSION_DWAA:
    case GP_COMPRESSION_DWAB:
        for (size_t i = 0; i < sizeof dwa / sizeof *dwa; i++)
            colour = colour || strcmp(last, dwa[i]) == 0;
        return type != GP_UINT && colour;
    default:
        return false;
    }
}

/* -- a file on its way ---------------------------------------------------- */

/* A part that gets a new header and new chunks. */
struct new_part {
    const struct gp_frame *f; // its windows and number
    struct gp_exr_sources sources;
    struct gp_exr_image img;
    const struct gp_exr_index_part *own; // of the input, or NULL
};

/* All that is open at once, closed in one place. */
struct writing {
    const struct gp_log *log;
    const struct gp_write_params *p;
    const char *path;
    enum gp_exr_kept kept;
    struct new_part *part; // no number twice; the first frame's input is the
    int parts;             // input of all
    struct new_part **at;  // for each part of the file; NULL: carried
    int *chunks;           // of each part of the file
    int file_parts;
    bool all; // the input's other parts, and its part's name, go along
    struct gp_exr_out out;
    struct gp_file *file;
};

/* Finds the parts of the file, their compression, and how many chunks each
 * has. */
static gp_status plan_parts(struct writing *w, const struct gp_input *in)
{
    const char *const from = w->part[0].f->path;
    const bool all = in && (w->kept == GP_EXR_KEEP_ALL ||
                            w->kept == GP_EXR_KEEP_CONVERTED);
    gp_status st;
    w->all = all;
    w->file_parts = all ? in->parts : 1;
    GP_TRY(gp_alloc_zero(w->log, "parts", (size_t) w->file_parts,
                         sizeof *w->at, &w->at));
    GP_TRY(gp_alloc_zero(w->log, "parts", (size_t) w->file_parts,
                         sizeof *w->chunks, &w->chunks));
    for (int i = 0; i < w->parts; i++) {
        struct new_part *const part = &w->part[i];
        const int number = all ? part->f->part : 0;
        enum gp_compression c = w->p->compression;
        if (number < 0 || number >= w->file_parts || w->at[number])
            GP_TRY(gp_fail(w->log, GP_ERR_BUG,
                   "%s: part %d is not one of its own", part->f->path, number));
        w->at[number] = part;
        part->own = in ? &in->index->part[part->f->part] : NULL;
        if (c == GP_COMPRESSION_AUTO) { // the input's, when that loses nothing
            const struct gp_exr_attr *const a =
                gp_exr_attr_find(part->own, "compression", "compression");
            c = a && a->size == 1 && a->data[0] <= GP_COMPRESSION_PIZ
                    ? (enum gp_compression) a->data[0] : GP_COMPRESSION_ZIP;
        }
        // OpenImageIO writes a single channel as zip instead of DWA: the header
        // must match
        if (c >= GP_COMPRESSION_DWAA && part->sources.sources == 1) {
            gp_say(w->log, GP_LEVEL_WARN,
                   "%s: a single channel (%s) cannot be DWA; it is written as "
                   "zip", w->path, part->sources.source[0].name);
            c = GP_COMPRESSION_ZIP;
        }
        part->img = (struct gp_exr_image) {
            .data = part->f->data, .source = part->sources.source,
            .sources = part->sources.sources, .compression = c,
        };
        w->chunks[number] = gp_exr_chunk_count(&part->img);
    }
    for (int i = 0; all && i < w->file_parts; i++) {
        if (w->at[i])
            continue;
        // the offset table has 8 bytes for each chunk: the file bounds them
        w->chunks[i] = in->index->part[i].chunks;
        if (w->chunks[i] < 1 ||
            (uint64_t) w->chunks[i] > in->stream.size / sizeof(uint64_t))
            GP_TRY(gp_fail(w->log, GP_ERR_DATA,
                           "%s: part %d has a wrong number of chunks (damaged "
                           "header); copy or render the file again", from, i));
    }
out:
    return st;
}

/* The header of a part of the input as it is. Parts may not differ in their
 * chromaticities (OpenEXR: "non-conforming shared attributes"): beside a part
 * that was converted to others, those of one that was not are left out. */
static void put_other_part(struct writing *w, const struct gp_exr_index *index,
                           int number)
{
    const struct gp_exr_index_part *const part = &index->part[number];
    const float *const converted = w->kept == GP_EXR_KEEP_CONVERTED
                                  ? w->p->primaries : NULL;
    const struct gp_exr_attr *const own =
        gp_exr_attr_find(part, "chromaticities", "chromaticities");
    const uint8_t *from = index->bytes + part->from;
    if (converted && own && memcmp(own->data, converted, own->size) != 0) {
        gp_say(w->log, GP_LEVEL_WARN, "%s: part %d is not converted, and loses "
               "its chromaticities, in which the parts of a file may not "
               "differ; write it to a file of its own", w->path, number);
        gp_exr_put_raw(&w->out, from,
                       (size_t) ((const uint8_t *) own->name - from));
        from = own->data + own->size;
    }
    gp_exr_put_raw(&w->out, from, (size_t) (index->bytes + part->to - from));
}

/* Counts the light that the file cannot hold, and says so where it is much. */
static void count_fits(const struct writing *w, struct gp_write_stats *stats)
{
    static const char *const name[3] = {"red", "green", "blue"};
    struct gp_exr_fit all = {0};
    double share = 0.01;
    int worst = -1;
    for (int i = 0; i < w->parts; i++) {
        const struct gp_exr_fit *const fit = &w->part[i].sources.fit;
        all.values += fit->values;
        all.pixels += fit->pixels;
        for (int c = 0; c < 3; c++) {
            all.light[c] += fit->light[c];
            all.lost[c] += fit->lost[c];
        }
    }
    stats->clamped += all.values;
    for (int c = 0; c < 3; c++) {
        stats->flux_clamped[c] += all.lost[c];
        if (all.lost[c] > share * all.light[c]) {
            share = all.lost[c] / all.light[c];
            worst = c;
        }
    }
    if (worst < 0)
        return;
    const bool dwa = w->p->compression >= GP_COMPRESSION_DWAA;
    gp_say(w->log, GP_LEVEL_WARN, "%s: %s loses %.3g %% of the %s light (%lld "
           "pixels over %g); use %s", w->path, dwa ? "DWA" : "--type half",
           100.0 * share, name[worst], all.pixels,
           dwa ? (double) GP_EXR_DWA_MAX : 65504.0,
           dwa ? "--compression zip" : "--type float or auto");
}

/* Writes the file under its final name or not at all, and frees what `w` has
 * but its parts. */
static gp_status write_file(struct writing *w, struct gp_write_stats *stats)
{
    gp_status st;
    const struct gp_input *in = gp_input_of(w->part[0].f);
    struct gp_write_stats added = {0};
    GP_TRY(plan_parts(w, in));
    const bool multi = w->file_parts > 1;
    uint32_t flags = 0;
    if (multi) // of several parts, which only an input has
        flags = GP_EXR_MULTIPART |
                (gp_le32(in->index->bytes + 4) & GP_EXR_LONG_NAMES);
    for (int i = 0; multi && i < w->file_parts; i++)
        flags |= !w->at[i] && gp_exr_is_deep(in, i) ? GP_EXR_DEEP : 0;

    GP_TRY(gp_file_open(w->log, w->path, w->p->create_dir, &w->file));
    gp_exr_out_begin(&w->out, w->log, w->file, flags);
    for (int i = 0; i < w->file_parts; i++) {
        const struct new_part *part = w->at[i];
        if (!part) {
            put_other_part(w, in->index, i);
            continue;
        }
        const struct gp_exr_attr *name =
            w->all ? gp_exr_attr_find(part->own, "name", "string") : NULL;
        char text[256] = "";
        if (name) // the attribute has no null byte
            memcpy(text, name->data,
                   name->size < sizeof text ? name->size : sizeof text - 1);
        gp_exr_put_part(&w->out, part->f, &part->img, part->own, w->kept,
                        name || multi ? text : NULL, w->p,
                        multi ? w->chunks[i] : 0);
    }
    if (multi)
        gp_exr_put_raw(&w->out, "", 1);
    GP_TRY(gp_exr_out_tables(&w->out, w->chunks, w->file_parts));
    for (int i = 0; i < w->file_parts; i++) {
        const struct new_part *part = w->at[i];
        if (!part) {
            GP_TRY(gp_exr_out_copy(&w->out, i, w->part[0].f->path, in, i));
            continue;
        }
        // DWA's quality is the input's, or OpenEXR's default
        float quality = 45.0f;
        const struct gp_exr_attr *a =
            gp_exr_attr_find(part->own, "dwaCompressionLevel", "float");
        if (a && a->size == sizeof quality)
            memcpy(&quality, a->data, sizeof quality);
        if (!(quality >= 0.0f && quality <= 1e6f))
            quality = 45.0f;
        GP_TRY(gp_exr_encode(&w->out, i, &part->img, quality, &added));
    }
    GP_TRY(gp_exr_out_end(&w->out));
    GP_TRY(gp_file_commit(&w->file));
    stats->clamped += added.clamped;
    count_fits(w, stats);
out:
    gp_file_discard(&w->file);
    gp_exr_out_free(&w->out);
    gp_free(w->at);
    gp_free(w->chunks);
    return st;
}

/* -- pictures ------------------------------------------------------------- */

gp_status gp_exr_write_picture(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const struct gp_frame *f,
    const struct gp_planes *planes, enum gp_picture_kind kind,
    struct gp_write_stats *stats)
{
    struct new_part part = {.f = f};
    struct writing w = {
        .log = log, .p = p, .path = path, .part = &part, .parts = 1,
        .kept = kind == GP_PICTURE_SCENE ? GP_EXR_KEEP_SCENE
                                         : GP_EXR_KEEP_SHOWN,
    };
    gp_status st = gp_exr_sources_picture(log, p, f, planes, &part.sources);
    if (!st)
        st = write_file(&w, stats);
    gp_exr_sources_free(&part.sources);
    return st;
}

/* -- --hdr: the frame as it came in, with glare --------------------------- */

/* The frames of set[i]'s part, from i on, into `group`; 0 when an earlier one
 * has that part already, -1 when their windows differ, or no frame has all
 * channels that the part has. */
static int group_frames(const struct gp_hdr_colour *set, int n, int i,
                        struct gp_hdr_colour *group)
{
    const struct gp_frame *const f = set[i].f;
    const struct gp_input *in = gp_input_of(set[0].f);
    const exr_attr_chlist_t *list = NULL;
    int found = 0;
    if (in && exr_get_channels(in->exr, f->part, &list))
        return -1;
    bool complete = !in;
    for (int k = 0; k < n; k++) {
        if (set[k].f->part != f->part)
            continue;
        if (k < i)
            return 0;
        if (memcmp(&set[k].f->data, &f->data, sizeof f->data) != 0)
            return -1;
        complete = complete || set[k].f->channels == list->num_channels;
        group[found++] = set[k];
    }
    return complete ? found : -1;
}

gp_status gp_exr_write_hdr(const struct gp_log *log,
    const struct gp_write_params *p, const char *path,
    const struct gp_hdr_colour *set, int n, struct gp_write_stats *stats)
{
    struct writing w = {
        .log = log, .p = p, .path = path,
        .kept = p->converted ? GP_EXR_KEEP_CONVERTED : GP_EXR_KEEP_ALL,
    };
    const struct gp_input *const in = gp_input_of(set[0].f);
    struct gp_crypto crypto;
    struct gp_hdr_colour *group = NULL;
    gp_status st;
    GP_TRY(gp_alloc_zero(log, "parts", (size_t) n, sizeof *w.part, &w.part));
    GP_TRY(gp_alloc(log, "parts", (size_t) n, sizeof *set, &group));
    for (int i = 0; i < n; i++) {
        const int found = group_frames(set, n, i, group);
        if (found < 0)
            GP_TRY(gp_fail(log, GP_ERR_BUG, "%s: no frame is the whole part %d",
                   set[i].f->path, set[i].f->part));
        if (found == 0)
            continue;
        struct new_part *const to = &w.part[w.parts++];
        to->f = set[i].f;
        GP_TRY(gp_exr_sources_hdr(log, p, group, found, &to->sources));
    }
    // ids with one bit less are other ids. A compression that would do that was
    // asked for: AUTO loses nothing
    gp_exr_crypto(in, &crypto);
    for (int i = 0; i < w.parts; i++) {
        const struct new_part *const part = &w.part[i];
        for (int k = 0; k < part->sources.sources; k++) {
            const struct gp_exr_source *s = &part->sources.source[k];
            if (s->data && gp_exr_loses(p->compression, s->type, s->name) &&
                gp_exr_crypto_channel(&crypto, in, part->f->part, s->name) ==
                    GP_CRYPTO_IDS)
                GP_TRY(gp_fail(log, GP_ERR_USAGE,
                       "%s: this compression would change the Cryptomatte ids "
                       "of %s (channel %s); use --compression zip", path,
                       part->f->path, s->name));
        }
    }
    GP_TRY(write_file(&w, stats));
out:
    for (int i = 0; i < w.parts; i++)
        gp_exr_sources_free(&w.part[i].sources);
    gp_free(w.part);
    gp_free(group);
    return st;
}
