// SPDX-License-Identifier: Apache-2.0
/* The file: chunks of a .glb, JSON, data URIs, the file beside. */
#include "scene/gltf/gltf_priv.h"

#include "core/bytes.h"
#include "core/memory.h"

#include <ctype.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MOST_FILE = INT_MAX - 1, // bytes; numbers of bytes fit an int
    GLB_HEADER = 12,
    CHUNK_HEADER = 8,
    GLB_JSON = 0x4e4f534a,
    GLB_BINARY = 0x004e4942,
    MOST_FIXED = 64 << 20,
    MOST_COPIES = 32,
    MOST_JSON = 1 << 30, // bytes of values beside the text: 1e6 nodes, 4 s
};

/* All lists that the reader knows. */
static const char *const lists[] = {
    "accessors", "animations", "buffers",   "bufferViews", "cameras",  "images",
    "materials", "meshes",     "nodes",     "samplers",    "scenes",   "skins",
    "textures",  NULL,
};

// -- places and messages ------------------------------------------------------

gp_status gp_gltf_fail(const struct gp_json_place *at, const char *fmt, ...)
{
    char text[1024];
    va_list args;
    va_start(args, fmt);
    vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    return gp_json_fail(at, "%s; export the scene again", text);
}

/* Counts content that takes `bytes` of memory. */
static gp_status take(struct gp_gltf *g, size_t bytes)
{
    const size_t most = (size_t) MOST_FIXED + MOST_COPIES * g->file_bytes;
    if (bytes > most - g->taken)
        return gp_gltf_fail(&g->whole, "content out of proportion (over %zu "
                            "MiB from a file of %zu KiB)", most >> 20,
                            g->file_bytes >> 10);
    g->taken += bytes;
    return GP_OK;
}

gp_status gp_gltf_alloc(struct gp_gltf *g, size_t count, size_t size, void *out)
{
    memset(out, 0, sizeof(void *));
    return gp_gltf_grow(g, 0, count, size, out);
}

gp_status gp_gltf_grow(struct gp_gltf *g, size_t have, size_t more, size_t size,
                       void *out)
{
    void *block;
    gp_status st;
    memcpy(&block, out, sizeof block);
    GP_TRY(take(g, more * size));
    GP_TRY(gp_resize(g->log, g->path, (have + more) * size + 1, &block));
    memset((char *) block + have * size, 0, more * size);
    memcpy(out, &block, sizeof block);
out:
    return st;
}

// -- items --------------------------------------------------------------------

int gp_gltf_count(const struct gp_gltf *g, const char *list)
{
    return (int) json_array_size(json_object_get(g->root, list));
}

json_t *gp_gltf_item(const struct gp_gltf *g, const char *list, int index)
{
    return json_array_get(json_object_get(g->root, list), (size_t) index);
}

gp_status gp_gltf_index(const struct gp_gltf *g, const struct gp_json_place *at,
                        json_t *o, const char *key, const char *list, int *out)
{
    const int n = gp_gltf_count(g, list);
    *out = -1;
    const gp_status st = gp_json_int(at, o, key, 0, INT_MAX, out);
    if (!st && *out >= n)
        return gp_gltf_fail(at, "no such \"%s\" (found %d, \"%s\" has %d)", key,
                            *out, list, n);
    return st;
}

json_t *gp_gltf_extension(json_t *o, const char *name)
{
    return json_object_get(json_object_get(o, "extensions"), name);
}

void gp_gltf_name(json_t *o, char out[GP_SCENE_NAME])
{
    const char *const name = json_string_value(json_object_get(o, "name"));
    snprintf(out, GP_SCENE_NAME, "%s", name ? name : "");
    // no half of a UTF-8 character at the cut
    for (size_t i = 0; out[i];) {
        const size_t n = gp_utf8_bytes(out + i);
        if (!n)
            out[i] = '\0';
        i += n;
    }
    gp_make_printable(out);
}

// -- buffers ------------------------------------------------------------------

static int base64_value(char c)
{
    return c >= 'A' && c <= 'Z'   ? c - 'A'
           : c >= 'a' && c <= 'z' ? c - 'a' + 26
           : c >= '0' && c <= '9' ? c - '0' + 52
           : c == '+' || c == '-' ? 62
           : c == '/' || c == '_' ? 63
                                  : -1;
}

