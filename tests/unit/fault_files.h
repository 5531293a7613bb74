/* The files that test_faults.c reads: EXR parts of every kind, and JSON. */
#ifndef FAULT_FILES_H
#define FAULT_FILES_H

#include "exr_fixture.h"
#include "write_fixture.h"

#define HALVES EXR_PIXEL_HALF
#define W(n) FIXTURE_WINDOW(0, 0, n, n)

/* Planes of several kinds beside the colour. */
static const struct fixture parts = {
    .parts = 2,
    .part = {
        {.name = "main",
         .channel = {HALF_CH("A"), RGB(HALVES),
                     {"Z", EXR_PIXEL_FLOAT, 0, 0}, HALF_CH("fog.B"),
                     HALF_CH("fog.G"), HALF_CH("fog.R"),
                     {"id", EXR_PIXEL_UINT, 0, 0}},
         .data = W(12), .compression = EXR_COMPRESSION_ZIP},
        {.name = "one.left",
         .channel = {{"mask", EXR_PIXEL_FLOAT, 0, 0},
                     {"wide", EXR_PIXEL_HALF, 2, 2}},
         .data = FIXTURE_WINDOW(-4, 8, 6, 16),
         .compression = EXR_COMPRESSION_RLE},
    },
};
static const struct fixture tiles = {
    .part = {{.channel = {RGB(EXR_PIXEL_FLOAT)}, .data = W(20), .tile = 8,
              .compression = EXR_COMPRESSION_ZIP, .mipmap = true}},
};
static const struct fixture yc = {
    .part = {{.channel = {{"BY", HALVES, 2, 2}, {"RY", HALVES, 2, 2},
                          {"Y", HALVES, 1, 1}},
              .data = W(12), .compression = EXR_COMPRESSION_PIZ}},
};
static const struct fixture depth = {
    .part = {{.channel = {{"Z", EXR_PIXEL_FLOAT, 0, 0}}, .data = W(9),
              .compression = EXR_COMPRESSION_ZIPS}},
};

static void save_text(const char *name, const char *text)
{
    fixture_save(wf_path(name), text, strlen(text));
}

static void save_twice(const char *name, const struct fixture *f)
{
    size_t size;
    uint8_t *bytes = fixture_make(f, &size);
    FILE *file = fopen(wf_path(name), "wb");
    assert_non_null(file);
    for (int i = 0; i < 2; i++)
        assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    free(bytes);
}

static void save_json(void)
{
    save_text("lights.json",
              "[{\"pixel\": [1, 2], \"radius\": 2, \"flux\": [1, 2, 3]},"
              " {\"direction\": [0, 1, 0], \"flux\": 3}]");
    save_text("flare.json",
              "{\"elements\": [{\"shape\": \"disc\", \"position\": 1,"
              " \"size\": 0.1, \"color\": 1}, {\"shape\": \"image\","
              " \"position\": 0, \"size\": 1, \"image\": \"a.exr\"}]}");
    save_text("camera.json",
              "{\"frames\": [{\"frame\": 1, \"worldToNDC_rowmajor\": [1,0,0,0,"
              " 0,1,0,0, 0,0,1,-1, 0,0,0,1]}]}");
}

#endif
