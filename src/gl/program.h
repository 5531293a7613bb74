/* Shader programs, and the one way to draw with them. */
#ifndef GP_GL_PROGRAM_H
#define GP_GL_PROGRAM_H

#include "core/frame.h"
#include "gl/block.h"
#include "gl/gl.h"
#include "gl/list.h"
#include "gl/shaders.h"
#include "gl/texture.h"

#include <stdbool.h>

struct gp_program {
    unsigned id; // 0: empty
};

/* Compiles and links two files of src/gl/shaders. The driver gets "#version
 * 450 core", common.glsl, and the file from "#line 1" on, so that its
 * messages point at the file.
 *   out  written only on GP_OK; free with gp_program_free()
 * Errors: GP_ERR_BUG no such file; GP_ERR_GL with the driver's log.
 */
GP_MUST_CHECK gp_status gp_program_make(const struct gp_log *log,
                                        const struct gp_gl *gl,
                                        const char *vert, const char *frag,
                                        struct gp_program *out);

/* The same with lines put before both files: "#define COLOUR\n". One file
 * can so be several programs. */
GP_MUST_CHECK gp_status gp_program_make_as(const struct gp_log *log,
                                           const struct gp_gl *gl,
                                           const char *defines,
                                           const char *vert, const char *frag,
                                           struct gp_program *out);

/* The same from texts that need not be files. */
GP_MUST_CHECK gp_status gp_program_from_text(const struct gp_log *log,
                                             const struct gp_gl *gl,
                                             const char *defines,
                                             const struct gp_shader_file *vert,
                                             const struct gp_shader_file *frag,
                                             struct gp_program *out);
void gp_program_free(const struct gp_gl *gl, struct gp_program *p);

/* One uniform of a program. What is set, one at most, says what it is:
 *   texture  sampler2D
 *   image    layout(rgba32f) readonly image2D
 *   list     layout(rgba32f) readonly imageBuffer
 *   block    uniform block of that name (the block's, not the instance's)
 *   floats   1, 2 or 4: float, vec2 or vec4 from f
 *   else     ivec2 from v */
struct gp_uniform {
    const char *name;
    int v[2];
    int floats;
    float f[4];
    const struct gp_texture *texture, *image;
    const struct gp_list *list;
    const struct gp_block *block;
};

/* Triangles (or points) without vertex buffers: shaders make all from
 * gl_VertexID and gl_InstanceID. Fragments add to the target: GL_ONE, GL_ONE;
 * with `replace` they are written as they are.
 *
 * `view` is what clip coordinates -1 to 1 span, in pixels of the target; all
 * zero is the target. It may reach beyond the target, up to gp_gl_max_size()
 * wide and high: a point whose centre is outside of it is not drawn at all.
 */
struct gp_draw {
    const struct gp_program *program;
    const struct gp_target *target;
    struct gp_rect cut;                // pixels outside stay; cut to target
    struct gp_rect view;
    const struct gp_uniform *uniform;  // name NULL ends
    int vertices, instances;
    bool replace;
    bool points; // a vertex is a square of gl_PointSize pixels, at most
                 // gp_gl_point_size_max(); pixels know theirs by gl_FragCoord
};

/* Errors: GP_ERR_BUG a uniform that the program does not use. GL's own error
 * flag is for the caller to look at, once for many draws. */
GP_MUST_CHECK gp_status gp_draw_run(const struct gp_log *log,
                                    const struct gp_gl *gl,
                                    const struct gp_draw *draw);

#endif
