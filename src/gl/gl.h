// SPDX-License-Identifier: Apache-2.0
/* Headless OpenGL 4.5 core: contexts, textures, programs, draws.
 *
 * A context belongs to the thread that opened it. Several may live at once;
 * gp_gl_use() selects the one for the calls that follow.
 * Files and the largest size are those of gp_env(). */
#ifndef GP_GL_GL_H
#define GP_GL_GL_H

#include "core/image.h"
#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>

/* -- contexts -------------------------------------------------------------- */

struct gp_gl; // a context with its function table

/* AUTO takes OSMesa, and EGL, which may be a GPU, only where OSMesa is missing:
 * frames have the same bytes on every machine of a farm. */
enum gp_gl_api { GP_GL_AUTO, GP_GL_OSMESA, GP_GL_EGL };

/* Makes a context, current on the calling thread. EGL takes the first device that
 * is no software rasterizer, else Mesa's surfaceless platform.
 *   out  written only on GP_OK; free with gp_gl_close()
 * Errors: GP_ERR_GL names the library that is missing and its Debian package, or
 * the version that was found when GL is under 4.5. */
GP_MUST_CHECK gp_status gp_gl_open(const struct gp_log *log,
                                   enum gp_gl_api api, struct gp_gl **out);

/* Frees the context and sets *gl to NULL; NULL in *gl is fine. The libraries
 * stay loaded: their drivers do not survive an unloading. */
void gp_gl_close(struct gp_gl **gl);

/* Makes `gl` current on its thread; costs nothing when it is already. */
GP_MUST_CHECK gp_status gp_gl_use(const struct gp_log *log,
                                  const struct gp_gl *gl);

/* Properties of a context, owned by it. */
struct gp_gl_info {
    char name[160];       // "OSMesa: llvmpipe (LLVM 15.0.6, 256 bits)"
    bool software;        // rasterizes on the CPU: llvmpipe, softpipe, swrast
    int max_size;         // of textures and targets, in pixels: the least of
                          // GL_MAX_TEXTURE_SIZE, GL_MAX_VIEWPORT_DIMS and
                          // gp_env()->gl_size
    int max_block;        // of a uniform block, in bytes, >= 16384;
                          // GL_MAX_UNIFORM_BLOCK_SIZE
    int max_texel_buffer; // in texels, >= 65536; GL_MAX_TEXTURE_BUFFER_SIZE
};
const struct gp_gl_info *gp_gl_info(const struct gp_gl *gl);

/* Returns GP_ERR_GL with a line that names GL's error flag and `what` was being
 * done; clears the flag. */
GP_MUST_CHECK gp_status gp_gl_check(const struct gp_log *log,
                                    const struct gp_gl *gl, const char *what);

/* -- textures and targets --------------------------------------------------
 *
 * Row 0 of a texture is the first row given: images keep y down, and nothing
 * is flipped on the way in or out. All calls are for the current context;
 * `what` names the object in messages. What is made goes to `out`, which is zero
 * or from such a call before: one of the kind and, of textures and targets, as
 * large or larger is kept. After an error it is as it was, or empty.
 */

/* Four numbers a texel, red first; of CODE one.
 *   FLOAT   RGBA32F, not clamped; read by texelFetch or imageLoad
 *   BYTE    RGBA8: [0, 1] in 255ths, and sums are rounded too; texelFetch
 *   CODE    R16UI: whole numbers up to 65535, texelFetch of a usampler2D; not
 *           of targets
 *   DEPTH   of a target: FLOAT, and a depth buffer of 32-bit floats. Depth is
 *           reversed: 1 at the near plane, 0 infinitely far, so that near /
 *           distance keeps the precision of its float at every distance */
enum gp_texel { GP_TEXEL_FLOAT, GP_TEXEL_BYTE, GP_TEXEL_CODE, GP_TEXEL_DEPTH };

struct gp_texture {
    unsigned id; // 0: empty
    int w, h;
};

/* Makes a texture of w x h texels, not cleared. Errors: GP_ERR_GL sizes under 1 or
 * over max_size (names the limit), out of memory. */
GP_MUST_CHECK gp_status gp_texture_make(const struct gp_log *log,
    const struct gp_gl *gl, const char *what, enum gp_texel kind, int w, int h,
    struct gp_texture *out);

/* Writes the texels of `rect`, which is inside the texture, from packed
 * rows of rgba: 4 * w * h floats. */
void gp_texture_write(const struct gp_gl *gl, const struct gp_texture *t,
                      struct gp_rect rect, const float *rgba);

/* Writes all of a texture of GP_TEXEL_CODE from w * h codes. */
void gp_texture_write_codes(const struct gp_gl *gl, const struct gp_texture *t,
                            const uint16_t *code);
void gp_texture_free(const struct gp_gl *gl, struct gp_texture *t);

enum { GP_ATTACHMENTS = 8 }; // of a target, at most; every GL of 4.5 has 8

/* Textures of one size that can be drawn to. */
struct gp_target {
    unsigned framebuffer; // 0: empty
    struct gp_texture colour;                    // attachment 0
    struct gp_texture more[GP_ATTACHMENTS - 1];  // attachments 1, 2, ...
    int n;                                       // attachments in use
    struct gp_texture
        depth; // of DEPTH; red of a texture while nothing draws to it
    int w, h;
};

/* Makes a target of w x h pixels with n attachments (1 to GP_ATTACHMENTS, or 0
 * with depth; a fragment's outputs at locations 0 to n - 1 go to them), not
 * cleared. Errors as for textures, and where the driver cannot draw to such texels. */