/* Decodes "data:TYPE;base64,TEXT" (RFC 2397, RFC 4648). */
static gp_status decode_uri(const struct gp_json_place *at, const char *uri,
                            struct gp_gltf_span *out)
{
    const char *const comma = strchr(uri, ',');
    if (!comma || comma - uri < 7 || memcmp(comma - 7, ";base64", 7) != 0)
        return gp_gltf_fail(at, "a data URI without \";base64,\"");
    const char *text = comma + 1;
    const size_t length = strlen(text);
    uint8_t *to;
    gp_status st = gp_alloc(at->log, at->path, length / 4 * 3 + 3, 1, &to);
    if (st)
        return st;
    unsigned bits = 0;
    int held = 0, n = 0;
    for (; *text && *text != '='; text++) {
        const int v = base64_value(*text);
        if (v < 0) {
            gp_free(to);
            return gp_gltf_fail(at, "a data URI with a character that is not "
                                "base64 (byte 0x%02x)", (unsigned char) *text);
        }
        bits = (bits << 6 | (unsigned) v) & 0xffffu;
        held += 6;
        if (held >= 8) {
            held -= 8;
            to[n++] = (uint8_t) (bits >> held);
        }
    }
    *out = (struct gp_gltf_span) {.at = to, .bytes = n, .own = to};
    return GP_OK;
}

/* Finds the bytes of a data URI, or the path of the file beside the scene that
 * another means, whose percent codes are undone. */
static gp_status resolve(const struct gp_gltf *g,
                         const struct gp_json_place *at, const char *uri,
                         struct gp_gltf_span *out)
{
    const char *const slash = strrchr(g->path, '/');
    const size_t folder = slash ? (size_t) (slash + 1 - g->path) : 0;
    if (strncmp(uri, "data:", 5) == 0)
        return decode_uri(at, uri, out);
    const gp_status st =
        gp_alloc(g->log, g->path, folder + strlen(uri) + 1, 1, &out->file);
    if (st)
        return st;
    memcpy(out->file, g->path, folder);
    char *const name = out->file + folder, *to = name;
    for (const char *from = uri; *from; from++) {
        const bool coded = *from == '%' && isxdigit((unsigned char) from[1]) &&
                           isxdigit((unsigned char) from[2]);
        const char digits[] = {coded ? from[1] : '0', coded ? from[2] : '0', 0};
        const long code = strtol(digits, NULL, 16); // 0 would end the name
        *to++ = code ? (char) code : *from;
        from += code ? 2 : 0;
    }
    *to = '\0';
    if (!*name || *name == '/' || strstr(name, "..") || strchr(uri, ':'))
        return gp_gltf_fail(at, "a URI that is no file beside the scene (found "
                            "\"%.100s\")", uri);
    return GP_OK;
}

static gp_status read_buffer(struct gp_gltf *g, int index)
{
    struct gp_gltf_span *const b = &g->buffer[index];
    const struct gp_json_place at = gp_gltf_at(g, "buffer", index);
    json_t *const o = gp_gltf_item(g, "buffers", index);
    const char *uri = NULL;
    uint64_t size;
    int declared = 0;
    gp_status st;
    GP_TRY(gp_json_int(&at, o, "byteLength", 1, MOST_FILE, &declared));
    GP_TRY(gp_json_text(&at, o, "uri", &uri));
    if (!uri && gp_gltf_extension(o, "EXT_meshopt_compression"))
        return GP_OK; // a fallback without bytes: who uses it gets none
    if (!uri && index == 0 && g->chunk.at)
        *b = g->chunk;
    else if (!uri)
        GP_TRY(gp_gltf_fail(&at, "no \"uri\", and no binary chunk"));
    else
        GP_TRY(resolve(g, &at, uri, b));
    if (b->file) {
        if (g->beside)
            GP_TRY(gp_gltf_fail(&at, "a second file beside the scene (found "
                                "\"%.100s\"); at most one is read", uri));
        g->beside = true;
        GP_TRY(gp_load_regular(g->log, b->file, (size_t) declared, &b->own,
                               &size));
        size = size < MOST_FILE ? size : MOST_FILE;
        b->at = b->own;
        b->bytes = (int) size;
        g->file_bytes += size < (uint64_t) declared ? size : (size_t) declared;
    }
    if (declared > b->bytes)
        GP_TRY(gp_gltf_fail(&at, "truncated (%d bytes, \"byteLength\" is %d)",
                            b->bytes, declared));
    b->bytes = declared;
out:
    return st;
}

