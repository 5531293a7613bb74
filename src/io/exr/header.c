// SPDX-License-Identifier: Apache-2.0
/* Writes the headers of an EXR file (openexr file layout, "Header"). */
#include "io/exr/exr_priv.h"

#include "core/colour.h"

#include <string.h>

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
static void put_or(struct gp_exr_out *h, const struct gp_exr_part *own,
                   const char *name, const char *type, const void *data,
                   size_t size)
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

/* The attributes of the input that are kept: manifests, or all others. */
static void put_carried(struct gp_exr_out *h, const struct gp_exr_part *own,
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

/* OpenImageIO's attributes about the picture, not how its file was stored. */
static void put_foreign(struct gp_exr_out *h, const struct gp_frame *f,
                        enum gp_exr_kept kept)
{
    static const char *const start[] = {
        "compression", "Compression", "Orientation", "ResolutionUnit",
        "XResolution", "YResolution", "planarconfig", "PixelAspectRatio",
        "ICCProfile", "chromaticities", "gamma", "oiio:", "tiff:", "jpeg:",
        "png:", "dpx:", "bmp:", "pnm:", "hdr:", "targa:", "gif:", "webp:",
        "sgi:", "openexr:", NULL,
    };
    for (int i = 0; i < f->attributes; i++) {
        const struct gp_attribute *a = &f->attribute[i];
        const size_t n = strlen(a->name);
        bool stored = false;
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
                     const struct gp_exr_image *img,
                     const struct gp_exr_part *own, enum gp_exr_kept kept,
                     const struct gp_write_params *p, int chunks)
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
        if (p->output)
            put_text(h, "glarepp:output", p->output);
    }
    for (int i = 0; i < p->n_added; i++)
        put_text(h, p->added[i].name, p->added[i].text);
    gp_exr_put_raw(h, "", 1);
}
