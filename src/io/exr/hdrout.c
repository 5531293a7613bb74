#include "io/exr/exr_priv.h"

#include "core/colour.h"

#include <stdlib.h>
#include <string.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "EXR is little-endian and is written from memory as it is");

enum { SHORT_NAME = 31 }; // longest name without GP_EXR_LONG_NAMES

static void put(struct gp_exr_header *h, const void *data, size_t n)
{
    if (h->full || n == 0)
        return;
    if (n > h->room - h->size) {
        size_t room = (h->room + n) * 2;
        uint8_t *more = room > n ? realloc(h->bytes, room) : NULL;
        if (!more) {
            h->full = true;
            return;
        }
        h->bytes = more;
        h->room = room;
    }
    memcpy(h->bytes + h->size, data, n);
    h->size += n;
}

static void put_name(struct gp_exr_header *h, const char *name)
{
    if (strlen(name) > SHORT_NAME)
        h->flags |= GP_EXR_LONG_NAMES;
    put(h, name, strlen(name) + 1);
}

void gp_exr_header_start(struct gp_exr_header *h, uint32_t flags)
{
    const uint32_t magic = GP_EXR_MAGIC;
    *h = (struct gp_exr_header) {.flags = flags};
    put(h, &magic, 4);
    put(h, &flags, 4);
}

void gp_exr_header_put(struct gp_exr_header *h, const char *name,
                       const char *type, const void *data, size_t size)
{
    const int32_t bytes = (int32_t) size;
    put_name(h, name);
    put_name(h, type);
    put(h, &bytes, 4);
    put(h, data, size);
}

void gp_exr_header_raw(struct gp_exr_header *h, const void *bytes, size_t size)
{
    put(h, bytes, size);
}

gp_status gp_exr_header_done(const struct gp_log *log, const char *path,
                             struct gp_exr_header *h)
{
    const uint32_t version = GP_EXR_VERSION | h->flags;
    if (h->full)
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory for the header",
                       path);
    memcpy(h->bytes + 4, &version, 4);
    return GP_OK;
}

void gp_exr_header_free(struct gp_exr_header *h)
{
    free(h->bytes);
    *h = (struct gp_exr_header) {0};
}

// -- the colour part ----------------------------------------------------------

static void put_channels(struct gp_exr_header *h,
                         const struct gp_exr_image *img)
{
    struct gp_exr_header list = {0};
    // the bridge has no way to tell the DWA compressor of the flag, and a
    // reader must not believe what the chunks are not made for
    const bool dwa = img->compression == GP_COMPRESSION_DWAA ||
                     img->compression == GP_COMPRESSION_DWAB;
    for (int i = 0; i < img->sources; i++) {
        const struct gp_exr_source *s = &img->source[i];
        const int32_t type = (int32_t) s->type; // GP_UINT.. number as EXR does
        const uint8_t linear[4] = {s->linear && !dwa};
        const int32_t step[2] = {s->xs, s->ys};
        put_name(&list, s->name);
        put(&list, &type, 4);
        put(&list, linear, 4);
        put(&list, step, 8);
    }
    put(&list, "", 1);
    h->flags |= list.flags;
    h->full |= list.full;
    gp_exr_header_put(h, "channels", "chlist", list.bytes, list.size);
    gp_exr_header_free(&list);
}

static void put_window(struct gp_exr_header *h, const char *name,
                       struct gp_rect r)
{
    const int32_t box[4] = {r.x0, r.y0, r.x1 - 1, r.y1 - 1};
    gp_exr_header_put(h, name, "box2i", box, sizeof box);
}

/* An attribute of the input, or its default. */
static void put_or(struct gp_exr_header *h, const struct gp_exr_carried_part *raw,
                   const char *name, const char *type, const void *data,
                   size_t size)
{
    const struct gp_exr_attr *a = raw ? gp_exr_attr_find(raw, name, type) : NULL;
    if (a && a->size == size)
        data = a->data;
    gp_exr_header_put(h, name, type, data, size);
}

static bool listed(const char *name, const char *const *list)
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
    // how the input's colours are meant to be turned into what this shows
    static const char *const shown[] = {
        "chromaticities", "adoptedNeutral", "whiteLuminance",
        "renderingTransform", "lookModTransform", NULL,
    };
    if (listed(name, own))
        return false;
    if (kept != GP_EXR_KEEP_ALL && listed(name, scene) &&
        !(kept == GP_EXR_KEEP_CONVERTED && strcmp(name, "multiView") == 0))
        return false;
    return in_own_light(kept) || !listed(name, shown);
}

/* The attributes of the input that are kept: manifests of ids, or all but
 * those. */