gp_status gp_gltf_view(const struct gp_gltf *g, int index,
                       struct gp_gltf_span *out, int *stride)
{
    const struct gp_json_place at = gp_gltf_at(g, "buffer view", index);
    json_t *const o = gp_gltf_item(g, "bufferViews", index);
    int buffer = -1, offset = 0, bytes = 0;
    gp_status st;
    *stride = 0;
    GP_TRY(gp_gltf_index(g, &at, o, "buffer", "buffers", &buffer));
    if (buffer < 0)
        GP_TRY(gp_gltf_fail(&at, "no \"buffer\""));
    GP_TRY(gp_json_int(&at, o, "byteOffset", 0, MOST_FILE, &offset));
    GP_TRY(gp_json_int(&at, o, "byteLength", 1, MOST_FILE, &bytes));
    GP_TRY(gp_json_int(&at, o, "byteStride", 4, 252, stride));
    const struct gp_gltf_span all = g->buffer[buffer];
    if (offset > all.bytes || bytes > all.bytes - offset)
        GP_TRY(gp_gltf_fail(&at, "it leaves its buffer (bytes %d to %lld of "
                            "%d)", offset, (long long) offset + bytes,
                            all.bytes));
    *out = (struct gp_gltf_span) {.at = all.at ? all.at + offset : NULL,
                                  .bytes = bytes};
out:
    return st;
}

gp_status gp_gltf_image(const struct gp_gltf *g, int index,
                        struct gp_gltf_span *out)
{
    const struct gp_json_place at = gp_gltf_at(g, "image", index);
    json_t *const o = gp_gltf_item(g, "images", index);
    const char *uri = NULL;
    int view = -1, stride;
    gp_status st;
    GP_TRY(gp_json_text(&at, o, "uri", &uri));
    GP_TRY(gp_gltf_index(g, &at, o, "bufferView", "bufferViews", &view));
    if (view >= 0) {
        GP_TRY(gp_gltf_view(g, view, out, &stride));
        if (!out->at)
            GP_TRY(gp_gltf_fail(&at, "it has no bytes"));
    } else if (!uri) {
        GP_TRY(gp_gltf_fail(&at, "neither \"uri\" nor \"bufferView\""));
    } else {
        GP_TRY(resolve(g, &at, uri, out));
    }
out:
    return st;
}

// -- the file -----------------------------------------------------------------

/* Finds JSON and binary chunk of a .glb (specification, 4.4). */
static gp_status read_chunks(struct gp_gltf *g, struct gp_gltf_span *json)
{
    const uint8_t *const at = g->file;
    const size_t declared = gp_le32(at + 8);
    if (gp_le32(at + 4) != 2)
        return gp_gltf_fail(&g->whole, "binary glTF of version %u (2 is read)",
                            gp_le32(at + 4));
    if (declared > g->file_bytes || declared < GLB_HEADER)
        return gp_gltf_fail(&g->whole, "truncated (%zu bytes, its header "
                            "declares %zu)", g->file_bytes, declared);
    size_t from = GLB_HEADER;
    for (int i = 0; declared - from >= CHUNK_HEADER; i++) {
        const size_t bytes = gp_le32(at + from);
        const uint32_t type = gp_le32(at + from + 4);
        from += CHUNK_HEADER;
        if (bytes > declared - from)
            return gp_gltf_fail(&g->whole, "damaged (chunk %d of %zu bytes, "
                                "the file has %zu left)", i, bytes,
                                declared - from);
        const struct gp_gltf_span span = {.at = at + from,
                                          .bytes = (int) bytes};
        if (i == 0 && type == GLB_JSON)
            *json = span;
        else if (i == 1 && type == GLB_BINARY)
            g->chunk = span;
        from += bytes;
        from += from % 4 && declared - from >= 4 - from % 4 ? 4 - from % 4 : 0;
    }
    if (!json->at)
        return gp_gltf_fail(&g->whole, "damaged (its first chunk is not JSON)");
    return GP_OK;
}

