/* Shader programs, and the one way to draw with them. */
#ifndef GP_GL_PROGRAM_H
#define GP_GL_PROGRAM_H

#include "core/frame.h"
#include "gl/gl.h"
#include "gl/shaders.h"
#include "gl/texture.h"

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

/* The same from texts that need not be files. */
GP_MUST_CHECK gp_status gp_program_from_text(const struct gp_log *log,
                                             const struct gp_gl *gl,
                                             const struct gp_shader_file *vert,
                                             const struct gp_shader_file *frag,
                                             struct gp_program *out);
void gp_program_free(const struct gp_gl *gl, struct gp_program *p);

/* An `ivec2` uniform, or a `sampler2D` one when `texture` is set. */
struct gp_uniform {
    const char *name;
    int v[2];
    const struct gp_texture *texture;
};

/* Triangles without vertex buffers: shaders make all from gl_VertexID and
 * gl_InstanceID. Fragments add to the target: GL_ONE, GL_ONE. */
struct gp_draw {
    const struct gp_program *program;
    const struct gp_target *target;
    struct gp_rect cut;                // pixels outside stay; cut to target
    const struct gp_uniform *uniform;  // name NULL ends
    int vertices, instances;
};

/* Errors: GP_ERR_BUG a uniform that the program does not use. GL's own error
 * flag is for the caller to look at, once for many draws. */
GP_MUST_CHECK gp_status gp_draw_add(const struct gp_log *log,
                                    const struct gp_gl *gl,
                                    const struct gp_draw *draw);

#endif
