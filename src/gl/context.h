/* What a context is made of; only src/gl includes this. */
#ifndef GP_GL_CONTEXT_H
#define GP_GL_CONTEXT_H

#include "gl/functions.h"
#include "gl/gl.h"

/* A way to get a headless context. */
struct gp_gl_system {
    const char *name;

    /* Makes a context, 4.5 core where that can be had, else of any version
     * so that the caller can say which one was found. Not yet current.
     * *window is the system's own, and freed by close(). */
    gp_status (*open)(const struct gp_log *log, void **window);
    bool (*make_current)(void *window); // false: the system refused
    void (*release)(void *window);      // no context is current after it
    void (*close)(void *window);        // it is not current then
    void (*(*proc)(void *window, const char *name))(void);
};
extern const struct gp_gl_system gp_gl_osmesa, gp_gl_egl;

struct gp_gl {
    const struct gp_gl_system *system;
    void *window;
    struct gp_gl_functions f;
    GLuint vertex_array; // core profile draws nothing without one
    int max_size, max_block, max_list;
    float max_point;
    bool software;
    char name[160];
};

/* Makes `gl` current before its objects are deleted: their names may be those
 * of another context's. False where the system refuses it; objects end with
 * their context all the same. */
bool gp_gl_reach(const struct gp_gl *gl);

/* Opens `name[0]`, else `name[1]`, ... (NULL ends), or only the file that the
 * environment variable `env` names. NULL, and a GP_ERR_GL line that names
 * the library and the Debian `package`, when none opens. */
void *gp_gl_library(const struct gp_log *log, const char *env,
                    const char *const name[], const char *package);

#endif
