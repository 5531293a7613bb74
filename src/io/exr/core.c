#include "io/exr/exr_priv.h"

#include "core/memory.h"

#include <string.h>

struct gp_exr_core {
    exr_context_t ctxt;
    exr_encode_pipeline_t pipe;
    bool started;  // pipe is initialised
    const struct gp_exr_image *img;
    int y0, y1;    // of the chunk under way
    long long *clamped;
};

static int64_t write_nowhere(exr_const_context_t ctxt, void *user,
                             const void *data, uint64_t size, uint64_t offset,
                             exr_stream_error_func_ptr_t error)
{
    (void) ctxt;
    (void) user;
    (void) data;
    (void) offset;
    (void) error;
    return (int64_t) size;
}

static void say_nothing(exr_const_context_t ctxt, exr_result_t code,
                        const char *message)
{
    (void) ctxt; // the caller has the code
    (void) code;
    (void) message;
}

/* A header just good enough for the compressors. */
static exr_result_t describe(exr_context_t ctxt, const struct gp_exr_image *img)
{
    const struct gp_rect d = img->data;
    const exr_attr_box2i_t window = {.min = {.x = d.x0, .y = d.y0},
                                     .max = {.x = d.x1 - 1, .y = d.y1 - 1}};
    const exr_attr_v2f_t centre = {.x = 0.0f, .y = 0.0f};
    int part;
    exr_result_t r = exr_set_longname_support(ctxt, 1);
    if (!r)
        r = exr_add_part(ctxt, "part", EXR_STORAGE_SCANLINE, &part);
    if (!r)
        r = exr_initialize_required_attr(ctxt, part, &window, &window, 1.0f,
                                         &centre, 1.0f,
                                         EXR_LINEORDER_INCREASING_Y,
                                         (exr_compression_t) img->compression);
    for (int i = 0; !r && i < img->sources; i++) {
        const struct gp_exr_source *s = &img->source[i];
        r = exr_add_channel(ctxt, part, s->name, (exr_pixel_type_t) s->type,
                            s->linear ? EXR_PERCEPTUALLY_LINEAR
                                      : EXR_PERCEPTUALLY_LOGARITHMIC,
                            s->xs, s->ys);
    }
    return r ? r : exr_write_header(ctxt);
}

struct gp_exr_core *gp_exr_core_new(const struct gp_exr_image *img)
{
    // the library's way, so that a full memory is known as one
    struct gp_exr_core *core = gp_exr_allocate(sizeof *core);
    if (!core)
        return NULL;
    *core = (struct gp_exr_core) {0};
    core->img = img;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = say_nothing;
    init.alloc_fn = gp_exr_allocate;
    init.write_fn = write_nowhere;
    if (exr_start_write(&core->ctxt, "nowhere", EXR_WRITE_FILE_DIRECTLY,
                        &init) ||
        describe(core->ctxt, img)) {
        gp_exr_core_free(core);
        return NULL;
    }
    return core;
}

void gp_exr_core_free(struct gp_exr_core *core)
{
    if (!core)
        return;
    if (core->started)
        exr_encoding_destroy(core->ctxt, &core->pipe);
    if (core->ctxt)
        exr_finish(&core->ctxt);
    gp_free(core);
}

static exr_result_t pack(exr_encode_pipeline_t *pipe)
{
    struct gp_exr_core *core = pipe->encoding_user_data;
    size_t room = 0;
    for (int c = 0; c < pipe->channel_count; c++) {
        const exr_coding_channel_info_t *i = &pipe->channels[c];
        room += (size_t) i->width * (size_t) i->height *
                (size_t) i->bytes_per_element;
    }
    if (gp_exr_pack(core->img, core->y0, core->y1, NULL, NULL) != room)
        return EXR_ERR_INVALID_ARGUMENT;
    pipe->packed_bytes = gp_exr_pack(core->img, core->y0, core->y1,
                                     pipe->packed_buffer, core->clamped);
    return EXR_ERR_SUCCESS;
}

static exr_result_t prepare(struct gp_exr_core *core)
{
    exr_encode_pipeline_t *pipe = &core->pipe;
    exr_chunk_info_t chunk;
    exr_result_t r =
        exr_write_scanline_chunk_info(core->ctxt, 0, core->y0, &chunk);
    if (!r && core->started)
        return exr_encoding_update(core->ctxt, 0, &chunk, pipe);
    if (!r)
        r = exr_encoding_initialize(core->ctxt, 0, &chunk, pipe);
    if (r)
        return r;
    core->started = true;
    for (int c = 0; c < pipe->channel_count; c++) {
        // asked for by the library, not read by pack()
        pipe->channels[c].encode_from_ptr = (const uint8_t *) core;
        pipe->channels[c].user_pixel_stride = 4;
        pipe->channels[c].user_line_stride = 4;
    }
    r = exr_encoding_choose_default_routines(core->ctxt, 0, pipe);
    pipe->encoding_user_data = core;
    pipe->convert_and_pack_fn = pack;
    pipe->yield_until_ready_fn = NULL;
    pipe->write_fn = NULL;
    return r;
}

gp_status gp_exr_core_run(struct gp_exr_core *core, int y0, int y1,
                          const void **out, size_t *size, long long *clamped)
{
    core->y0 = y0;
    core->y1 = y1;
    core->clamped = clamped;
    gp_exr_fault_clear();
    if (prepare(core) || exr_encoding_run(core->ctxt, 0, &core->pipe))
        return gp_exr_fault() ? gp_exr_fault() : GP_ERR_USAGE;
    const exr_encode_pipeline_t *pipe = &core->pipe;
    // a chunk that did not shrink is stored as it is, and readers know such
    // a chunk by its size alone; 3.1.5 forgets that for the equal size
    const bool raw = pipe->compressed_bytes >= pipe->packed_bytes;
    *out = raw ? pipe->packed_buffer : pipe->compressed_buffer;
    *size = raw ? (size_t) pipe->packed_bytes : pipe->compressed_bytes;
    return GP_OK;
}
