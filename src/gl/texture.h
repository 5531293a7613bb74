/* Float textures and the targets that are drawn to.
 *
 * Row 0 of a texture is the first row given: images keep y down, and nothing
 * is flipped on the way in or out. All calls are for the current context.
 */
#ifndef GP_GL_TEXTURE_H
#define GP_GL_TEXTURE_H

#include "core/frame.h"
#include "gl/gl.h"

/* RGBA32F: four floats a texel, red first, not clamped; or RGBA8. */
struct gp_texture {
    unsigned id; // 0: empty
    int w, h;
};

enum { GP_ATTACHMENTS = 8 }; // of a target, at most; every GL of 4.5 has 8

/* Textures of one size that can be drawn to. */
struct gp_target {
    unsigned framebuffer; // 0: empty
    struct gp_texture colour;                    // attachment 0
    struct gp_texture more[GP_ATTACHMENTS - 1];  // attachments 1, 2, ...
    int n;                                       // attachments in use
};

/* Makes a texture of w x h texels, not cleared; `what` is for the message.
 * Read by texelFetch or imageLoad only: no filter, no mipmap, no wrapping.
 *   out  written only on GP_OK; free with gp_texture_free()
 * Errors: GP_ERR_GL sizes under 1 or over gp_gl_max_size() (names the limit),
 *         out of memory.
 */
GP_MUST_CHECK gp_status gp_texture_make(const struct gp_log *log,
                                        const struct gp_gl *gl,
                                        const char *what, int w, int h,
                                        struct gp_texture *out);

/* The same for a texture that is also sampled: GL_LINEAR between texel
 * centres, and clamped to the edge. */
GP_MUST_CHECK gp_status gp_texture_make_linear(const struct gp_log *log,
                                               const struct gp_gl *gl,
                                               const char *what, int w, int h,
                                               struct gp_texture *out);

/* RGBA8 in place of RGBA32F: [0, 1] in 255ths. Read by texelFetch only. */
GP_MUST_CHECK gp_status gp_texture_make_byte(const struct gp_log *log,
                                             const struct gp_gl *gl,
                                             const char *what, int w, int h,
                                             struct gp_texture *out);

/* Writes the texels of `rect`, which lies inside the texture, from packed
 * rows of rgba: 4 * w * h floats. */
void gp_texture_write(const struct gp_gl *gl, const struct gp_texture *t,
                      struct gp_rect rect, const float *rgba);
void gp_texture_free(const struct gp_gl *gl, struct gp_texture *t);

/* Makes a target of w x h pixels, not cleared. Errors as for textures, and
 * GP_ERR_GL when the driver cannot draw to RGBA32F. */
GP_MUST_CHECK gp_status gp_target_make(const struct gp_log *log,
                                       const struct gp_gl *gl,
                                       const char *what, int w, int h,
                                       struct gp_target *out);

/* The same with n attachments, 1 to GP_ATTACHMENTS: a fragment's outputs at
 * locations 0 to n - 1 go to them. */
GP_MUST_CHECK gp_status gp_target_make_many(const struct gp_log *log,
                                            const struct gp_gl *gl,
                                            const char *what, int w, int h,
                                            int n, struct gp_target *out);

/* The same with one attachment whose texture is also sampled, as by
 * gp_texture_make_linear(). */
GP_MUST_CHECK gp_status gp_target_make_linear(const struct gp_log *log,
                                              const struct gp_gl *gl,
                                              const char *what, int w, int h,
                                              struct gp_target *out);

/* The same with one attachment of RGBA8: what is drawn or added is clamped to
 * [0, 1] and rounded to 255ths, and so are sums. */
GP_MUST_CHECK gp_status gp_target_make_byte(const struct gp_log *log,
                                            const struct gp_gl *gl,
                                            const char *what, int w, int h,
                                            struct gp_target *out);

/* The pixels of `rect`, cut to the target, become 0 in all attachments. */
void gp_target_clear(const struct gp_gl *gl, const struct gp_target *t,
                     struct gp_rect rect);

/* Waits for the drawing, then copies `rect`, which lies inside the target, to
 * rgba: 4 * w * h floats, rows packed. */
void gp_target_read(const struct gp_gl *gl, const struct gp_target *t,
                    struct gp_rect rect, float *rgba);

/* The same from attachment 0 to n - 1; gp_target_read() is from 0. */
void gp_target_read_from(const struct gp_gl *gl, const struct gp_target *t,
                         int attachment, struct gp_rect rect, float *rgba);
void gp_target_free(const struct gp_gl *gl, struct gp_target *t);

#endif
