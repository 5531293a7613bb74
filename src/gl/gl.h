/* gl: headless OpenGL 4.5 core contexts, programs, textures, framebuffers.
 *
 * Float planes in, float planes out; nothing here knows what is drawn.
 *   gl.h       a context                     context.c, osmesa.c, egl.c
 *   texture.h  float textures and targets    texture.c, target.c
 *   block.h    uniform blocks                block.c
 *   list.h     long lists for shaders        list.c
 *   program.h  shaders and draws             program.c, shaders/
 * Libraries come by dlopen, functions by the context's own GetProcAddress,
 * from one list of names (functions.h).
 *
 * A context belongs to the thread that opened it. Several may live at once;
 * gp_gl_use() says which one the calls that follow are for.
 *
 * Environment:
 *   GLAREPP_OSMESA, GLAREPP_EGL  file to open in place of libOSMesa / libEGL
 *   GLAREPP_GL_MAX_SIZE          lowers gp_gl_max_size(), for tests of tiling
 *   LP_NUM_THREADS               Mesa's own: threads of its CPU rasterizer;
 *                                gp_threads() when it is not set
 *   EGL_LOG_LEVEL                Mesa's own: "fatal" when it is not set
 */
#ifndef GP_GL_GL_H
#define GP_GL_GL_H

#include "core/status.h"

#include <stdbool.h>

struct gp_gl; // a context with its function table

/* AUTO takes OSMesa, and EGL where there is no OSMesa: frames then come out
 * with the same bytes on every machine of a farm, with or without a GPU. A
 * GPU is used when it is asked for, by EGL. */
enum gp_gl_api { GP_GL_API_AUTO, GP_GL_API_OSMESA, GP_GL_API_EGL };

/* Puts what Mesa reads of the environment into it, where the user did not:
 * after gp_set_threads() and before any other thread, since one that asks for a
 * variable while another is added may read memory that is gone. Without it
 * Mesa takes as many threads as there are processors, and warns on stderr. */
void gp_gl_prepare(void);

/* Makes a context and makes it current on the calling thread.
 * EGL takes the device platform when a device that is no software
 * rasterizer answers, else Mesa's surfaceless platform.
 *
 *   out  written only on GP_OK; free with gp_gl_close()
 *
 * Errors: GP_ERR_GL names the library that is missing and its Debian package
 * (libosmesa6; libegl1 and libegl-mesa0), or the version that was found when
 * GL is under 4.5.
 */
GP_MUST_CHECK gp_status gp_gl_open(const struct gp_log *log,
                                   enum gp_gl_api api, struct gp_gl **out);

/* Frees the context and sets *gl to NULL; NULL in *gl is fine. The libraries
 * stay loaded: their drivers do not survive an unloading. */
void gp_gl_close(struct gp_gl **gl);

/* Makes `gl` current on its thread; costs nothing when it is already. */
GP_MUST_CHECK gp_status gp_gl_use(const struct gp_log *log,
                                  const struct gp_gl *gl);

/* "OSMesa: llvmpipe (LLVM 15.0.6, 256 bits)", owned by the context. */
const char *gp_gl_name(const struct gp_gl *gl);

/* True for a rasterizer that runs on the CPU (llvmpipe, softpipe, swrast). */
bool gp_gl_is_software(const struct gp_gl *gl);

/* The widest and highest texture and target, in pixels: the least of
 * GL_MAX_TEXTURE_SIZE, GL_MAX_VIEWPORT_DIMS and GLAREPP_GL_MAX_SIZE. */
int gp_gl_max_size(const struct gp_gl *gl);

/* The widest point in pixels, >= 1: gl_PointSize over it is drawn smaller.
 * GL_POINT_SIZE_RANGE. */
float gp_gl_point_size_max(const struct gp_gl *gl);

/* The largest uniform block in bytes, at least 16384, which is what every GL
 * of 4.5 has; GL_MAX_UNIFORM_BLOCK_SIZE. */
int gp_gl_block_max(const struct gp_gl *gl);

/* The most texels of a list, at least 65536; GL_MAX_TEXTURE_BUFFER_SIZE. */
int gp_gl_list_max(const struct gp_gl *gl);

/* GP_ERR_GL with a line that says what GL's error flag holds and while doing
 * `what`; clears the flag. */
GP_MUST_CHECK gp_status gp_gl_check(const struct gp_log *log,
                                    const struct gp_gl *gl, const char *what);

#endif
