/* The files of src/gl/shaders, byte for byte; the Makefile makes the list. */
#ifndef GP_GL_SHADERS_H
#define GP_GL_SHADERS_H

struct gp_shader_file {
    const char *name; // "splat.vert"
    const char *text; // GLSL without #version
};
extern const struct gp_shader_file gp_shader_files[]; // name NULL ends

#endif