static void put_carried(struct gp_exr_header *h,
                        const struct gp_exr_carried_part *raw,
                        enum gp_exr_kept kept, bool manifests)
{
    for (int i = 0; raw && i < raw->attrs; i++) {
        const struct gp_exr_attr *a = &raw->attr[i];
        if ((strcmp(a->type, "idmanifest") == 0) == manifests &&
            is_kept(a->name, kept) &&
            !(h->flags & GP_EXR_DEEP && strcmp(a->name, "version") == 0))
            gp_exr_header_put(h, a->name, a->type, a->data, a->size);
    }
}

/* What the part says of itself, whatever the input said. lineOrder is that
 * of the chunks as they are written; tiled inputs are written as scanlines
 * and mip-mapped ones without their smaller levels, which would have to be
 * made anew from the picture with glare.
 *
 * OpenEXR 3.1.5 takes 4 bytes too many for a manifest, and so the start of the
 * next attribute's name. It writes lineOrder there, whose default is ours too.
 */
static void put_required(struct gp_exr_header *h, const struct gp_frame *f,
                         const struct gp_exr_image *img,
                         const struct gp_exr_carried_part *raw,
                         enum gp_exr_kept kept)
{
    static const float centre[2] = {0, 0}, width = 1;
    const uint8_t compression = (uint8_t) img->compression;
    put_channels(h, img);
    gp_exr_header_put(h, "compression", "compression", &compression, 1);
    put_window(h, "dataWindow", img->data);
    put_window(h, "displayWindow", f->display);
    put_carried(h, raw, kept, true);
    gp_exr_header_put(h, "lineOrder", "lineOrder", "", 1); // increasing y
    gp_exr_header_put(h, "pixelAspectRatio", "float", &f->pixel_aspect, 4);
    put_or(h, raw, "screenWindowCenter", "v2f", centre, sizeof centre);
    put_or(h, raw, "screenWindowWidth", "float", &width, sizeof width);
}

/* Attributes that OpenImageIO makes of another format's header say how that
 * file was stored; only those about the picture are carried. */
static bool about_storage(const char *name)
{
    static const char *const whole[] = {
        "compression", "Compression", "CompressionQuality", "Orientation",
        "ResolutionUnit", "XResolution", "YResolution", "planarconfig",
        "PixelAspectRatio", "ICCProfile", "chromaticities", "gamma", NULL,
    };
    static const char *const start[] = {
        "oiio:", "tiff:", "jpeg:", "png:", "dpx:", "bmp:", "pnm:", "hdr:",
        "targa:", "gif:", "webp:", "sgi:", "openexr:", "ICCProfile:", NULL,
    };
    for (int i = 0; start[i]; i++) {
        if (strncmp(name, start[i], strlen(start[i])) == 0)
            return true;
    }
    return listed(name, whole);
}

static void put_foreign(struct gp_exr_header *h, const struct gp_frame *f,
                        enum gp_exr_kept kept)
{
    for (int i = 0; i < f->attributes; i++) {
        const struct gp_attribute *a = &f->attribute[i];
        const size_t n = strlen(a->name);
        if (n == 0 || n > 255 || about_storage(a->name) ||
            !is_kept(a->name, kept))
            continue;
        if (a->kind == GP_ATTRIBUTE_TEXT && a->text)
            gp_exr_header_put(h, a->name, "string", a->text, strlen(a->text));
        else if (a->kind == GP_ATTRIBUTE_INT)
            gp_exr_header_put(h, a->name, "int", &a->whole, 4);
        else if (a->kind == GP_ATTRIBUTE_FLOAT)
            gp_exr_header_put(h, a->name, "float", &a->real, 4);
    }
}

void gp_exr_header_part(struct gp_exr_header *h, const struct gp_frame *f,
                        const struct gp_exr_image *img,
                        const struct gp_exr_carried_part *raw,
                        enum gp_exr_kept kept, const char *name, int chunks)
{
    const int32_t count = chunks, version = 1;
    put_required(h, f, img, raw, kept);
    if (name)
        gp_exr_header_put(h, "name", "string", name, strlen(name));
    if (chunks > 0) {
        gp_exr_header_put(h, "type", "string", "scanlineimage", 13);
        gp_exr_header_put(h, "chunkCount", "int", &count, 4);
    }
    if (h->flags & GP_EXR_DEEP) // OpenEXRCore asks it of all parts then
        gp_exr_header_put(h, "version", "int", &version, 4);
    put_carried(h, raw, kept, false);
    if (!raw)
        put_foreign(h, f, kept);
    const bool carried = raw && gp_exr_attr_find(raw, "chromaticities",
                                                "chromaticities");
    if (in_own_light(kept) && !carried &&
        memcmp(f->chromaticities, gp_rec709_chromaticities,
               sizeof f->chromaticities) != 0)
        gp_exr_header_put(h, "chromaticities", "chromaticities",
                          f->chromaticities, sizeof f->chromaticities);
    put(h, "", 1);
}
