#include "io/exr/exr_priv.h"

#include "core/memory.h"
#include "io/file.h"

#include <string.h>

enum gp_pixel_type gp_exr_colour_type(const struct gp_write_params *p,
                                      const struct gp_frame *f)
{
    if (p->type == GP_OUT_AUTO)
        return f->colour_type;
    return p->type == GP_OUT_HALF ? GP_HALF : GP_FLOAT;
}

enum gp_compression gp_exr_compression(const struct gp_write_params *p,
                                       const struct gp_exr_carried_part *raw)
{
    if (p->compression != GP_COMPRESSION_AUTO)
        return p->compression;
    const struct gp_exr_attr *a =
        raw ? gp_exr_attr_find(raw, "compression", "compression") : NULL;
    if (a && a->size == 1 && a->data[0] <= GP_COMPRESSION_PIZ)
        return (enum gp_compression) a->data[0];
    return GP_COMPRESSION_ZIP;
}

/* The quality that the input was written with, or OpenEXR's default. */
static float dwa_quality(const struct gp_exr_carried_part *raw)
{
    float quality = 45.0f;
    const struct gp_exr_attr *a =
        raw ? gp_exr_attr_find(raw, "dwaCompressionLevel", "float") : NULL;
    if (a && a->size == sizeof quality)
        memcpy(&quality, a->data, sizeof quality);
    return quality >= 0.0f && quality <= 1e6f ? quality : 45.0f;
}

/* A part on its way. */
struct made {
    const struct gp_exr_part *from;
    struct gp_exr_image img;
    const struct gp_exr_carried_part *own;  // of the input, or NULL
};

/* A file on its way: what is open at once, so that one place closes it. */
struct writing {
    const struct gp_exr_job *job;
    struct gp_exr_carried raw;
    struct made *made;  // one for each part of the file; `from` is NULL for
                        // those that are carried
    struct gp_exr_header header;
    struct gp_exr_out out;
    struct gp_file *file;
    int *chunks;  // of each part
    int parts;
};

/* True when the input's other parts go along. */
static bool keeps_parts(const struct gp_exr_job *job)
{
    return job->kept == GP_EXR_KEEP_ALL || job->kept == GP_EXR_KEEP_CONVERTED;
}

/* OpenImageIO writes a single channel as zip where DWA is asked for: the header
 * has to say so too. */
static enum gp_compression compression_of(const struct gp_log *log,
                                          const struct writing *w,
                                          const struct made *m)
{
    const enum gp_compression c = gp_exr_compression(w->job->p, m->own);
    if (c < GP_COMPRESSION_DWAA || m->from->sources != 1)
        return c;
    gp_say(log, GP_LEVEL_WARN,
           "%s: one channel alone (%s) cannot be DWA; it is written as zip",
           w->job->path, m->from->source[0].name);
    return GP_COMPRESSION_ZIP;
}

static gp_status plan(const struct gp_log *log, struct writing *w,
                      const struct gp_input *o)
{
    const struct gp_exr_job *job = w->job;
    const bool exr = o && o->exr, all = exr && keeps_parts(job);
    void *made;
    gp_status st = GP_OK;
    w->parts = all ? o->parts : 1;
    if (exr)
        st = gp_exr_carried_read(log, job->part[0].f->path, o, &w->raw);
    if (st)
        return st;
    st = gp_alloc_zero(log, "parts", (size_t) w->parts, sizeof *w->made,
                       &made);
    w->made = made;
    for (int i = 0; !st && i < job->parts; i++) {
        const struct gp_exr_part *part = &job->part[i];
        const int number = all ? part->f->part : 0;
        if (number < 0 || number >= w->parts || w->made[number].from)
            return gp_fail(log, GP_ERR_BUG, "%s: part %d is not one of its own",
                           part->f->path, number);
        struct made *m = &w->made[number];
        m->from = part;
        m->own = exr ? &w->raw.part[part->f->part] : NULL;
        m->img = (struct gp_exr_image) {
            .data = part->f->data, .source = part->source,
            .sources = part->sources,
            .compression = compression_of(log, w, m),
        };
    }
    return st;
}

static gp_status count_chunks(const struct gp_log *log, struct writing *w,
                              const struct gp_input *o)
{
    void *mem;
    gp_status st = gp_alloc(log, "parts", (size_t) w->parts, sizeof *w->chunks,
                            &mem);
    w->chunks = mem;
    for (int i = 0; !st && i < w->parts; i++) {
        int32_t n;
        // the offset table has 8 bytes for each chunk: the file bounds them
        if (w->made[i].from)
            n = gp_exr_chunk_count(&w->made[i].img);
        else if ((n = o->index->part[i].chunks) < 1 ||
                 (uint64_t) n > o->stream.size / 8)
            st = gp_fail(log, GP_ERR_DATA,
                         "%s: part %d has a wrong number of chunks (damaged "
                         "header); copy or render the file again",
                         w->job->part[0].f->path, i);
        w->chunks[i] = st ? 0 : n;
    }
    return st;
}

