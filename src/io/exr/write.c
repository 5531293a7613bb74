/* Writes one EXR file: its parts, their headers (openexr file layout, "Header")
 * and their chunks, by encode.c. */
#include "io/exr/exr_priv.h"

#include "core/bytes.h"
#include "core/colour.h"
#include "core/memory.h"
#include "io/channels.h"

#include <string.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "EXR is little-endian and is written from memory as it is");

/* -- compressions --------------------------------------------------------- */

/* True when samples of that channel may be read back with other bits; never for
 * AUTO. EXR's lossy compressions:
 *
 *   PXR24      32-bit floats lose the low 8 bits of their mantissa; half and
 *              uint keep all bits
 *   B44, B44A  half loses (blocks of 4x4 to 6 bits); float and uint keep all
 *   DWAA/B     channels called R, G, B, Y, RY or BY after their last dot lose,
 *              in any layer, half and float, and become half; others keep
 *              their bits, depth too
 *
 * Sources: OpenEXR 3.1.5, ImfPxr24Compressor.cpp, ImfB44Compressor.cpp,
 * DwaCompressor::initializeDefaultChannelRules() of ImfDwaCompressor.cpp. */
static bool loses(enum gp_compression compression, enum gp_pixel_type type,
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

/* -- a header's bytes ----------------------------------------------------- */

enum { SHORT_NAME = 31 }; // longest name without GP_EXR_LONG_NAMES

void gp_exr_put_raw(struct gp_exr_out *out, const void *bytes, size_t n)
{
    const gp_status st = gp_file_write(out->file, bytes, n);
    (void) st; // the file keeps it
}

static void put_name(struct gp_exr_out *out, const char *name)
{
    if (strlen(name) > SHORT_NAME)
        out->flags |= GP_EXR_LONG_NAMES;
    gp_exr_put_raw(out, name, strlen(name) + 1);
}

/* An attribute without its value. */
static void put_head(struct gp_exr_out *out, const char *name, const char *type,
                     size_t size)
{
    const int32_t bytes = (int32_t) size;
    put_name(out, name);
    put_name(out, type);
    gp_exr_put_raw(out, &bytes, 4);
}

void gp_exr_put(struct gp_exr_out *out, const char *name, const char *type,
                const void *data, size_t size)
{
    put_head(out, name, type, size);
    gp_exr_put_raw(out, data, size);
}

static void put_text(struct gp_exr_out *out, const char *name, const char *text)
{
    gp_exr_put(out, name, "string", text, strlen(text));
}

void gp_exr_out_begin(struct gp_exr_out *out, const struct gp_log *log,
                      struct gp_file *file, uint32_t flags)
{
    const uint32_t magic = GP_EXR_MAGIC;
    *out = (struct gp_exr_out) {.log = log, .file = file, .flags = flags};
    gp_exr_put_raw(out, &magic, 4);
    gp_exr_put_raw(out, &flags, 4);
}

/* -- attributes of a new part --------------------------------------------- */

static void put_window(struct gp_exr_out *h, const char *name,
                       struct gp_rect r)
{
    const int32_t box[4] = {r.x0, r.y0, r.x1 - 1, r.y1 - 1};
    gp_exr_put(h, name, "box2i", box, sizeof box);
}

/* An attribute of the input, or its default. */
static void put_or(struct gp_exr_out *h,
                   const struct gp_exr_index_part *own, const char *name,
                   const char *type, const void *data, size_t size)
{
    const struct gp_exr_attr *a = gp_exr_attr_find(own, name, type);
    if (a && a->size == size)
        data = a->data;
    gp_exr_put(h, name, type, data, size);
}

static bool is_listed(const char *name, const char *const *list)
{
    for (; *list; list++) {
        if (strcmp(name, *list) == 0)
            return true;
    }
    return false;
}

/* True when the pixels still are in the input's primaries. */
static bool in_own_light(enum gp_exr_kept kept)
{
    return kept == GP_EXR_KEEP_ALL || kept == GP_EXR_KEEP_SCENE;
}

static bool is_kept(const char *name, enum gp_exr_kept kept)
{
    static const char *const own[] = {
        "channels", "compression", "dataWindow", "displayWindow", "lineOrder",
        "pixelAspectRatio", "screenWindowCenter", "screenWindowWidth", "name",
        "type", "chunkCount", "tiles", "maxSamplesPerPixel", NULL,
    };
    // of the input's pixels, not of this picture's
    static const char *const scene[] = {"preview", "multiView", NULL};
    // transforms for the input's colours, which these no longer are
    static const char *const shown[] = {
        "chromaticities", "adoptedNeutral", "whiteLuminance",
        "renderingTransform", "lookModTransform", NULL,
    };
    if (is_listed(name, own) || strncmp(name, "glarepp:", 8) == 0)
        return false;
    if (kept != GP_EXR_KEEP_ALL && is_listed(name, scene) &&
        !(kept == GP_EXR_KEEP_CONVERTED && strcmp(name, "multiView") == 0))
        return false;
    return in_own_light(kept) || !is_listed(name, shown);
}

/* The attributes of the input that are kept: manifests of ids, or all but
 * those. */
static void put_carried(struct gp_exr_out *h,
                        const struct gp_exr_index_part *own,
                        enum gp_exr_kept kept, bool manifests)
{
    for (int i = 0; own && i < own->attrs; i++) {
        const struct gp_exr_attr *a = &own->attr[i];
        if ((strcmp(a->type, "idmanifest") == 0) == manifests &&
            is_kept(a->name, kept) &&
            !(h->flags & GP_EXR_DEEP && strcmp(a->name, "version") == 0))
            gp_exr_put(h, a->name, a->type, a->data, a->size);
    }
}

/* The attributes that OpenImageIO makes of another format's header. Some say
 * how that file was stored; only those about the picture are carried. */
static void put_foreign(struct gp_exr_out *h, const struct gp_frame *f,
                        enum gp_exr_kept kept)
{
    static const char *const exact[] = {
        "compression", "Compression", "CompressionQuality", "Orientation",
        "ResolutionUnit", "XResolution", "YResolution", "planarconfig",
        "PixelAspectRatio", "ICCProfile", "chromaticities", "gamma", NULL,
    };
    static const char *const start[] = {
        "oiio:", "tiff:", "jpeg:", "png:", "dpx:", "bmp:", "pnm:", "hdr:",
        "targa:", "gif:", "webp:", "sgi:", "openexr:", "ICCProfile:", NULL,
    };
    for (int i = 0; i < f->attributes; i++) {
        const struct gp_attribute *a = &f->attribute[i];
        const size_t n = strlen(a->name);
        bool stored = is_listed(a->name, exact);
        for (int k = 0; !stored && start[k]; k++)
            stored = strncmp(a->name, start[k], strlen(start[k])) == 0;
        if (n == 0 || n > 255 || stored || !is_kept(a->name, kept))
            continue;
        if (a->kind == GP_ATTRIBUTE_TEXT && a->text)
            put_text(h, a->name, a->text);
        else if (a->kind == GP_ATTRIBUTE_INT)
            gp_exr_put(h, a->name, "int", &a->number, 4);
        else if (a->kind == GP_ATTRIBUTE_FLOAT)
            gp_exr_put(h, a->name, "float", &a->real, 4);
    }
}

void gp_exr_put_part(struct gp_exr_out *h, const struct gp_frame *f,
    const struct gp_exr_image *img, const struct gp_exr_index_part *own,
    enum gp_exr_kept kept, const struct gp_write_params *p, int chunks)
{
    static const float centre[2] = {0, 0}, width = 1;
    const int32_t count = chunks, version = 1;
    const uint8_t compression = (uint8_t) img->compression;
    // OpenImageIO cannot pass the flag to the DWA compressor, so the chunks are
    // made without it
    const bool dwa = img->compression >= GP_COMPRESSION_DWAA;
    size_t bytes = 1;
    for (int i = 0; i < img->sources; i++)
        bytes += strlen(img->source[i].name) + 17;
    put_head(h, "channels", "chlist", bytes);
    for (int i = 0; i < img->sources; i++) {
        const struct gp_exr_source *s = &img->source[i];
        const int32_t value[4] = { // GP_UINT.. number as EXR does
            (int32_t) s->type, s->linear && !dwa, s->xs, s->ys,
        };
        put_name(h, s->name);
        gp_exr_put_raw(h, value, sizeof value);
    }
    gp_exr_put_raw(h, "", 1);

    // whatever the input said; lineOrder is that of the chunks as they are
    // written. Tiled inputs are written as scanlines, and mip-mapped ones
    // without their smaller levels, which would have to be made anew from the
    // picture with glare.
    gp_exr_put(h, "compression", "compression", &compression, 1);
    put_window(h, "dataWindow", img->data);
    put_window(h, "displayWindow", f->display);
    // OpenEXR 3.1.5 takes 4 bytes too many for a manifest, and so the start of
    // the next attribute's name. It writes lineOrder there, whose default is
    // ours too.
    put_carried(h, own, kept, true);
    gp_exr_put(h, "lineOrder", "lineOrder", "", 1); // increasing y
    gp_exr_put(h, "pixelAspectRatio", "float", &f->pixel_aspect, 4);
    put_or(h, own, "screenWindowCenter", "v2f", centre, sizeof centre);
    put_or(h, own, "screenWindowWidth", "float", &width, sizeof width);
    const struct gp_exr_attr *const name =
        kept == GP_EXR_KEEP_ALL || kept == GP_EXR_KEEP_CONVERTED
            ? gp_exr_attr_find(own, "name", "string") : NULL;
    if (name)
        gp_exr_put(h, "name", "string", name->data, name->size);
    else if (chunks > 0)
        put_text(h, "name", "");
    if (chunks > 0) {
        put_text(h, "type", "scanlineimage");
        gp_exr_put(h, "chunkCount", "int", &count, 4);
    }
    if (h->flags & GP_EXR_DEEP) // OpenEXRCore asks it of all parts then
        gp_exr_put(h, "version", "int", &version, 4);
    put_carried(h, own, kept, false);
    if (!own)
        put_foreign(h, f, kept);
    if (in_own_light(kept) &&
        !gp_exr_attr_find(own, "chromaticities", "chromaticities") &&
        (f->names_chromaticities ||
         memcmp(f->chromaticities, gp_rec709_chromaticities,
                sizeof f->chromaticities) != 0))
        gp_exr_put(h, "chromaticities", "chromaticities",
                   f->chromaticities, sizeof f->chromaticities);
    if (kept == GP_EXR_KEEP_CONVERTED && p->primaries)
        gp_exr_put(h, "chromaticities", "chromaticities", p->primaries,
                   sizeof f->chromaticities);
    if (p->command) {
        put_text(h, "glarepp:version", GP_VERSION);
        put_text(h, "glarepp:command", p->command);
    }
    for (int i = 0; i < p->n_added; i++)
        put_text(h, p->added[i].name, p->added[i].text);
    gp_exr_put_raw(h, "", 1);
}

/* -- a file on its way ---------------------------------------------------- */

struct part {
    const struct gp_frame *f; // its windows; NULL: the input's part as it is
    struct gp_exr_sources sources;
    struct gp_exr_image img;
    const struct gp_exr_index_part *own; // of the input, or NULL
};

/* All that is open at once, closed in one place. */
struct writing {
    const struct gp_log *log;
    const struct gp_write_params *p;
    const char *path, *from;
    const struct gp_input *in; // NULL: not of an EXR
    enum gp_exr_kept kept;
    struct part *part; // those of the input, or one
    int parts;
    int *chunks;       // of each part
    struct gp_exr_out out;
    struct gp_file *file;
    long long clamped; // values, in the chunks
    struct gp_exr_fit fit;
};

/* Finds the compression of a new part, and how many chunks it has. */
static void plan_part(struct writing *w, struct part *part, int *chunks)
{
    enum gp_compression c = w->p->compression;
    part->own = w->in ? &w->in->index->part[part->f->part] : NULL;
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
    // DWA's quality is the input's, or OpenEXR's default
    float quality = 45.0f;
    const struct gp_exr_attr *const a =
        gp_exr_attr_find(part->own, "dwaCompressionLevel", "float");
    if (a && a->size == sizeof quality)
        memcpy(&quality, a->data, sizeof quality);
    part->img = (struct gp_exr_image) {
        .data = part->f->data, .source = part->sources.source,
        .sources = part->sources.sources, .compression = c,
        .quality = quality >= 0.0f && quality <= 1e6f ? quality : 45.0f,
    };
    *chunks = gp_exr_chunk_count(&part->img);
}

/* The header of a part of the input as it is. Parts may not differ in their
 * chromaticities (OpenEXR: "non-conforming shared attributes"): beside a part
 * that was converted to others, those of one that was not are left out. */
static void put_other_part(struct writing *w, int number)
{
    const struct gp_exr_index *const index = w->in->index;
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
    const struct gp_exr_fit *const fit = &w->fit;
    double share = 0.01;
    int worst = -1;
    stats->clamped += w->clamped + fit->values;
    for (int c = 0; c < 3; c++) {
        stats->flux_clamped[c] += fit->lost[c];
        if (fit->lost[c] > share * fit->light[c]) {
            share = fit->lost[c] / fit->light[c];
            worst = c;
        }
    }
    if (worst < 0)
        return;
    const bool dwa = w->p->compression >= GP_COMPRESSION_DWAA;
    gp_say(w->log, GP_LEVEL_WARN, "%s: %s loses %.3g %% of the %s light (%lld "
           "pixels over %g); use %s", w->path, dwa ? "DWA" : "--type half",
           100.0 * share, name[worst], fit->pixels,
           dwa ? (double) GP_EXR_DWA_MAX : 65504.0,
           dwa ? "--compression zip" : "--type float or auto");
}

/* Writes the file under its final name or not at all, and frees what `w` has
 * but its parts. */
static gp_status write_file(struct writing *w, struct gp_write_stats *stats)
{
    gp_status st;
    const struct gp_input *const in = w->in;
    const bool multi = w->parts > 1; // which only an input has
    uint32_t flags = multi ? GP_EXR_MULTIPART |
        (gp_le32(in->index->bytes + 4) & GP_EXR_LONG_NAMES) : 0;
    GP_TRY(gp_alloc_zero(w->log, "parts", (size_t) w->parts,
                         sizeof *w->chunks, &w->chunks));
    for (int i = 0; i < w->parts; i++) {
        if (w->part[i].f) {
            plan_part(w, &w->part[i], &w->chunks[i]);
            continue;
        }
        w->chunks[i] = in->index->part[i].chunks;
        flags |= gp_exr_is_deep(in, i) ? GP_EXR_DEEP : 0;
    }
    GP_TRY(gp_file_open(w->log, w->path, w->p->create_dir, &w->file));
    gp_exr_out_begin(&w->out, w->log, w->file, flags);
    for (int i = 0; i < w->parts; i++) {
        const struct part *const part = &w->part[i];
        if (part->f)
            gp_exr_put_part(&w->out, part->f, &part->img, part->own, w->kept,
                            w->p, multi ? w->chunks[i] : 0);
        else
            put_other_part(w, i);
    }
    if (multi)
        gp_exr_put_raw(&w->out, "", 1);
    GP_TRY(gp_exr_out_tables(&w->out, w->chunks, w->parts));
    for (int i = 0; i < w->parts; i++)
        GP_TRY(w->part[i].f
                   ? gp_exr_encode(&w->out, i, &w->part[i].img, &w->clamped)
                   : gp_exr_out_copy(&w->out, i, w->from, in, i));
    GP_TRY(gp_exr_out_end(&w->out));
    GP_TRY(gp_file_commit(&w->file));
    count_fits(w, stats);
out:
    gp_file_discard(&w->file);
    gp_exr_out_free(&w->out);
    gp_free(w->chunks);
    return st;
}

/* -- pictures ------------------------------------------------------------- */

gp_status gp_exr_write_picture(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const struct gp_frame *f,
    const struct gp_planes *planes, enum gp_picture_kind kind,
    struct gp_write_stats *stats)
{
    struct part part = {.f = f};
    struct writing w = {
        .log = log, .p = p, .path = path, .in = gp_input_of(f), .part = &part,
        .parts = 1,
        .kept = kind == GP_PICTURE_SCENE ? GP_EXR_KEEP_SCENE
                                         : GP_EXR_KEEP_SHOWN,
    };
    part.sources.fit = &w.fit;
    gp_status st = gp_exr_sources_picture(log, p, f, planes, &part.sources);
    if (!st)
        st = write_file(&w, stats);
    gp_exr_sources_free(&part.sources);
    return st;
}

/* -- --hdr: the frame as it came in, with glare --------------------------- */

/* The frames of set[0]'s part into `group`; 0 when their windows differ, or no
 * frame has all channels that the part has. */
static int group_frames(const struct gp_input *in,
    const struct gp_hdr_colour *set, int n, struct gp_hdr_colour *group)
{
    const struct gp_frame *const f = set->f;
    const exr_attr_chlist_t *list = NULL;
    int found = 0;
    if (in && exr_get_channels(in->exr, f->part, &list))
        return 0;
    bool complete = !in;
    for (int k = 0; k < n; k++) {
        if (set[k].f->part != f->part)
            continue;
        if (memcmp(&set[k].f->data, &f->data, sizeof f->data) != 0)
            return 0;
        complete = complete || set[k].f->channels == list->num_channels;
        group[found++] = set[k];
    }
    return complete ? found : 0;
}

gp_status gp_exr_write_hdr(const struct gp_log *log,
    const struct gp_write_params *p, const char *path,
    const struct gp_hdr_colour *set, int n, struct gp_write_stats *stats)
{
    const struct gp_input *const in = gp_input_of(set[0].f);
    struct writing w = {
        .log = log, .p = p, .path = path, .from = set[0].f->path, .in = in,
        .kept = p->converted ? GP_EXR_KEEP_CONVERTED : GP_EXR_KEEP_ALL,
    };
    struct gp_crypto crypto;
    struct gp_hdr_colour *group = NULL;
    gp_status st;
    GP_TRY(gp_alloc(log, "parts", (size_t) n, sizeof *set, &group));
    const int parts = in ? in->parts : 1;
    GP_TRY(gp_alloc_zero(log, "parts", (size_t) parts, sizeof *w.part,
                         &w.part));
    w.parts = parts;
    // ids with one bit less are other ids. A compression that would do that was
    // asked for: AUTO loses nothing
    gp_exr_crypto(in, &crypto);
    for (int i = 0; i < n; i++) {
        const int number = set[i].f->part;
        struct part *const to = &w.part[in ? number : 0];
        if (to->f)
            continue;
        const int found = group_frames(in, set + i, n - i, group);
        if (found == 0)
            GP_TRY(gp_fail(log, GP_ERR_BUG, "%s: no frame is the whole part %d",
                   w.from, number));
        to->f = set[i].f;
        to->sources.fit = &w.fit;
        GP_TRY(gp_exr_sources_hdr(log, p, group, found, &to->sources));
        for (int k = 0; k < to->sources.sources; k++) {
            const struct gp_exr_source *s = &to->sources.source[k];
            if (s->data && loses(p->compression, s->type, s->name) &&
                gp_exr_crypto_channel(&crypto, in, number, s->name) ==
                    GP_CRYPTO_IDS)
                GP_TRY(gp_fail(log, GP_ERR_USAGE,
                       "%s: this compression would change the Cryptomatte ids "
                       "of %s (channel %s); use --compression zip", path,
                       w.from, s->name));
        }
    }
    st = write_file(&w, stats);
out:
    for (int i = 0; i < w.parts; i++)
        gp_exr_sources_free(&w.part[i].sources);
    gp_free(w.part);
    gp_free(group);
    return st;
}
