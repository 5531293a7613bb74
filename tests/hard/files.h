/* Plain readers of the display formats, by their specifications. */
#ifndef GP_TESTS_HARD_FILES_H
#define GP_TESTS_HARD_FILES_H

#include <stddef.h>
#include <stdint.h>

/* w * h * 3 samples, R, G, B, rows from the top: codes of integer formats as
 * numbers, floats as they are. The caller frees `v`. */
struct hard_picture {
    int w, h; // raw frames: given by the caller
    float *v;
};

enum hard_form {
    HARD_EXR, // not read here
    HARD_PNG, HARD_PFM,
    HARD_RGB24, HARD_RGB48LE, HARD_RGB48BE, HARD_RGBF32LE, // raw frames
    // by OpenImageIO, whose fractions of the largest code become codes; a
    // fourth channel must be opaque
    HARD_OIIO_8, HARD_OIIO_16,
};

/* All bytes of a file; the caller frees. */
uint8_t *hard_read_bytes(const char *path, size_t *size);

/* Ends the program when the file is not of its format. */
void hard_read(const char *path, enum hard_form form, struct hard_picture *out);

#endif