static gp_status check_root(const struct gp_gltf *g)
{
    const char *version = "none", *least = "2.0";
    gp_status st;
    if (!json_is_object(g->root))
        return gp_gltf_fail(&g->whole, "not glTF (its JSON is no object)");
    json_t *const asset = json_object_get(g->root, "asset");
    GP_TRY(gp_json_text(&g->whole, asset, "version", &version));
    GP_TRY(gp_json_text(&g->whole, asset, "minVersion", &least));
    if (strncmp(version, "2.", 2) != 0 || strcmp(least, "2.0") != 0)
        return gp_gltf_fail(&g->whole, "not glTF 2.0 (\"version\" is %.20s, "
                            "\"minVersion\" %.20s)", version, least);
    for (int i = 0; lists[i]; i++) {
        json_t *const list = json_object_get(g->root, lists[i]);
        json_t *item;
        size_t k;
        if (list && !json_is_array(list))
            return gp_gltf_fail(&g->whole, "\"%s\" is not an array", lists[i]);
        json_array_foreach (list, k, item) {
            if (!json_is_object(item))
                return gp_gltf_fail(&g->whole, "\"%s\" %zu is not an object",
                                    lists[i], k);
        }
    }
out:
    return st;
}

/* Refuses files that cannot be read without an extension. */
static gp_status check_extensions(const struct gp_gltf *g)
{
    static const char *const known[] = {
        "KHR_lights_punctual", "KHR_mesh_quantization",
        "KHR_texture_transform", NULL,
    };
    // they change how a surface shines, not where it is
    static const char looks[] = "KHR_materials_";
    const json_t *const list = json_object_get(g->root, "extensionsRequired");
    const json_t *item;
    size_t k;
    json_array_foreach (list, k, item) {
        const char *const name = json_string_value(item);
        int i = 0;
        if (!name)
            return gp_gltf_fail(&g->whole, "\"extensionsRequired\" holds no "
                                "name");
        if (strncmp(name, looks, sizeof looks - 1) == 0)
            continue;
        while (known[i] && strcmp(known[i], name) != 0)
            i++;
        if (!known[i])
            return gp_gltf_fail(&g->whole, "it needs the extension %.60s, "
                                "which is not supported; leave it out (no "
                                "compression)", name);
    }
    return GP_OK;
}

gp_status gp_gltf_open(const struct gp_log *log, const char *path,
                       struct gp_gltf *out)
{
    struct gp_gltf_span json = {0};
    uint64_t size;
    gp_status st;
    out->log = log;
    out->path = path;
    out->whole = (struct gp_json_place) {.log = log, .path = path};
    GP_TRY(gp_load_regular(log, path, MOST_FILE, &out->file, &size));
    if (size > MOST_FILE)
        GP_TRY(gp_gltf_fail(&out->whole, "over 2 GiB"));
    out->file_bytes = (size_t) size;
    const bool binary =
        out->file_bytes >= 4 && memcmp(out->file, "glTF", 4) == 0;
    if (binary && out->file_bytes < GLB_HEADER)
        GP_TRY(gp_gltf_fail(&out->whole, "truncated (%zu bytes, the header of "
                            "a .glb has %d)", out->file_bytes, GLB_HEADER));
    if (binary)
        GP_TRY(read_chunks(out, &json));
    else
        json = (struct gp_gltf_span) {.at = out->file, .bytes = (int) size};
    const char *const text = (const char *) json.at;
    const size_t bytes = (size_t) json.bytes;
    const size_t memory = gp_json_memory(text, bytes);
    if (memory - bytes > MOST_JSON)
        GP_TRY(gp_fail(log, GP_ERR_DATA,
                       "%s: its JSON would take %zu MiB (%d "
                       "are allowed); export fewer objects",
                       path, memory >> 20, MOST_JSON >> 20));
    GP_TRY(take(out, memory));
    GP_TRY(gp_json_parse(log, path, text, bytes, &out->root));
    if (json.at == out->file)
        GP_FREE(out->file);
    GP_TRY(check_root(out));
    GP_TRY(check_extensions(out));
    out->buffers = gp_gltf_count(out, "buffers");
    GP_TRY(gp_alloc_zero(log, path, (size_t) out->buffers, sizeof *out->buffer,
                         &out->buffer));
    for (int i = 0; i < out->buffers; i++)
        GP_TRY(read_buffer(out, i));
out:
    return st;
}

void gp_gltf_close(struct gp_gltf *g)
{
    for (int i = 0; i < g->buffers && g->buffer; i++) {
        gp_free(g->buffer[i].own);
        gp_free(g->buffer[i].file);
    }
    gp_free(g->buffer);
    json_decref(g->root);
    gp_free(g->file);
    *g = (struct gp_gltf) {0};
}