GP_MUST_CHECK gp_status gp_target_make(const struct gp_log *log,
    const struct gp_gl *gl, const char *what, enum gp_texel kind, int n, int w,
    int h, struct gp_target *out);

/* Sets the pixels of `rect`, cut to the target, to 0 in all attachments; depth
 * to 0, infinitely far. */
void gp_target_clear(const struct gp_gl *gl, const struct gp_target *t,
                     struct gp_rect rect);

/* Waits for the drawing, then copies `rect` of an attachment, which is
 * inside the target, to `out`: 4 * w * h floats, rows packed; of
 * GP_DEPTH_ATTACHMENT w * h. */
enum { GP_DEPTH_ATTACHMENT = -1 };
void gp_target_read(const struct gp_gl *gl, const struct gp_target *t,
                    int attachment, struct gp_rect rect, float *out);
void gp_target_free(const struct gp_gl *gl, struct gp_target *t);

/* -- buffers that shaders read by index ------------------------------------ */

/* Entries of four floats.
 *   BLOCK   a uniform block: faster than a texture. Shaders declare it std140;
 *           arrays of vec4 have C's layout
 *   TEXELS  a buffer texture: RGBA32F texels in one row, more than a texture
 *           or a uniform block holds, read by imageLoad or texelFetch */
enum gp_buffer_kind { GP_BUFFER_BLOCK, GP_BUFFER_TEXELS };

struct gp_buffer {
    unsigned id;               // 0: empty
    struct gp_texture texture; // of TEXELS, one row
};

/* Makes a buffer of n entries, not cleared; *out is written whatever it was.
 * Errors: GP_ERR_GL n under 1 or over max_block / 16 or max_texel_buffer, out
 * of memory. */
GP_MUST_CHECK gp_status gp_buffer_make(const struct gp_log *log,
    const struct gp_gl *gl, const char *what, enum gp_buffer_kind kind, int n,
    struct gp_buffer *out);

/* Writes entries [first, first + n), which the buffer has, from 4 * n floats;
 * earlier draws read the old values. */
void gp_buffer_write(const struct gp_gl *gl, const struct gp_buffer *b,
                     int first, int n, const float *entry);
void gp_buffer_free(const struct gp_gl *gl, struct gp_buffer *b);

/* -- programs and draws ---------------------------------------------------- */

struct gp_program {
    unsigned id; // 0: empty
};

/* Compiles and links two files of src/gl/shaders, after common.glsl and `defines`:
 * "", or lines such as "#define COLOUR\n", by which one file is several programs.
 * Errors: GP_ERR_BUG no such file; GP_ERR_GL with the driver's log. */
GP_MUST_CHECK gp_status gp_program_make(const struct gp_log *log,
    const struct gp_gl *gl, const char *defines, const char *vert,
    const char *frag, struct gp_program *out);
void gp_program_free(const struct gp_gl *gl, struct gp_program *p);

/* One uniform of a program. The member that is set, one at most, decides:
 *   texture  sampler2D; of a buffer samplerBuffer
 *   image    layout(rgba32f) readonly image2D; of a buffer imageBuffer
 *   matrix   mat4 from 16 floats, m[4 * row + column] for row vectors as in
 *            core/camera.h: the shader's matrix * vec4
 *   block    uniform block of that name (the block's, not the instance's)
 *   floats   1, 2 or 4: float, vec2 or vec4 from f
 *   else     ivec2 from v */
struct gp_uniform {
    const char *name;
    int v[2];
    int floats;
    float f[4];
    const struct gp_texture *texture, *image;
    const struct gp_buffer *block;
    const float *matrix;
};

/* Test against a target's depth: fragments nearer than it, or as near, are
 * drawn. Clip coordinates then have z from 0 (infinitely far) to w (near). */
enum gp_depth_test {
    GP_DEPTH_OFF,
    GP_DEPTH_WRITE, // ... and their depth stays
    GP_DEPTH_READ,
    GP_DEPTH_SAME,  // only fragments as near as it are drawn
};

/* Triangles that are not drawn. The front is counter-clockwise with clip y
 * upwards, which is down in an image. */
enum gp_cull { GP_CULL_NONE, GP_CULL_BACK, GP_CULL_FRONT };

/* Triangles without vertex buffers: shaders make all from gl_VertexID (`first`
 * and on) and gl_InstanceID. Fragments add to the target: GL_ONE, GL_ONE; with
 * `replace` they are written as they are.
 *
 * `view` is what clip coordinates -1 to 1 span, in pixels of the target; all
 * zero is the target. It may reach beyond it, up to max_size wide and high. */
struct gp_draw {
    const struct gp_program *program;
    const struct gp_target *target;
    struct gp_rect cut;                // pixels outside stay; cut to target
    struct gp_rect view;
    const struct gp_uniform *uniform;  // name NULL ends
    int first, vertices, instances;
    enum gp_depth_test depth;
    enum gp_cull cull;
    int clips;          // gl_ClipDistance[] that the shader writes, all of
                        // them, up to 8
    bool replace;
};

/* Errors: GP_ERR_BUG a uniform that the program does not use. The caller checks
 * GL's own error flag, once for many draws. */
GP_MUST_CHECK gp_status gp_draw_run(const struct gp_log *log,
    const struct gp_gl *gl, const struct gp_draw *draw);

/* Counts the fragments that shaders work on between the two calls; waits for
 * the drawing. One count at a time; -1 without GL 4.6 and without
 * GL_ARB_pipeline_statistics_query. */
void gp_count_begin(const struct gp_gl *gl);
long long gp_count_end(const struct gp_gl *gl);

#endif
