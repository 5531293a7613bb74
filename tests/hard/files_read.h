/* Plain readers of the display formats, by their specifications. */
#ifndef GP_TESTS_HARD_FILES_READ_H
#define GP_TESTS_HARD_FILES_READ_H

#include <stddef.h>
#include <stdint.h>

/* w * h * 3 samples, R, G, B, rows from the top: codes of integer formats as
 * numbers, floats as they are. The caller frees `v`. */
struct hard_picture {
    int w, h; // raw frames: given by the caller
    float *v;
};

/* All bytes of a file; the caller frees. */
uint8_t *hard_read_bytes(const char *path, size_t *size);

/* Each ends the program when the file is not of its format. */
void hard_read_png(const char *path, struct hard_picture *out);
void hard_read_pfm(const char *path, struct hard_picture *out);
void hard_read_rgb24(const char *path, struct hard_picture *out);
void hard_read_rgb48le(const char *path, struct hard_picture *out);
void hard_read_rgb48be(const char *path, struct hard_picture *out);
void hard_read_rgbf32le(const char *path, struct hard_picture *out);

/* By OpenImageIO: its fractions of the largest code become codes of 8 or 16
 * bits. A fourth channel must be opaque. */
void hard_read_8(const char *path, struct hard_picture *out);
void hard_read_16(const char *path, struct hard_picture *out);

#endif