static void put_made(struct writing *w, int i)
{
    const struct made *m = &w->made[i];
    const bool multi = w->parts > 1;
    const struct gp_exr_attr *name =
        m->own && keeps_parts(w->job)
            ? gp_exr_attr_find(m->own, "name", "string") : NULL;
    char text[256] = "";
    if (name) // the attribute has no null byte
        memcpy(text, name->data,
               name->size < sizeof text ? name->size : sizeof text - 1);
    gp_exr_header_part(&w->header, m->from->f, &m->img, m->own, w->job->kept,
                       name || multi ? text : NULL, multi ? w->chunks[i] : 0);
}

static gp_status make_header(const struct gp_log *log, struct writing *w,
                             const struct gp_input *o)
{
    const bool multi = w->parts > 1;
    uint32_t flags = multi ? GP_EXR_MULTIPART : 0;
    if (multi)
        flags |= w->raw.version & GP_EXR_LONG_NAMES;
    for (int i = 0; multi && i < w->parts; i++)
        flags |= !w->made[i].from && gp_exr_is_deep(o, i) ? GP_EXR_DEEP : 0;
    gp_exr_header_start(&w->header, flags);
    for (int i = 0; i < w->parts; i++) {
        if (w->made[i].from)
            put_made(w, i);
        else
            gp_exr_header_raw(&w->header, w->raw.part[i].bytes,
                              w->raw.part[i].size);
    }
    if (multi)
        gp_exr_header_raw(&w->header, "", 1);
    return gp_exr_header_done(log, w->job->path, &w->header);
}

static gp_status write_parts(const struct gp_log *log, struct writing *w,
                             const struct gp_input *o,
                             struct gp_write_stats *stats)
{
    gp_status st = gp_exr_out_begin(log, w->file, w->header.bytes,
                                    w->header.size, w->chunks, w->parts,
                                    &w->out);
    for (int i = 0; !st && i < w->parts; i++) {
        const struct made *m = &w->made[i];
        if (m->from)
            st = gp_exr_encode(&w->out, i, &m->img, dwa_quality(m->own),
                               stats);
        else
            st = gp_exr_out_copy(&w->out, i, w->job->part[0].f->path, o);
    }
    return st ? st : gp_exr_out_end(&w->out);
}

gp_status gp_exr_write_file(const struct gp_log *log,
                            const struct gp_exr_job *job,
                            struct gp_write_stats *stats)
{
    gp_status st;
    const struct gp_input *o = gp_input_of(job->part[0].f);
    struct writing w = {.job = job};
    struct gp_write_stats now = {0};
    GP_TRY(plan(log, &w, o));
    GP_TRY(count_chunks(log, &w, o));
    GP_TRY(make_header(log, &w, o));
    GP_TRY(gp_file_open(log, job->path, job->p->create_dir, &w.file));
    GP_TRY(write_parts(log, &w, o, &now));
    GP_TRY(gp_file_commit(&w.file));
    stats->clamped += now.clamped;
out:
    gp_file_discard(&w.file);
    gp_exr_out_free(&w.out);
    gp_exr_header_free(&w.header);
    gp_exr_carried_free(&w.raw);
    gp_free(w.made);
    gp_free(w.chunks);
    return st;
}

gp_status gp_exr_write_picture(const struct gp_log *log,
                               const struct gp_write_params *p,
                               const char *path, const struct gp_frame *f,
                               const struct gp_planes *planes,
                               enum gp_picture_kind kind,
                               struct gp_write_stats *stats)
{
    struct gp_exr_sources s;
    gp_status st = gp_exr_sources_picture(log, f, planes,
                                          gp_exr_colour_type(p, f), &s);
    if (st)
        return st;
    const struct gp_exr_part part = {f, s.source, s.sources};
    const struct gp_exr_job job = {
        .p = p, .path = path, .part = &part, .parts = 1,
        .kept = kind == GP_PICTURE_SCENE ? GP_EXR_KEEP_SCENE
                                         : GP_EXR_KEEP_SHOWN,
    };
    st = gp_exr_write_file(log, &job, stats);
    gp_exr_sources_free(&s);
    return st;
}
