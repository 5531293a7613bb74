/* A frame's planes as a picture for formats that show the display window. */
#ifndef GP_IO_PICTURE_H
#define GP_IO_PICTURE_H

#include "io/frame.h"
#include "core/status.h"
#include "io/write.h"

#include <stdint.h>

/* Makes linear light or encoded values codes 0 .. max. */
struct gp_quantizer {
    int max;            // 255 or 65535
    bool curve, dither; // sRGB's; without it values are encoded already
};

/* Makes n samples codes. NaN and values below 0 become 0, values over 1 the
 * largest.
 *
 * Without dither the nearest code: with the curve exactly
 * (int) (gp_srgb_encode(value[i]) * max + 0.5f) for every float. With it
 * floor(encoded * max + d), where d in [0, 1) depends on the pixel's place
 * only, so a picture has the same bytes whoever writes it, and grey stays
 * grey. Over an area of one value the mean of the codes is the encoded value.
 *
 *   x, y  place of value[0] in the picture
 *
 * d is interleaved gradient noise: Jimenez, "Next Generation Post Processing
 * in Call of Duty: Advanced Warfare", SIGGRAPH 2014 courses, in fixed point,
 * so that its low bits count in wide pictures too. */
void gp_quantize(const struct gp_quantizer *q, const float *value, int x, int y,
                 uint16_t *code, size_t n);

/* Scratch for one row. */
struct gp_picture_row {
    uint16_t *code[4];  // width codes of each channel
    float *linear[4];   // the same as values, for gp_picture_floats()
};

struct gp_picture {
    int width, height;  // of the display window
    int channels;       // 3, or 4 with alpha
    int bits;           // of a code, 8 or 16
    bool associated;    // codes of colour are not divided by alpha
    const struct gp_frame *f;
    const struct gp_planes *planes;
    float *alpha;       // of the data window, or NULL
    struct gp_quantizer quantizer;
};

/* Prepares rows of `planes`.
 *
 *   p     depth_bits, dither and alpha are used. Without GP_ALPHA_BLACK, and
 *         with an alpha channel beside the colour, the picture has four
 *         channels
 *   kind  GP_PICTURE_ENCODED planes become codes without a curve
 *   out   empty on failure; free with gp_picture_free()
 *
 * Errors: GP_ERR_DATA an empty display window, or one of more than 2^40
 * pixels (those of files are bounded by --max-pixels when they are read);
 * GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_picture_make(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const struct gp_frame *f,
    const struct gp_planes *planes, enum gp_picture_kind kind,
    struct gp_picture *out);
void gp_picture_free(struct gp_picture *pic);

/* Runs body(ctx, y, row) once for each row y of the picture, in parallel and in
 * any order. `row` is scratch of this call only, for gp_picture_codes() or
 * gp_picture_floats(); it starts with an earlier row's content. A body writes
 * nothing that another y reads and prints nothing. Errors: GP_ERR_BUG out of
 * memory; then no body has run. */
typedef void (*gp_picture_body)(void *ctx, int y, struct gp_picture_row *row);
GP_MUST_CHECK gp_status gp_picture_each_row(const struct gp_log *log,
    const struct gp_picture *pic, gp_picture_body body, void *ctx);

/* Row y of the display window, 0 at its top, as codes in row->code: sRGB, or
 * what an encoded picture has.
 * Pixels outside the data window are 0 in all channels.
 *
 * With alpha the colours are not associated, as PNG wants them. A pixel may
 * hold more light than its opacity A lets through, above all where A is 0 and
 * glare shines over an empty background. Alpha is raised to the largest
 * component there: a = max(A, R, G, B), each clamped to [0, 1], so that
 * colour / a stays within 1 and the picture put over black is, pixel by
 * pixel, the picture without alpha. With GP_ALPHA_ASSOCIATED the colours are
 * those of the picture without alpha, with A beside them. */
void gp_picture_codes(const struct gp_picture *pic, int y,
                      struct gp_picture_row *row);

/* The same row as values as they are, associated alpha, in row->linear. */
void gp_picture_floats(const struct gp_picture *pic, int y,
                       struct gp_picture_row *row);

#endif
