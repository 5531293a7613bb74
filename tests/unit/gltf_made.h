// SPDX-License-Identifier: Apache-2.0
/* glTF files for tests, in the one file of folder.h: JSON where ' stands for ",
 * with buffers of numbers as data URIs. */
#ifndef GP_TESTS_GLTF_MADE_H
#define GP_TESTS_GLTF_MADE_H

#include "folder.h"
#include "kept_log.h"
#include "scene/gltf/gltf.h"
#include "unit.h"

/* Returns "data:...;base64,..." of bytes, in memory that the next 8 calls
 * keep. */
static inline const char *gm_uri(const void *bytes, size_t n)
{
    static const char digits[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    static char text[8][4096];
    static int turn;
    char *const out = text[turn++ % 8], *to = out;
    const uint8_t *const p = bytes;
    to += sprintf(to, "data:application/octet-stream;base64,");
    for (size_t i = 0; i < n; i += 3) {
        unsigned v = 0;
        for (size_t k = 0; k < 3; k++)
            v = v << 8 | (i + k < n ? p[i + k] : 0);
        for (size_t k = 0; k < 4; k++)
            *to++ = i + k > n ? '=' : digits[v >> (18 - 6 * k) & 63];
    }
    *to = '\0';
    return out;
}

/* Writes a file of the folder and returns its path. */
static inline const char *gm_write_bytes(const char *name, const void *bytes,
                                         size_t n)
{
    FILE *f = fopen(in_folder(name), "wb");
    if (!f || fwrite(bytes, 1, n, f) != n)
        abort();
    fclose(f);
    kept_clear();
    return path;
}

/* Writes a.gltf: {"asset": {"version": "2.0"}, ...} of a format. */
GP_PRINTF(1, 2)
static inline const char *gm_write(const char *format, ...)
{
    static char text[32768], all[33000];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    const int n = snprintf(all, sizeof all, "{'asset': {'version': '2.0'}, %s}",
                           text);
    for (char *c = all; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    return gm_write_bytes("a.gltf", all, (size_t) n);
}

/* A triangle whose places are the 36 bytes of a .glb's second chunk. */
#define GM_GLB_JSON                                                           \
    "{'asset': {'version': '2.0'}, 'buffers': [{'byteLength': 36}], "         \
    "'bufferViews': [{'buffer': 0, 'byteLength': 36}], 'accessors': [{"       \
    "'bufferView': 0, 'componentType': 5126, 'count': 3, 'type': 'VEC3'}], "  \
    "'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}]}], 'nodes'"  \
    ": [{'mesh': 0}]}"

/* Writes a.glb of chunks, whose header declares `declared` bytes; 0: its own.
 */
static inline const char *gm_write_glb(const char *json, const void *bin,
                                       uint32_t n, uint32_t declared)
{
    uint8_t all[4096];
    char text[2048];
    const uint32_t length = (uint32_t) snprintf(text, sizeof text, "%s", json);
    for (char *c = text; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    const uint32_t padded = (length + 3) & ~3u;
    const uint32_t head[5] = {0x46546c67, 2,
                              declared ? declared : 28 + padded + n, padded,
                              0x4e4f534a};
    const uint32_t second[2] = {n, 0x004e4942};
    memcpy(all, head, 20);
    memset(all + 20, ' ', padded);
    memcpy(all + 20, text, length);
    memcpy(all + 20 + padded, second, 8);
    memcpy(all + 28 + padded, bin, n);
    return gm_write_bytes("a.glb", all, 28 + padded + n);
}

/* Reads a file that is wrong: one line with `part`, and that status. */
static inline void gm_refused(const char *file, gp_status status,
                              const char *part)
{
    struct gp_scene s = {.objects = 77};
    const gp_status st = gp_scene_read(&kept_log, file, GLAREPP_UP_Y, NULL, &s);
    if (st != status || kept_errors != 1)
        fail_msg("status %d, %d lines (%s); expected %d with \"%s\"", (int) st,
                 kept_errors, kept_line, (int) status, part);
    assert_kept(part);
    assert_int_equal(s.objects, 77); // as it was
}

/* Reads a file without its images. */
static inline struct gp_scene gm_read(const char *file, enum glarepp_up up)
{
    struct gp_scene s = {0};
    const gp_status st = gp_scene_read(&kept_log, file, up, NULL, &s);
    if (st)
        fail_msg("%s", kept_line);
    return s;
}

#endif
